// Tests messages between JavaScript and WebAssembly: they are restored, and broken ones are rejected.

import assert from 'node:assert/strict';
import test from 'node:test';

import { packMessage, unpackMessage } from '../src/message.js';

const broken = { name: 'NeuralMeshError', message: /^a message of the program is broken: [^\n]+$/ };

test('a message holds its JSON and its arrays', () => {
  const list = [Float64Array.of(0.5), Uint8Array.of(7)];
  const value = { call: 'x', a: { faces: Uint32Array.of(1, 2, 3) }, text: 'ä', list, none: new Uint8Array(0) };
  const { json, array } = unpackMessage(packMessage(value));
  assert.deepEqual(json, { call: 'x', a: { faces: 1 }, text: 'ä', list: [2, 3], none: 4 });
  assert.deepEqual(array(1, Uint32Array), Uint32Array.of(1, 2, 3));
  assert.deepEqual(array(2, Float64Array), Float64Array.of(0.5));
  assert.deepEqual(array(3), Uint8Array.of(7));
  assert.equal(array(4).length, 0);
});

test('each part begins at a multiple of 8', () => {
  for (let n = 0; n < 20; n++) {
    const message = packMessage(Array.from({ length: n }, (_, i) => new Uint8Array(i)));
    assert.equal(message.length % 8, 0);
    const header = new DataView(message.buffer);
    assert.equal(header.getUint32(0, true), n + 1);
    const sizes = Array.from({ length: n + 1 }, (_, i) => header.getUint32(4 + 4 * i, true));
    assert.deepEqual(sizes.slice(1), Array.from({ length: n }, (_, i) => i));
    const { json, array } = unpackMessage(message);
    json.forEach((part, i) => assert.equal(array(part).length, i));
  }
});

test('views of larger buffers are sent alone', () => {
  const words = Uint32Array.of(1, 2, 3, 4).subarray(1, 3);
  const { json, array } = unpackMessage(packMessage({ words, buffer: words.slice().buffer }));
  assert.deepEqual(array(json.words, Uint32Array), words);
  assert.deepEqual(array(json.buffer, Uint32Array), words);
});

test('a message is read at any offset', () => {
  const message = packMessage({ a: Uint16Array.of(5, 6) });
  const shifted = new Uint8Array(message.length + 3);
  shifted.set(message, 3);
  assert.deepEqual(unpackMessage(shifted.subarray(3)).array(1, Uint16Array), Uint16Array.of(5, 6));
});

test('messages cut short are refused', () => {
  const message = packMessage({ a: Uint8Array.of(1, 2, 3, 4, 5, 6, 7, 8) });
  for (let n = 0; n < message.length; n++) assert.throws(() => unpackMessage(message.slice(0, n)), broken);
});

test('a message that is no JSON is refused', () => {
  const message = packMessage({});
  message[8] = 0x7b;
  message[9] = 0x7b;
  assert.throws(() => unpackMessage(message), broken);
});

test('parts that are not there or do not fit are refused', () => {
  const { array } = unpackMessage(packMessage({ a: Uint8Array.of(1, 2, 3) }));
  for (const number of [0, 2, -1, undefined, 1.5, 'a']) assert.throws(() => array(number), broken);
  assert.throws(() => array(1, Uint32Array), broken);
});
