// Marks the point where two meshes are farthest apart with a ring that is drawn over all surfaces.

import { BufferAttribute, BufferGeometry, CanvasTexture, Points, PointsMaterial, Vector3 } from 'three';

const PIXELS = 44;
const COLOUR = '#d61878';

/** Creates a ring without a position. */
export function makeRing() {
  const geometry = new BufferGeometry().setAttribute('position', new BufferAttribute(new Float32Array(3), 3));
  const material = new PointsMaterial({
    map: new CanvasTexture(drawnRing()), size: PIXELS, sizeAttenuation: false, transparent: true, depthTest: false,
  });
  const ring = new Points(geometry, material);
  ring.frustumCulled = false;
  ring.renderOrder = 1;
  return ring;
}

function drawnRing() {
  const side = 4 * PIXELS;
  const canvas = Object.assign(document.createElement('canvas'), { width: side, height: side });
  const pen = canvas.getContext('2d');
  for (const [width, style] of [[28, 'rgb(255 255 255 / 75%)'], [14, COLOUR]]) {
    Object.assign(pen, { lineWidth: width, strokeStyle: style });
    pen.beginPath();
    pen.arc(side / 2, side / 2, side / 2 - 16, 0, 2 * Math.PI);
    pen.stroke();
  }
  return canvas;
}

/** Returns the point of the models with the largest distance, and its normal. */
export function farthestOf(models) {
  let found = { share: -1, point: new Vector3(), normal: new Vector3() };
  for (const { painted, plain } of models) {
    const { geometry } = painted ?? plain;
    const shares = geometry.getAttribute('uv').array;
    let at = 0;
    for (let i = 0; i < shares.length; i += 2) if (shares[i] > shares[at]) at = i;
    if (shares[at] <= found.share) continue;
    const vector = (name) => new Vector3().fromBufferAttribute(geometry.getAttribute(name), at / 2);
    found = { share: shares[at], point: vector('position'), normal: vector('normal') };
  }
  return found;
}
