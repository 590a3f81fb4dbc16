// Checks the arguments of `NeuralSimplifier`; every error names the argument.

const INDEX_TYPES = [Uint32Array, Int32Array, Uint16Array, Int16Array];
const FLAGS = [
  'LockBorder', 'Sparse', 'ErrorAbsolute', 'Prune', 'Regularize', 'Permissive', 'RegularizeLight', 'PreserveFolds', 'ErrorClamped',
];
/** Throws a TypeError that names an argument unless a condition holds. */
export function check(holds, name, expected) {
  if (!holds) throw new TypeError(`${name}: ${expected}`);
}

function checkStride(stride, least, name) {
  check(Number.isInteger(stride) && stride >= least, name, `${stride} is not a whole number of at least ${least}`);
}

function checkRows(array, stride, nVertices, name) {
  check(array.length === stride * nVertices, name, `${array.length} numbers: give ${stride} for each of ${nVertices} vertices`);
}

/** Checks the class of indices, which may be any number. */
export function checkIndexType(indices) {
  check(INDEX_TYPES.some((type) => indices instanceof type), 'indices', 'give a Uint32Array, Int32Array, Uint16Array or Int16Array');
}

export function checkIndices(indices) {
  checkIndexType(indices);
  check(indices.length % 3 === 0, 'indices', `${indices.length} is not a multiple of 3`);
}

/** Checks positions and returns the number of vertices. */
export function checkPositions(positions, stride) {
  check(positions instanceof Float32Array, 'vertex_positions', 'give a Float32Array');
  checkStride(stride, 3, 'vertex_positions_stride');
  check(positions.length % stride === 0, 'vertex_positions', `${positions.length} numbers are not a multiple of the stride ${stride}`);
  return positions.length / stride;
}

export function checkTarget(target, nIndices) {
  check(target >= 0 && target <= nIndices, 'target_index_count', `${target} is not between 0 and ${nIndices}`);
  check(target % 3 === 0, 'target_index_count', `${target} is not a multiple of 3`);
}

export function checkError(error) {
  check(error >= 0, 'target_error', `${error} is not at least 0`);
}

export function checkAttributes(attributes, stride, weights, nVertices) {
  check(attributes instanceof Float32Array, 'vertex_attributes', 'give a Float32Array');
  checkStride(stride, 0, 'vertex_attributes_stride');
  checkRows(attributes, stride, nVertices, 'vertex_attributes');
  check(Array.isArray(weights), 'attribute_weights', 'give an array of numbers');
  check(weights.length <= stride, 'attribute_weights', `${weights.length} are more than the stride ${stride}`);
  check(weights.every((weight) => weight >= 0), 'attribute_weights', 'give weights of at least 0');
}

export function checkColors(colors, stride, nVertices) {
  check(colors instanceof Float32Array, 'vertex_colors', 'give a Float32Array');
  checkStride(stride, 3, 'vertex_colors_stride');
  checkRows(colors, stride, nVertices, 'vertex_colors');
}

/** Checks the number of vertices to keep. */
export function checkCount(count, nVertices) {
  check(count >= 0 && count <= nVertices, 'target_vertex_count', `${count} is not between 0 and ${nVertices}`);
}

export function checkLocks(locks, nVertices) {
  if (locks === null || locks === undefined) return;
  check(locks instanceof Uint8Array && locks.length === nVertices, 'vertex_lock', `give a Uint8Array of ${nVertices}, or null`);
}

export function checkGroups(groups, nFaces) {
  if (groups === null || groups === undefined) return;
  check(groups instanceof Uint32Array && groups.length === nFaces, 'groups', `give a Uint32Array of ${nFaces}`);
}

export function checkFlags(flags = []) {
  for (const flag of flags) check(FLAGS.includes(flag), 'flags', `${flag} is none of ${FLAGS.join(', ')}`);
}
