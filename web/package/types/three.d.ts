// The types of `neural-mesh/three`.

import type { BufferGeometry } from 'three';
import type { Goal } from './goal.js';

export type { Goal } from './goal.js';

/**
 * Simplifies a geometry in a worker and returns a new one.
 *
 * The result has all attributes, morph attributes and groups, and an index. Vertices that are equal in all attributes are merged.
 *
 * ```js
 * mesh.geometry = await simplifyModifier(mesh.geometry, { ratio: 0.25 });
 * ```
 *
 * @throws TypeError, RangeError if the geometry or an option is invalid
 * @throws NeuralMeshError if the program fails
 */
export function simplifyModifier(geometry: BufferGeometry, options: Goal): Promise<BufferGeometry>;
