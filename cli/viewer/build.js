// Makes dist/viewer.html and dist/report.html of src: pages with style, script and the licence of three.js inside. `scripts/viewer`
// runs it.

import { readFileSync, mkdirSync, writeFileSync } from 'node:fs';
import { build } from 'esbuild';

const read = (path) => readFileSync(new URL(path, import.meta.url), 'utf8');
const folder = process.argv[2] ?? 'dist';
const licence = read('node_modules/three/LICENSE').trim();

async function bundled(file) {
  const bundle = await build({
    absWorkingDir: import.meta.dirname,
    entryPoints: [`src/${file}`],
    bundle: true,
    minify: true,
    write: false,
    format: 'iife',
    target: ['chrome110', 'firefox113', 'safari16.4'],
    legalComments: 'none',
  });
  return bundle.outputFiles[0].text.trim();
}

/** The parts of a page that others have as well, at the depth where they are named. */
function whole(page) {
  return page.replace(/^( *)<!-- (\w+\.html) -->\n/gm, (_, blanks, part) => read(`src/${part}`).replace(/^(?=.)/gm, blanks));
}

/** Writes a page of one entry point and style sheets. */
async function make(page, script, styles) {
  const [js, ...css] = await Promise.all([script, ...styles].map(bundled));
  // The replacements are functions because `$` means something in strings.
  const text = whole(read(`src/${page}`))
    .replace('/* style */', () => css.join(''))
    .replace('/* script */', () => js.replaceAll('</script', '<\\/script'))
    .replace(/<body.*>/, (body) => `${body}\n<!--\nThis page contains three.js (threejs.org):\n\n${licence}\n-->`);
  const name = `${folder}/${page === 'page.html' ? 'viewer.html' : page}`;
  writeFileSync(name, text);
  console.log(`${name}: ${Math.round(text.length / 1024)} KiB`);
}

mkdirSync(folder, { recursive: true });
await make('page.html', 'main.js', ['style.css']);
await make('report.html', 'report.js', ['style.css', 'report.css']);
writeFileSync(`${folder}/LICENSE-three`, `${licence}\n`);
