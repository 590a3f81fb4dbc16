// Recipes that repeat a result outside the page: command line, Python, JavaScript.

/** Returns the recipes of a result, each {title, text}. */
export function recipesOf({ name, beside }, { size, options }, out) {
  const all = { ...size, ...options };
  return [
    { title: 'Command line', text: commandLine(name, all, out) },
    { title: 'Python', text: python(name, all, out) },
    { title: 'JavaScript', text: javaScript(name, Object.keys(beside), all, out) },
  ];
}

function commandLine(name, all, out) {
  const flags = Object.entries(all).flatMap(([option, value]) => {
    const flag = `--${option.replaceAll('_', '-')}`;
    if (value === true) return [flag];
    return [flag, option === 'ratio' ? `${Number((100 * value).toPrecision(6))}%` : quote(String(value))];
  });
  return ['neural-mesh simplify', quote(name), '-o', quote(out), ...flags].join(' ');
}

/** Quotes a word for a shell if needed. */
function quote(word) {
  const text = word.startsWith('-') ? `./${word}` : word;
  return /^[\w./%+-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`;
}

function python(name, all, out) {
  const values = Object.entries(all).map(([option, value]) => `${option}=${value === true ? 'True' : JSON.stringify(value)}`);
  return `import neural_mesh as nm\n\nnm.simplify(${[JSON.stringify(name), ...values, `out=${JSON.stringify(out)}`].join(', ')})`;
}

function javaScript(name, besides, all, out) {
  const of = (text) => `'${text.replaceAll('\\', '\\\\').replaceAll("'", "\\'")}'`;
  const value = (of_) => (typeof of_ === 'string' ? of(of_) : String(of_));
  const options = Object.entries(all).map(([option, chosen]) => `${option}: ${value(chosen)}`).join(', ');
  const files = besides.map((path) => `  ${of(path)}: await readFile(${of(path)}),\n`).join('');
  const beside = files && `const beside = {\n${files}};\n`;
  return `import { readFile, writeFile } from 'node:fs/promises';
import { basename } from 'node:path';
import { simplify } from 'neural-mesh';

${beside}const input = await readFile(${of(name)});
const { files } = await simplify(input, { ${options} }, { name: ${of(name)}, ${beside && 'beside, '}out: ${of(out)} });
for (const file of files.flatMap((file) => [file, ...(file.beside ?? [])])) await writeFile(basename(file.name), file.bytes);`;
}
