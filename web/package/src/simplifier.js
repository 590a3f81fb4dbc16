// Implements the members of meshoptimizer's `MeshoptSimplifier`, and an asynchronous version. See `types/simplifier.d.ts`.

import {
  check, checkAttributes, checkColors, checkCount, checkError, checkFlags, checkGroups, checkIndexType, checkIndices, checkLocks,
  checkPositions, checkTarget,
} from './checks.js';
import { compactIndices, firstEqualRows, wordsOf } from './remap.js';
import { makeProgram } from './runtime.js';
import { packRows, unpackRows } from './strided.js';
import packed from 'packed:simplifier';
import workerText from 'packed:worker';

export { NeuralMeshError } from './runtime.js';

/** Stands for an infinite error, which JSON cannot express; close to the largest single-precision number. */
const LARGEST_ERROR = 3e38;

const program = makeProgram(packed, workerText);
let ready = null;
let makeCall = null;
let call = null;

/** The members of `MeshoptSimplifier`, which are synchronous after `ready`. */
export const NeuralSimplifier = {
  supported: typeof WebAssembly === 'object',

  /** Unpacks the program on the first access. */
  get ready() {
    return (ready ??= program.instance().then((make) => { makeCall = make; }));
  },

  compactMesh(indices) {
    checkIndexType(indices);
    return compactIndices(indices);
  },

  generatePositionRemap(vertex_positions, vertex_positions_stride) {
    const nVertices = checkPositions(vertex_positions, vertex_positions_stride);
    const words = wordsOf(packRows(vertex_positions, vertex_positions_stride, 3));
    return firstEqualRows([{ words, width: 3 }], nVertices);
  },

  simplify(indices, vertex_positions, vertex_positions_stride, target_index_count, target_error, flags) {
    const surface = { indices, positions: vertex_positions, stride: vertex_positions_stride };
    return chosenIndices(indices, runNow(indicesRequest(surface, { target: target_index_count, error: target_error, flags })));
  },

  simplifyWithAttributes(
    indices, vertex_positions, vertex_positions_stride, vertex_attributes, vertex_attributes_stride, attribute_weights, vertex_lock,
    target_index_count, target_error, flags,
  ) {
    const surface = {
      indices, positions: vertex_positions, stride: vertex_positions_stride,
      attributes: vertex_attributes, attributesStride: vertex_attributes_stride, weights: attribute_weights, locks: vertex_lock,
    };
    return chosenIndices(indices, runNow(indicesRequest(surface, { target: target_index_count, error: target_error, flags })));
  },

  simplifyWithUpdate(
    indices, vertex_positions, vertex_positions_stride, vertex_attributes, vertex_attributes_stride, attribute_weights, vertex_lock,
    target_index_count, target_error, flags,
  ) {
    const surface = {
      indices, positions: vertex_positions, stride: vertex_positions_stride,
      attributes: vertex_attributes, attributesStride: vertex_attributes_stride, weights: attribute_weights, locks: vertex_lock,
    };
    const { json, array } = runNow(indicesRequest(surface, { target: target_index_count, error: target_error, flags, move: true }));
    const chosen = array(json.indices, Uint32Array);
    indices.set(chosen);
    unpackRows(array(json.positions, Float32Array), vertex_positions, vertex_positions_stride, 3);
    if (attribute_weights.length > 0) {
      unpackRows(array(json.attributes, Float32Array), vertex_attributes, vertex_attributes_stride, attribute_weights.length);
    }
    return [chosen.length, json.error];
  },

  getScale(vertex_positions, vertex_positions_stride) {
    checkPositions(vertex_positions, vertex_positions_stride);
    const [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    for (let i = 0; i < vertex_positions.length; i += vertex_positions_stride) {
      for (let axis = 0; axis < 3; axis++) {
        low[axis] = Math.min(low[axis], vertex_positions[i + axis]);
        high[axis] = Math.max(high[axis], vertex_positions[i + axis]);
      }
    }
    return Math.max(0, ...high.map((most, axis) => most - low[axis]));
  },

  simplifyPoints(vertex_positions, vertex_positions_stride, target_vertex_count, vertex_colors, vertex_colors_stride, color_weight) {
    const nVertices = checkPositions(vertex_positions, vertex_positions_stride);
    checkCount(target_vertex_count, nVertices);
    const request = { call: 'points', positions: packRows(vertex_positions, vertex_positions_stride, 3), target: target_vertex_count };
    if (vertex_colors) {
      checkColors(vertex_colors, vertex_colors_stride, nVertices);
      request.attributes = packRows(vertex_colors, vertex_colors_stride, 3);
      request.weights = [color_weight ?? 0];
    }
    const { json, array } = runNow(request);
    return array(json.indices, Uint32Array);
  },

  simplifySloppy(indices, vertex_positions, vertex_positions_stride, vertex_lock, target_index_count, target_error) {
    checkIndices(indices);
    const nVertices = checkPositions(vertex_positions, vertex_positions_stride);
    checkLocks(vertex_lock, nVertices);
    checkTarget(target_index_count, indices.length);
    checkError(target_error);
    const positions = packRows(vertex_positions, vertex_positions_stride, 3);
    const error = Math.min(target_error, LARGEST_ERROR);
    const request = { call: 'sloppy', indices: wideIndices(indices, nVertices), positions, target: target_index_count, error };
    if (vertex_lock) request.locks = vertex_lock;
    return chosenIndices(indices, runNow(request));
  },

  simplifyPrune(indices, vertex_positions, vertex_positions_stride, target_error) {
    checkIndices(indices);
    const nVertices = checkPositions(vertex_positions, vertex_positions_stride);
    checkError(target_error);
    const positions = packRows(vertex_positions, vertex_positions_stride, 3);
    const request = { call: 'prune', indices: wideIndices(indices, nVertices), positions, error: Math.min(target_error, LARGEST_ERROR) };
    return chosenIndices(indices, runNow(request))[0];
  },
};

/** Simplifies in a worker as `simplifyWithAttributes`, or with `move` as `simplifyWithUpdate`. */
export async function simplifyIndices(surface, { target, error = Infinity, flags, move, measure, progress, signal, worker } = {}) {
  const request = indicesRequest({ stride: 3, ...surface }, { target, error, flags, move });
  const answer = await program.call(request, { progress, signal, worker });
  const { positions, attributes, groups } = answer.json;
  const [indices, reached] = chosenIndices(surface.indices, answer);
  const result = { indices, error: reached };
  if (surface.groups) result.groups = indices.length > 0 ? answer.array(groups, Uint32Array) : new Uint32Array(0);
  if (move) result.positions = answer.array(positions, Float32Array);
  if (move && surface.weights?.length > 0) result.attributes = answer.array(attributes, Float32Array);
  if (measure) result.error = (await import('./measure.js')).measureError(surface, result, flags);
  return result;
}

/** Checks a surface and its goal, and returns the request. */
function indicesRequest(
  { indices, positions, stride, attributes, attributesStride, weights, locks, groups }, { target, error, flags, move },
) {
  checkIndices(indices);
  const nVertices = checkPositions(positions, stride);
  checkTarget(target, indices.length);
  checkError(error);
  checkFlags(flags);
  const request = {
    call: 'indices', indices: wideIndices(indices, nVertices), positions: packRows(positions, stride, 3),
    target, error: Math.min(error, LARGEST_ERROR), move, flags: flags ?? [],
  };
  if (attributes !== undefined || weights !== undefined) {
    checkAttributes(attributes, attributesStride, weights, nVertices);
    if (weights.length > 0) Object.assign(request, { attributes: packRows(attributes, attributesStride, weights.length), weights });
  }
  checkLocks(locks, nVertices);
  if (locks) request.locks = locks;
  checkGroups(groups, indices.length / 3);
  if (groups) request.groups = groups;
  return request;
}

/** Converts indices for the program, and checks that they name vertices; negative ones name none. */
function wideIndices(indices, nVertices) {
  const wide = indices instanceof Uint32Array ? indices : Uint32Array.from(indices);
  let largest = 0;
  for (let i = 0; i < wide.length; i++) if (wide[i] > largest) largest = wide[i];
  check(wide.length === 0 || largest < nVertices, 'indices', `one names vertex ${largest}, but there are only ${nVertices} vertices`);
  return wide;
}

/** Returns the triangles of an answer in the class of the caller's indices, and the error. */
function chosenIndices(indices, { json, array }) {
  const chosen = array(json.indices, Uint32Array);
  return [indices instanceof Uint32Array ? chosen : new indices.constructor(chosen), json.error];
}

/** Runs a request synchronously. A failed instance is not used again. */
function runNow(request) {
  if (!makeCall) throw new Error('NeuralSimplifier: await NeuralSimplifier.ready first');
  call ??= makeCall();
  try {
    return call(request);
  } catch (error) {
    call = null;
    throw error;
  }
}
