// Analyses screenshots in a separate page: covered share, share of a colour, difference of two.

/** Creates the page that analyses screenshots. */
export async function makeEye(browser) {
  const page = await browser.newPage();
  await page.evaluate(() => {
    globalThis.pixels = async (base64) => {
      const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
      const image = await createImageBitmap(new Blob([bytes]));
      const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
      context.drawImage(image, 0, 0);
      return context.getImageData(0, 0, image.width, image.height);
    };
    globalThis.mostly = ({ width, height, data }, channel) => {
      const found = { left: 0, right: 0, upper: 0, lower: 0 };
      for (let i = 0; i < data.length; i += 4) {
        const others = [0, 1, 2].filter((other) => other !== channel).map((other) => data[i + other]);
        if (data[i + channel] < Math.max(...others) + 60) continue;
        const [x, y] = [(i / 4) % width, Math.floor(i / 4 / width)];
        found[x < width / 2 ? 'left' : 'right'] += 2 / (width * height);
        found[y < height / 2 ? 'upper' : 'lower'] += 2 / (width * height);
      }
      return found;
    };
    globalThis.atBorder = ({ width, height, data }) => {
      const far = 4 * ((height - 10) * width + 10);
      let n = 0;
      for (let i = 0; i < data.length; i += 4) {
        const [x, y] = [(i / 4) % width, Math.floor(i / 4 / width)];
        const inside = Math.min(x, y, width - 1 - x, height - 1 - y);
        if (inside >= 4 && inside < 12 && [0, 1, 2].some((k) => Math.abs(data[i + k] - data[far + k]) > 8)) n++;
      }
      return n;
    };
    globalThis.differing = ({ data: a }, { data: b }, at) => {
      let n = 0;
      for (let i = 0; i < a.length; i += 4) {
        const j = at ?? i;
        if (Math.abs(a[i] - b[j]) + Math.abs(a[i + 1] - b[j + 1]) + Math.abs(a[i + 2] - b[j + 2]) > 24) n++;
      }
      return (4 * n) / a.length;
    };
  });
  return {
    /** Returns the share of pixels that differ from one near the lower left corner. */
    covered: (shot) => page.evaluate(async (shot) => {
      const image = await pixels(shot);
      return differing(image, image, 4 * ((image.height - 10) * image.width + 10));
    }, shot),
    /** Returns the number of pixels close to the border that differ from one near the lower left corner; rounded corners are left out. */
    atBorder: (shot) => page.evaluate(async (shot) => atBorder(await pixels(shot)), shot),
    /** Returns the shares of pixels in each half that are dominated by a channel. */
    mostly: (shot, channel) => page.evaluate(async ([shot, channel]) => mostly(await pixels(shot), channel), [shot, channel]),
    /** Returns the share of pixels that differ between two screenshots of equal size. */
    differing: (a, b) => page.evaluate(async ([a, b]) => differing(await pixels(a), await pixels(b)), [a, b]),
  };
}

/** Takes a screenshot of an element after pending drawing. */
export async function shoot(page, selector) {
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  return (await page.locator(selector).screenshot()).toString('base64');
}
