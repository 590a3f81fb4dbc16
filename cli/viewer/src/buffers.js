// Buffers of three.js of which a part is drawn.

/** Sends the first n numbers of an attribute to the graphics card before the next frame. */
export function sendFirst(attribute, n) {
  attribute.clearUpdateRanges();
  attribute.addUpdateRange(0, n);
  attribute.needsUpdate = true;
}
