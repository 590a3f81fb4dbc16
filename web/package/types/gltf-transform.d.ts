// The types of `neural-mesh/gltf-transform`.

import type { Transform } from '@gltf-transform/core';
import type { Goal } from './goal.js';

export type { Goal } from './goal.js';

/**
 * Makes a transform that simplifies each mesh of a document in place, in a worker. The primitives of a mesh stay joined.
 *
 * All attributes, morph targets, skins and materials are kept, and small integers stay such. Strips and fans become lists. Points and
 * lines stay. A primitive of which nothing remains leaves its mesh, and an empty mesh the document.
 *
 * Where it throws, the document is as it was.
 *
 * ```js
 * await document.transform(neuralSimplify({ ratio: 0.25 }));
 * ```
 *
 * @param options `faces` counts for each mesh
 * @throws TypeError, RangeError where an option cannot be used
 * @throws NeuralMeshError where the program fails
 */
export function neuralSimplify(options: Goal): Transform;
