// Saves files to disk and copies text to the clipboard.

import { zip } from './zip.js';

/** Saves a file, in a ZIP archive if others belong to it. */
export function save({ name, bytes, beside }) {
  const others = Object.entries(beside).map(([path, of]) => ({ name: path, bytes: of }));
  const isAlone = others.length === 0;
  const blob = isAlone ? new Blob([bytes], { type: 'application/octet-stream' }) : zip([{ name, bytes }, ...others]);
  const link = Object.assign(document.createElement('a'), {
    href: URL.createObjectURL(blob), download: isAlone ? name : `${name.replace(/\.[^.]+$/, '')}.zip`,
  });
  link.click();
  // By then the browser has started the download.
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  return link.download;
}

/** Copies text to the clipboard, with the old method for pages from disk or without encryption. */
export async function copy(text) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    const area = Object.assign(document.createElement('textarea'), { value: text, className: 'aside' });
    const focused = document.activeElement;
    document.body.append(area);
    area.select();
    const isDone = document.execCommand('copy');
    area.remove();
    focused?.focus();
    if (!isDone) throw new Error('The browser does not let this page copy: select the text and copy it by hand.');
  }
}

/** Returns the number of bytes of a file with those that belong to it. */
export function sizeOf({ bytes, beside }) {
  return Object.values(beside).reduce((sum, other) => sum + other.length, bytes.length);
}
