// The types of `neural-mesh/gltf-transform`.

import type { Transform } from '@gltf-transform/core';
import type { Goal } from './goal.js';

export type { Goal } from './goal.js';

/**
 * Creates a transform that simplifies each mesh of a document in place, in a worker. The primitives of a mesh stay joined.
 *
 * All attributes, morph targets, skins and materials are kept, and integer types stay. Strips and fans become lists. Points and lines
 * stay unchanged. Empty primitives and meshes are removed. If it throws, the document is unchanged.
 *
 * ```js
 * await document.transform(neuralSimplify({ ratio: 0.25 }));
 * ```
 *
 * @param options size of the result; `faces` is the number for each mesh
 * @throws TypeError, RangeError if an option is invalid
 * @throws NeuralMeshError if the program fails
 */
export function neuralSimplify(options: Goal): Transform;
