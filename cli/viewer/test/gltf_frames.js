// gltf_frames ORIGINAL LIGHTER FOLDER: draws both files at four times of their first animation in three.js, keeps the pictures
// and says how much they differ and how much each moves. `scripts/gltf_frames` runs it.

import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { build } from 'esbuild';
import { launch } from './browser.js';
import { makeEye } from './pixels.js';

const [original, lighter, folder] = process.argv.slice(2);
const SHARES = [0, 0.25, 0.5, 0.75];

const bundle = await build({
  absWorkingDir: import.meta.dirname, entryPoints: ['gltf_player.js'], bundle: true, write: false, format: 'iife',
});
const browser = await launch();
const eye = await makeEye(browser);
const page = await browser.newPage();
const complaints = [];
page.on('console', (message) => { if (message.type() === 'error') complaints.push(message.text()); });
page.on('pageerror', (error) => complaints.push(String(error)));
await page.setContent('<body></body>');
await page.addScriptTag({ content: bundle.outputFiles[0].text });

const draw = (path, around) => page.evaluate(
  ([bytes, shares, around]) => frames(bytes, shares, around),
  [readFileSync(path).toString('base64'), SHARES, around],
);
const a = await draw(original);
const b = await draw(lighter, a.around);
mkdirSync(folder, { recursive: true });
console.log(`animations: ${a.n_animations} and ${b.n_animations}`);
const far = ([low, high], [low2, high2]) => Math.max(...[0, 1, 2].flatMap((i) => [Math.abs(low[i] - low2[i]), Math.abs(high[i] - high2[i])]));
const size = ([low, high]) => Math.hypot(...[0, 1, 2].map((i) => high[i] - low[i]));
for (const [i, share] of SHARES.entries()) {
  const [x, y] = [a.pictures[i], b.pictures[i]];
  for (const [name, picture] of [['original', x], ['lighter', y]]) writeFileSync(`${folder}/${name}-${i}.png`, Buffer.from(picture.png, 'base64'));
  const differ = await eye.differing(x.png, y.png);
  const moved = await Promise.all([a, b].map((file) => eye.differing(file.pictures[0].png, file.pictures[i].png)));
  const percent = (share) => `${(100 * share).toFixed(2)} %`;
  console.log(`at ${share}: pixels that differ ${percent(differ)}, moved since the start ${moved.map(percent).join(' and ')}, `
    + `boxes apart ${percent(far(x.box, y.box) / size(x.box))} of the diagonal`);
}
complaints.forEach((complaint) => console.log(`complaint: ${complaint}`));
await browser.close();
process.exitCode = complaints.length > 0 ? 1 : 0;
