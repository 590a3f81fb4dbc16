// The types of `neural-mesh/three`.

import type { BufferGeometry } from 'three';
import type { Goal } from './goal.js';

export type { Goal } from './goal.js';

/**
 * Makes a lighter geometry, in a worker. The one given stays as it is.
 *
 * The result has all attributes, morph attributes and groups, and an index. Vertices that are equal in everything become one.
 *
 * ```js
 * mesh.geometry = await simplifyModifier(mesh.geometry, { ratio: 0.25 });
 * ```
 *
 * @throws TypeError, RangeError where the geometry or an option cannot be used
 * @throws NeuralMeshError where the program fails
 */
export function simplifyModifier(geometry: BufferGeometry, options: Goal): Promise<BufferGeometry>;
