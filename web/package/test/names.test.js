import assert from 'node:assert/strict';
import { test } from 'node:test';

import { readGoal } from '../src/goal.js';
import { checkNames } from '../src/names.js';

test('an unknown option names the nearest one', () => {
  for (const [unknown, nearest] of [['ratios', 'ratio'], ['lock_border', 'lockBorder'], ['lockborder', 'lockBorder'], ['face', 'faces']]) {
    const options = { ratio: 0.5, [unknown]: 1 };
    assert.throws(() => readGoal(options), { name: 'TypeError', message: `no such option: ${unknown}; did you mean ${nearest}?` });
  }
  assert.throws(() => readGoal({ quality: 1 }), { message: /^no such option: quality: choose from ratio, faces, error/ });
  assert.throws(() => checkNames({ ['x'.repeat(1000)]: 1 }, ['ratio']), ({ message }) => message.length < 150);
});

test('options that are no object say what to give', () => {
  for (const options of [0.1, null, 'ratio']) assert.throws(() => readGoal(options), { name: 'TypeError', message: /give \{ ratio: 0\.1 \}$/ });
  assert.throws(() => readGoal({}), { message: 'give ratio, faces or error, such as { ratio: 0.1 }' });
  assert.deepEqual(readGoal({ ratio: 0.5 }), { ratio: 0.5, faces: undefined, error: Infinity, lockBorder: false, move: true });
});
