// One mesh in a view: it is centered, scaled, and turned.

import { Group, Vector3 } from 'three';
import { askToDraw, lookFromStart, setPlace } from './view.js';

/** Direction from which a mesh is first seen. */
const EYE = [0.55, 0.4, 1];

/** Box of a view before there is a mesh. */
export const BOX = { half: [0.58, 0.58, 0.58], radius: 1, eye: EYE };

/** Adds groups for a mesh to a view: the body moves the mesh to the origin, the root scales and turns it. */
export function addGroups(view) {
  const [root, body] = [new Group(), new Group()];
  root.add(body);
  view.scenes[0].scene.add(root);
  return { root, body };
}

/** Centers the box of points, whose diagonal becomes 2, and looks at all of it; `points` calls its argument with x, y, z of each. */
export function placeBox({ view, root, body }, points) {
  const [low, high] = [new Vector3().setScalar(Infinity), new Vector3().setScalar(-Infinity)];
  const point = new Vector3();
  points((x, y, z) => {
    point.set(x, y, z);
    low.min(point);
    high.max(point);
  });
  const sides = high.clone().sub(low);
  const scale = 2 / (sides.length() || 1);
  body.position.addVectors(low, high).multiplyScalar(-0.5);
  root.scale.setScalar(scale);
  const half = sides.multiplyScalar(0.5 * scale).toArray();
  setPlace(view, { half, radius: Math.hypot(...half), eye: EYE });
  lookFromStart(view);
}

/** Turns a mesh so that the axis that is up in its file is up in the view. */
export function turnUp({ view, root }, isZUp) {
  root.rotation.x = isZUp ? -Math.PI / 2 : 0;
  askToDraw(view);
}
