// Reads the data that the program packed into the page, as a source of a scene: surfaces, distances, covers, images.

import { withImages } from './finish.js';
import { bytesOf, numbersOf } from './numbers.js';
import { refined } from './refine.js';
import { allEdges, unpackCover, unpackShares, unpackSurface } from './surface.js';

/** Creates the source of the comparison that the page describes; scene.js defines sources. */
export function packedSource({ surfaces, covers, images }) {
  return {
    surface: (index, place) => unpackModel(surfaces[index], covers[index], index, place),
    shares: async ({ distances }, surfaces) => {
      const numbers = await numbersOf(distances);
      const [ofOriginal, ofResult] = surfaces.map(({ measured }) => measured.positions.length / 3);
      const shares = { ofResult: await unpackShares(ofResult, numbers), ofOriginal: await unpackShares(ofOriginal, numbers) };
      return { ...shares, surfaces: surfaces.map(({ fine, measured }) => (fine === measured ? null : measured)) };
    },
    hasCover: (index) => covers[index]?.paints.length > 0,
    cover: async (index, surface) => {
      const { paints, coloured } = covers[index];
      const known = (image) => (images[image] ? image : null);
      const painted = ({ finish, image, ...paint }) => ({ ...paint, image: known(image), finish: withImages(finish, known), coloured });
      return { ...(surface.cover ?? await unpackCoverOf(covers[index], index, surface)), paints: paints.map(painted) };
    },
    image: async (index) => new Blob(await bytesOf(`image-${index}`), { type: images[index].type }),
  };
}

/** Unpacks a surface, which is drawn with the normals of its file, if it has any, and in colours as it was measured. */
async function unpackModel(layout, coverLayout, index, place) {
  const surface = await unpackSurface(layout, await numbersOf(`surface-${index}`), place);
  const measured = layout.steps > 1 ? await refined(surface, layout.steps) : surface;
  const cover = coverLayout?.shaded ? await unpackCoverOf(coverLayout, index, surface) : null;
  const find = { findEdges: () => allEdges(surface), findMarked: async () => surface.marked };
  return { ...surface, cover, measured, fine: cover ?? measured, ...find };
}

async function unpackCoverOf(layout, index, surface) {
  return unpackCover(layout, await numbersOf(`cover-${index}`), surface);
}
