// What pages hold for all readers: contrast, names, keyboard, and a layout that stays.

import assert from 'node:assert/strict';

/** Collects layout shifts that do not follow an action of the reader in `globalThis.shifts`; runs in the page. */
export function recordShifts() {
  globalThis.shifts = [];
  new PerformanceObserver((list) => globalThis.shifts.push(...list.getEntries().filter((one) => !one.hadRecentInput).map(({ value, sources }) => (
    [value, ...sources.map(({ node }) => node?.id || node?.className || node?.nodeName)]))))
    .observe({ type: 'layout-shift', buffered: true });
}

/** Presses Tab through a page, and asserts that it reaches every visible control, each with a focus that is seen. */
export async function walksByKeyboard(page) {
  const wanted = await page.evaluate(() => {
    const reachable = 'button, input, select, summary, [tabindex="0"]';
    const all = [...document.querySelectorAll(reachable)].filter((one) => one.checkVisibility() && !one.disabled);
    all.forEach((one, i) => { one.dataset.walk = i; });
    document.activeElement.blur();
    return all.map((one) => one.id || one.getAttribute('aria-label') || one.textContent.trim().slice(0, 20));
  });
  const reached = new Set();
  for (let i = 0; i < wanted.length + 5; i++) {
    await page.keyboard.press('Tab');
    const seen = await page.evaluate(() => {
      const one = document.activeElement;
      if (!one.dataset.walk) return null;
      const elements = [one, one.closest('.chip')].filter(Boolean);
      const styles = elements.flatMap((of) => [null, '::after'].map((part) => getComputedStyle(of, part)));
      const hasOutline = ({ outlineStyle, outlineWidth }) => outlineStyle !== 'none' && parseFloat(outlineWidth) >= 1;
      return { walk: Number(one.dataset.walk), isSeen: styles.some(hasOutline) };
    });
    if (!seen) continue;
    reached.add(seen.walk);
    assert.ok(seen.isSeen, `the focus of ${wanted[seen.walk]} is not seen`);
  }
  assert.deepEqual(wanted.filter((_, i) => !reached.has(i)), []);
}

/** Returns the controls of a page without a name. */
export function namelessControls(page) {
  return page.evaluate(() => [...document.querySelectorAll('button, input:not([hidden]), select, canvas:not([aria-hidden]), [role]')]
    .filter((one) => !['alert', 'status'].includes(one.role) && !one.getAttribute('aria-labelledby'))
    .filter((one) => !(one.ariaLabel || one.labels?.length || one.textContent.trim()))
    .map((one) => one.outerHTML));
}

/** Returns the visible words of a page whose contrast is below 4.5. */
export function weakWords(page) {
  return page.evaluate(() => {
    const channels = (colour) => colour.match(/[\d.]+/g).map(Number);
    const luminance = (rgb) => rgb.slice(0, 3).map((c) => c / 255).map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
      .reduce((sum, c, i) => sum + c * [0.2126, 0.7152, 0.0722][i], 0);
    const behind = (one) => {
      for (let at = one; at; at = at.parentElement) {
        const colour = channels(getComputedStyle(at).backgroundColor);
        if (colour.length === 3 || colour[3] === 1) return colour;
      }
      return [255, 255, 255];
    };
    const hasText = (one) => [...one.childNodes].some((node) => node.nodeType === 3 && node.data.trim());
    const isRead = (one) => hasText(one) && one.checkVisibility() && !one.closest('[inert], :disabled, script, style, noscript');
    return [...document.querySelectorAll('body *')].filter(isRead)
      .map((one) => {
        const [a, b] = [luminance(channels(getComputedStyle(one).color)), luminance(behind(one))];
        return { text: one.textContent.trim().slice(0, 30), ratio: (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05) };
      }).filter(({ ratio }) => ratio < 4.5);
  });
}
