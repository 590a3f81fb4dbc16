// Frames per second, from the times of the last frames.

/** Milliseconds over which frames are counted; a longer gap means that the view was at rest. */
const SPAN = 1000;

/** Creates an empty record of frames. */
export function makeRates() {
  return { times: [], triangles: 0 };
}

/** Records a frame, its time in milliseconds, and its number of drawn triangles. */
export function noteFrame(rates, time, triangles) {
  if (time - rates.times.at(-1) > SPAN / 2) rates.times = [];
  rates.times = [...rates.times.filter((earlier) => time - earlier < SPAN), time];
  rates.triangles = triangles;
}

/** Returns the triangles of the last frame, and the frames per second; null if the view is at rest. */
export function ratesOf({ times, triangles }, now) {
  const isMoving = times.length > 2 && now - times.at(-1) < SPAN / 2;
  return { triangles, perSecond: isMoving ? (1000 * (times.length - 1)) / (times.at(-1) - times[0]) : null };
}
