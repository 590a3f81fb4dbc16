// Runs the tests that meshoptimizer and glTF-Transform have for their simplifiers with `NeuralSimplifier` in its place, and lists by name
// what fails. `node test/peers.js [REPOSITORY]`: where glTF-Transform is cloned from, which needs git and, by default, a network.
//
// Tests of meshoptimizer compare index by index. Where these fail, a second line says whether the triangles are the same in another order.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { build } from 'esbuild';

const repository = process.argv[2] ?? 'https://github.com/donmccurdy/glTF-Transform';
const here = import.meta.dirname;
const require = createRequire(import.meta.url);
const ours = pathToFileURL(join(here, '../dist/simplifier.js')).href;
const folder = mkdtempSync(join(tmpdir(), 'peers-'));

/** Tests of meshoptimizer: functions in an object `tests`, of which the file exports nothing, so that its last lines are exchanged. */
async function meshoptimizerTests(assertions) {
  const text = readFileSync(join(require.resolve('meshoptimizer'), '../meshopt_simplifier.test.js'), 'utf8');
  const parts = [/import assert from 'assert\/strict';/, /import \{ MeshoptSimplifier as simplifier \} from '[^']*';/, /\nPromise\.all\([^]*$/];
  if (parts.some((part) => !part.test(text))) throw new Error('the tests of meshoptimizer look different now: see test/peers.js');
  const file = join(folder, `meshoptimizer-${assertions}.mjs`);
  const exchanged = [STANDINS[assertions], `import { NeuralSimplifier as simplifier } from '${ours}';`, '\nexport { tests, simplifier };\n'];
  writeFileSync(file, parts.reduce((changed, part, i) => changed.replace(part, () => exchanged[i]), text));
  const { tests: list, simplifier } = await import(pathToFileURL(file));
  await simplifier.ready;
  return Object.entries(list);
}

/** Modules in place of those that the tests import. */
const STANDINS = {
  'in any order': `import strict from 'assert/strict';
    const triangles = (indices) => Array.from({ length: indices.length / 3 }, (_, i) => {
      const [a, b, c] = indices.subarray(3 * i, 3 * i + 3);
      return [[a, b, c], [b, c, a], [c, a, b]].sort()[0].join();
    }).sort();
    const assert = (...given) => strict(...given);
    assert.equal = strict.equal;
    assert.deepEqual = (one, other) => (one.length % 3 ? strict.deepEqual(one, other) : strict.deepEqual(triangles(one), triangles(other)));`,
  'as they are': "import assert from 'assert/strict';",
  ava: 'export default (name, run) => { globalThis.peerTests.push([name, run]); };',
  meshoptimizer: `export { NeuralSimplifier as MeshoptSimplifier } from '${ours}';`,
};

async function gltfTransformTests() {
  execFileSync('git', ['clone', '--quiet', '--depth', '1', repository.startsWith('/') ? `file://${repository}` : repository, join(folder, 'gltf')]);
  globalThis.peerTests = [];
  const outfile = join(folder, 'gltf/packages/functions/test/simplify.mjs');
  const peers = {
    name: 'peers',
    setup(bundler) {
      bundler.onResolve({ filter: /^(ava|meshoptimizer)$/ }, ({ path }) => ({ path, namespace: 'peers' }));
      bundler.onLoad({ filter: /./, namespace: 'peers' }, ({ path }) => ({ contents: STANDINS[path] }));
      bundler.onResolve({ filter: /^@gltf-transform\/test-utils$/ }, () => ({ path: join(folder, 'gltf/packages/test-utils/src/index.ts') }));
      bundler.onResolve({ filter: /^file:/ }, ({ path }) => ({ path, external: true }));
      bundler.onResolve({ filter: /^(draco3dgltf|three|@gltf-transform\/(core|functions|extensions))$/ }, ({ path }) =>
        ({ path: import.meta.resolve(path), external: true }));
    },
  };
  await build({
    entryPoints: [join(folder, 'gltf/packages/functions/test/simplify.test.ts')], outfile, bundle: true, format: 'esm', platform: 'node',
    plugins: [peers], nodePaths: [join(here, '../node_modules')], logLevel: 'error', tsconfigRaw: '{}',
  });
  await import(pathToFileURL(outfile));
  return globalThis.peerTests.map(([name, run]) => [name, () => run(assertions())]);
}

/** The assertions of ava that the tests use. */
function assertions() {
  const hold = (holds, words) => { if (!holds) throw new Error(words); };
  const text = (value) => JSON.stringify(value);
  return {
    truthy: (value, words) => hold(value, words),
    true: (value, words) => hold(value === true, words),
    false: (value, words) => hold(value === false, words),
    is: (value, expected, words) => hold(Object.is(value, expected), `${words}: ${text(value)} is not ${text(expected)}`),
    deepEqual: (value, expected, words) => hold(text(value) === text(expected), `${words}: ${text(value)} is not ${text(expected)}`),
  };
}

async function runAll(owner, tests) {
  let passed = 0;
  for (const [name, run] of tests) {
    try {
      await run();
      passed++;
    } catch (error) {
      console.log(`${owner}: ${name}: ${error.message.split('\n')[0]}`);
    }
  }
  console.log(`${owner}: ${passed} of ${tests.length} pass`);
}

try {
  await runAll('meshoptimizer', await meshoptimizerTests('as they are'));
  await runAll('meshoptimizer, triangles in any order', await meshoptimizerTests('in any order'));
  await runAll('glTF-Transform', await gltfTransformTests());
} finally {
  rmSync(folder, { recursive: true });
}
