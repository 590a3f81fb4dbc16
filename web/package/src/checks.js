// Checks of the arguments of `NeuralSimplifier`, each with a line that names the argument.

const INDEX_TYPES = [Uint32Array, Int32Array, Uint16Array, Int16Array];
const FLAGS = [
  'LockBorder', 'Sparse', 'ErrorAbsolute', 'Prune', 'Regularize', 'Permissive', 'RegularizeLight', 'PreserveFolds', 'ErrorClamped',
];
/** As many attributes as `MeshoptSimplifier` takes for each vertex. */
const MOST_ATTRIBUTES = 32;

/** Throws where a condition does not hold. */
export function check(holds, name, expected) {
  if (!holds) throw new TypeError(`${name}: ${expected}`);
}

export function checkIndices(indices) {
  check(INDEX_TYPES.some((type) => indices instanceof type), 'indices', 'give a Uint32Array, Int32Array, Uint16Array or Int16Array');
  check(indices.length % 3 === 0, 'indices', `${indices.length} is no multiple of 3`);
}

/** Returns the number of vertices. */
export function checkPositions(positions, stride) {
  check(positions instanceof Float32Array, 'vertex_positions', 'give a Float32Array');
  check(Number.isInteger(stride) && stride >= 3, 'vertex_positions_stride', `${stride} is no whole number of at least 3`);
  check(positions.length % stride === 0, 'vertex_positions', `${positions.length} numbers are no multiple of the stride ${stride}`);
  return positions.length / stride;
}

export function checkTarget(target, nIndices) {
  check(target >= 0 && target <= nIndices, 'target_index_count', `${target} is not between 0 and ${nIndices}`);
  check(target % 3 === 0, 'target_index_count', `${target} is no multiple of 3`);
}

export function checkError(error) {
  check(error >= 0, 'target_error', `${error} is not at least 0`);
}

export function checkAttributes(attributes, stride, weights, nVertices) {
  check(attributes instanceof Float32Array, 'vertex_attributes', 'give a Float32Array');
  check(Number.isInteger(stride) && stride >= 0, 'vertex_attributes_stride', `${stride} is no whole number of at least 0`);
  check(attributes.length === stride * nVertices, 'vertex_attributes', `${attributes.length} numbers are not ${stride} for each of ${nVertices} vertices`);
  check(Array.isArray(weights), 'attribute_weights', 'give an array of numbers');
  check(weights.length <= Math.min(stride, MOST_ATTRIBUTES), 'attribute_weights', `${weights.length} are more than the stride ${stride}, or than ${MOST_ATTRIBUTES}`);
  check(weights.every((weight) => weight >= 0), 'attribute_weights', 'each is at least 0');
}

export function checkLocks(locks, nVertices) {
  if (locks === null || locks === undefined) return;
  check(locks instanceof Uint8Array && locks.length === nVertices, 'vertex_lock', `give a Uint8Array of ${nVertices}, or null`);
}

export function checkFlags(flags = []) {
  for (const flag of flags) check(FLAGS.includes(flag), 'flags', `${flag} is none of ${FLAGS.join(', ')}`);
}
