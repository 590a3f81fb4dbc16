// The types compile in a strict program that uses all of the interface.

import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { createRequire } from 'node:module';
import { dirname, join } from 'node:path';
import test from 'node:test';

test('a program that uses all of the interface compiles', () => {
  const compiler = join(dirname(createRequire(import.meta.url).resolve('typescript/package.json')), 'bin/tsc');
  const { status, stdout, stderr } = spawnSync(process.execPath, [compiler, '--project', join(import.meta.dirname, 'types')], { encoding: 'utf8' });
  assert.equal(status, 0, stdout + stderr);
});
