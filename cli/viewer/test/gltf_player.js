// Draws frames of glTF files with three.js, for gltf_frames.js.

import * as THREE from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';

const SIZE = 512;

/** Loads a GLB from base64; `share(t)` puts its first animation at a share of its duration. */
async function load(base64) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const { scene, animations } = await new GLTFLoader().parseAsync(bytes.buffer, '');
  const mixer = new THREE.AnimationMixer(scene);
  if (animations.length > 0) mixer.clipAction(animations[0]).play();
  const share = (t) => { mixer.setTime(animations.length > 0 ? t * animations[0].duration * 0.999 : 0); scene.updateMatrixWorld(true); };
  return { scene, share, n_animations: animations.length };
}

/** Returns the bounding box of all vertices after skinning and morphing. */
function box(scene) {
  const box = new THREE.Box3();
  scene.traverse((node) => { if (node.isMesh) box.expandByObject(node, true); });
  return box;
}

const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
renderer.setSize(SIZE, SIZE);
document.body.append(renderer.domElement);
renderer.setClearColor('#ffffff');

/** Draws frames of a file at shares of its first animation, with a camera that fits the box `around`, or all frames. */
globalThis.frames = async (base64, shares, around) => {
  const { scene, share, n_animations } = await load(base64);
  const stage = new THREE.Scene();
  stage.add(scene, new THREE.HemisphereLight('#ffffff', '#888888', 3));
  const all = new THREE.Box3();
  if (around) all.set(new THREE.Vector3(...around[0]), new THREE.Vector3(...around[1]));
  else shares.forEach((t) => { share(t); all.union(box(scene)); });
  const centre = all.getCenter(new THREE.Vector3());
  const radius = all.getSize(new THREE.Vector3()).length() / 2;
  const camera = new THREE.PerspectiveCamera(40, 1, radius / 100, radius * 100);
  camera.position.copy(centre).add(new THREE.Vector3(0.5, 0.35, 1).normalize().multiplyScalar(radius * 3));
  camera.lookAt(centre);
  const pictures = shares.map((t) => {
    share(t);
    renderer.render(stage, camera);
    const { min, max } = box(scene);
    return { png: renderer.domElement.toDataURL().split(',')[1], box: [min.toArray(), max.toArray()] };
  });
  return { pictures, around: [all.min.toArray(), all.max.toArray()], n_animations };
};
