// Reads the data that the program packed into the page, as a source of a scene: surfaces, distances, covers, images.

import { bytesOf, numbersOf } from './numbers.js';
import { refined } from './refine.js';
import { allEdges, unpackCover, unpackShares, unpackSurface } from './surface.js';

/** Creates the source of the comparison that the page describes; scene.js defines sources. */
export function packedSource({ surfaces, covers, images }) {
  return {
    surface: (index, place) => unpackModel(surfaces[index], index, place),
    shares: async ({ distances }, { nOfOriginal, nOfResult }) => {
      const numbers = await numbersOf(distances);
      const ofResult = await unpackShares(nOfResult, numbers);
      return { ofResult, ofOriginal: await unpackShares(nOfOriginal, numbers) };
    },
    hasCover: (index) => Boolean(covers[index]),
    cover: async (index, surface) => {
      const { paints, coloured } = covers[index];
      const cover = await unpackCover(covers[index], await numbersOf(`cover-${index}`), surface);
      return { ...cover, paints: paints.map((paint) => ({ ...paint, image: images[paint.image] ? paint.image : null, coloured })) };
    },
    image: async (index) => new Blob(await bytesOf(`image-${index}`), { type: images[index].type }),
  };
}

async function unpackModel(layout, index, place) {
  const surface = await unpackSurface(layout, await numbersOf(`surface-${index}`), place);
  const fine = layout.steps > 1 ? await refined(surface, layout.steps) : surface;
  return { ...surface, fine, findEdges: () => allEdges(surface), findMarked: async () => surface.marked };
}
