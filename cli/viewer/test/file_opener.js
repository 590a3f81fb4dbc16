// Opens files with the loaders of three.js, for open_files.js.

import * as THREE from 'three';
import { GLTFLoader } from 'three/examples/jsm/loaders/GLTFLoader.js';
import { OBJLoader } from 'three/examples/jsm/loaders/OBJLoader.js';
import { PLYLoader } from 'three/examples/jsm/loaders/PLYLoader.js';
import { STLLoader } from 'three/examples/jsm/loaders/STLLoader.js';

const asMesh = (geometry) => new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ side: THREE.DoubleSide }));
const LOADERS = {
  '.obj': async (url) => new OBJLoader().loadAsync(url),
  '.ply': async (url) => asMesh(await new PLYLoader().loadAsync(url)),
  '.stl': async (url) => asMesh(await new STLLoader().loadAsync(url)),
  '.gltf': async (url) => (await new GLTFLoader().loadAsync(url)).scene,
  '.glb': async (url) => (await new GLTFLoader().loadAsync(url)).scene,
};

const triangles = ({ index, attributes }) => (index ? index.count : attributes.position.count) / 3;

/** Returns the number of triangles in a file, and of those that were drawn. */
globalThis.openFile = async (url, kind) => {
  const asset = await LOADERS[kind](url);
  const stage = new THREE.Scene();
  stage.add(asset, new THREE.HemisphereLight('#ffffff', '#888888', 3));
  let n_triangles = 0;
  asset.traverse((node) => {
    node.frustumCulled = false;
    if (node.isMesh) n_triangles += triangles(node.geometry);
  });
  const renderer = new THREE.WebGLRenderer();
  const box = new THREE.Box3().setFromObject(asset);
  const radius = box.getSize(new THREE.Vector3()).length() / 2;
  const camera = new THREE.PerspectiveCamera(40, 1, radius / 100, radius * 100);
  camera.position.copy(box.getCenter(new THREE.Vector3())).add(new THREE.Vector3(radius, radius, 3 * radius));
  renderer.render(stage, camera);
  return { n_triangles, n_drawn: renderer.info.render.triangles };
};
