// Sizes that the slider steps through.

/** Steps of the slider that halve the size. */
export const PER_HALVING = 64;
/** Steps at each side of a proved level that show it, so that it is easy to meet. */
const NEAR = 2.5;

/** Returns numbers of vertices from the least to the most, in equal ratios; those close to a proved level's become its own. */
export function sizesBetween(least, most, proofs) {
  const nSteps = Math.max(Math.ceil(PER_HALVING * Math.log2(most / Math.max(least, 1))), 1);
  const size = (step) => Math.max(Math.floor(most * 2 ** (-step / PER_HALVING)), least);
  const sizes = Array.from({ length: nSteps + 1 }, (_, i) => size(nSteps - i));
  // The ends stay those of the progression.
  return sizes.map((n, i) => (i === 0 || i === nSteps ? n : proofs.find((proof) => isNear(n, proof.nVertices))?.nVertices ?? n));
}

function isNear(n, proved) {
  return Math.abs(Math.log2(n / proved)) < NEAR / PER_HALVING;
}
