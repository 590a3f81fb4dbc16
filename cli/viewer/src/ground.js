// The ground under the meshes of a view: a plane that shows only their soft shadow.

import { DirectionalLight, Mesh, PlaneGeometry, ShadowMaterial, VSMShadowMap } from 'three';

/** Side of the ground and of the shadow's picture, over the radius of the meshes. */
const REACH = 3;

/** Adds a ground to each scene of a view; `layGround` puts it under a box. */
export function addGround(view) {
  view.renderer.shadowMap.enabled = true;
  view.renderer.shadowMap.autoUpdate = false;
  view.renderer.shadowMap.type = VSMShadowMap;
  view.grounds = view.scenes.map(({ scene }) => {
    // The sun only casts the shadow; the other lights shade.
    const sun = new DirectionalLight(0xffffff, 0.01);
    sun.castShadow = true;
    // The shadow is blurred so far that more pixels would not show.
    sun.shadow.mapSize.set(256, 256);
    Object.assign(sun.shadow, { radius: 4.5, blurSamples: 8, bias: -0.0005 });
    const plane = new Mesh(new PlaneGeometry(1, 1), new ShadowMaterial({ opacity: 0.28, transparent: true, depthWrite: false }));
    plane.rotation.x = -Math.PI / 2;
    plane.receiveShadow = true;
    plane.renderOrder = -1;
    scene.add(sun, sun.target, plane);
    return { sun, plane };
  });
}

/** Puts the ground under a box around the origin with these half sides. */
export function layGround({ grounds, half, radius }) {
  for (const { sun, plane } of grounds) {
    plane.position.y = -half[1] * 1.002;
    plane.scale.setScalar(2 * REACH * radius);
    sun.position.set(0.12 * radius, 2 * REACH * radius, 0.08 * radius);
    Object.assign(sun.shadow.camera, {
      left: -REACH * radius, right: REACH * radius, top: REACH * radius, bottom: -REACH * radius, near: 0.1 * radius, far: 4 * REACH * radius,
    });
    sun.shadow.camera.updateProjectionMatrix();
  }
}
