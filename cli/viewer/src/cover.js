// What covers a surface: its corners with texture coordinates and colours, and the images. The way into the page is cover_data.rs.

import {
  BufferAttribute, BufferGeometry, ClampToEdgeWrapping, DoubleSide, Mesh, MeshPhongMaterial, MirroredRepeatWrapping,
  RepeatWrapping, SRGBColorSpace, Texture,
} from 'three';
import { bytesOf, numbersOf } from './numbers.js';
import { unpackCover } from './surface.js';

const WRAPS = { repeat: RepeatWrapping, clamp: ClampToEdgeWrapping, mirror: MirroredRepeatWrapping };

/** The images and materials that covers of a page share; `images` says what each image is. */
export function makeWardrobe(images) {
  return { images, bitmaps: new Map(), materials: new Map() };
}

/** Adds the covered surface of a model, the first time that it is shown; everyone who asks waits until it is there. */
export function addCover(model, layout, index, wardrobe) {
  model.covering ??= makeCover(model, layout, index, wardrobe);
  return model.covering;
}

async function makeCover(model, layout, index, wardrobe) {
  const cover = await unpackCover(layout, await numbersOf(`cover-${index}`), model.surface);
  const geometry = new BufferGeometry();
  for (const [name, values, width] of [['position', cover.positions, 3], ['normal', cover.normals, 3], ['uv', cover.uvs, 2]]) {
    geometry.setAttribute(name, new BufferAttribute(values, width));
  }
  if (cover.colours) geometry.setAttribute('color', new BufferAttribute(cover.colours, 3));
  geometry.setIndex(new BufferAttribute(cover.faces, 1));
  cover.runs.forEach(([from, n], paint) => geometry.addGroup(from, n, paint));
  geometry.boundingSphere = model.geometry.boundingSphere;
  const materials = layout.paints.map((paint) => materialOf(paint, layout.coloured, wardrobe));
  model.covered = new Mesh(geometry, await Promise.all(materials));
  model.covered.visible = false;
  model.group.add(model.covered);
}

/** The material of a paint, one for all surfaces that are painted alike. */
function materialOf(paint, coloured, { images, bitmaps, materials }) {
  const key = JSON.stringify([paint, coloured]);
  if (!materials.has(key)) materials.set(key, makeMaterial(paint, coloured, images, bitmaps));
  return materials.get(key);
}

async function makeMaterial({ image, wrap }, vertexColors, images, bitmaps) {
  const map = images[image] ? await textureOf(await bitmapOf(image, images, bitmaps), wrap) : null;
  return new MeshPhongMaterial({
    map, vertexColors, side: DoubleSide, shininess: 25, specular: 0x1c1c1c, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  });
}

function textureOf(bitmap, [u, v]) {
  const texture = new Texture(bitmap, undefined, WRAPS[u], WRAPS[v]);
  texture.flipY = false;
  texture.colorSpace = SRGBColorSpace;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
}

/** The pixels of an image, as the file has them. */
function bitmapOf(index, images, bitmaps) {
  if (!bitmaps.has(index)) bitmaps.set(index, decode(index, images[index].type));
  return bitmaps.get(index);
}

async function decode(index, type) {
  const file = new Blob(await bytesOf(`image-${index}`), { type });
  return createImageBitmap(file, { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
}

/** Draws all covers with facets or smooth, with or without room for edges. */
export async function setCovers({ materials }, flatShading, polygonOffset) {
  for (const material of await Promise.all(materials.values())) {
    Object.assign(material, { flatShading, polygonOffset, needsUpdate: true });
  }
}
