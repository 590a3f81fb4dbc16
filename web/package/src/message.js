// Encodes messages between JavaScript and WebAssembly: a JSON object and the arrays that it refers to, as bytes.
//
//     u32 number of parts | u32 bytes of each part | zeros up to a multiple of 8 | part 0 | zeros | part 1 | zeros ...
//
// All numbers are little-endian. Part 0 is the JSON in UTF-8, which refers to the other parts by their numbers.

import { NeuralMeshError } from './error.js';

const padded = (nBytes) => Math.ceil(nBytes / 8) * 8;
const headerBytes = (nParts) => padded(4 + 4 * nParts);

/** Packs a value into a message; its typed arrays and array buffers become parts. */
export function packMessage(value) {
  const { nBytes, write } = planMessage(value);
  const message = new Uint8Array(nBytes);
  write(message);
  return message;
}

/** Returns the length of the message of a value, and a function that writes it into so many zeros. */
export function planMessage(value) {
  const parts = [null];
  const named = (_, field) => {
    const bytes = bytesOf(field);
    return bytes ? parts.push(bytes) - 1 : field;
  };
  parts[0] = new TextEncoder().encode(JSON.stringify(value, named));
  const nBytes = headerBytes(parts.length) + parts.reduce((sum, part) => sum + padded(part.length), 0);
  const write = (message) => {
    const header = new DataView(message.buffer, message.byteOffset);
    header.setUint32(0, parts.length, true);
    let at = headerBytes(parts.length);
    parts.forEach((part, i) => {
      header.setUint32(4 + 4 * i, part.length, true);
      message.set(part, at);
      at += padded(part.length);
    });
  };
  return { nBytes, write };
}

/**
 * Unpacks a message into its JSON and a function from the number of a part to its array.
 *
 * @param {Uint8Array} message bytes; the arrays are copies of them
 * @returns {{json: object, array: (number: number, type?: Function) => ArrayBufferView}} `array` reads bytes unless `type` is another
 *   class of typed arrays
 * @throws {NeuralMeshError} if the message is truncated or refers to a missing part
 */
export function unpackMessage(message) {
  const parts = readParts(message);
  const array = (number, type = Uint8Array) => {
    const part = parts[number];
    if (!(number > 0) || !part) throw broken(`it names part ${number}, but there are only ${parts.length}`);
    if (part.length % type.BYTES_PER_ELEMENT !== 0) throw broken(`part ${number} has ${part.length} bytes`);
    return new type(part.slice().buffer);
  };
  return { json: readJson(parts[0]), array };
}

/** Returns the parts as views of the message. */
function readParts(message) {
  const header = new DataView(message.buffer, message.byteOffset, message.byteLength);
  const nParts = message.length < 4 ? 0 : header.getUint32(0, true);
  if (nParts === 0 || message.length < headerBytes(nParts)) throw broken(`${message.length} bytes are too few for a message`);
  let at = headerBytes(nParts);
  return Array.from({ length: nParts }, (_, i) => {
    const nBytes = header.getUint32(4 + 4 * i, true);
    if (at + nBytes > message.length) throw broken(`part ${i} ends behind its last byte`);
    const part = message.subarray(at, at + nBytes);
    at += padded(nBytes);
    return part;
  });
}

function readJson(part) {
  try {
    return JSON.parse(new TextDecoder().decode(part));
  } catch (error) {
    throw broken(error.message);
  }
}

/** Returns the bytes of a typed array or buffer, or null for anything else. */
function bytesOf(value) {
  if (value instanceof ArrayBuffer) return new Uint8Array(value);
  return ArrayBuffer.isView(value) ? new Uint8Array(value.buffer, value.byteOffset, value.byteLength) : null;
}

function broken(why) {
  return new NeuralMeshError(`a message of the program is broken: ${why}`);
}
