// The cover of a surface in three.js: corners with texture coordinates and colours, and images.

import {
  BufferAttribute, BufferGeometry, ClampToEdgeWrapping, Color, DoubleSide, Mesh, MeshPhongMaterial, MirroredRepeatWrapping,
  RepeatWrapping, SRGBColorSpace, Texture,
} from 'three';

const WRAPS = { repeat: RepeatWrapping, clamp: ClampToEdgeWrapping, mirror: MirroredRepeatWrapping };

/** Creates the store of images and materials that the covers of a scene share; `imageOf(index)` returns an image file as a blob. */
export function makeWardrobe(imageOf) {
  return { imageOf, bitmaps: new Map(), materials: new Map() };
}

/** Adds the covered surface that `load` returns to a model when it is first shown; all callers wait for it. */
export function addCover(model, load, wardrobe) {
  model.covering ??= makeCover(model, load, wardrobe);
  return model.covering;
}

async function makeCover(model, load, wardrobe) {
  const cover = await load();
  const geometry = new BufferGeometry();
  for (const [name, values, width] of [['position', cover.positions, 3], ['normal', cover.normals, 3], ['uv', cover.uvs, 2]]) {
    geometry.setAttribute(name, new BufferAttribute(values, width));
  }
  if (cover.colours) geometry.setAttribute('color', new BufferAttribute(cover.colours, 3));
  geometry.setIndex(new BufferAttribute(cover.faces, 1));
  cover.runs.forEach(([from, n], paint) => geometry.addGroup(from, n, paint));
  geometry.boundingSphere = model.geometry.boundingSphere;
  const materials = cover.paints.map((paint) => materialOf(paint, wardrobe));
  model.covered = new Mesh(geometry, await Promise.all(materials));
  model.covered.visible = false;
  model.covered.castShadow = true;
  model.group.add(model.covered);
}

/** Returns the material of a paint, shared by all surfaces with this paint. */
function materialOf(paint, wardrobe) {
  const key = JSON.stringify(paint);
  if (!wardrobe.materials.has(key)) wardrobe.materials.set(key, makeMaterial(paint, wardrobe));
  return wardrobe.materials.get(key);
}

async function makeMaterial({ image, wrap, color, coloured }, wardrobe) {
  // If the browser cannot read an image, the plain colour stays.
  const bitmap = image === null ? null : await bitmapOf(image, wardrobe).catch(() => null);
  const map = bitmap && textureOf(bitmap, wrap);
  return new MeshPhongMaterial({
    map, color: new Color(...(color ?? [1, 1, 1])), vertexColors: coloured,
    side: DoubleSide, shininess: 25, specular: 0x1c1c1c, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  });
}

/** Creates the texture of an image, {repeat, clamp, mirror} along u and v. */
export function textureOf(bitmap, [u, v]) {
  const texture = new Texture(bitmap, undefined, WRAPS[u], WRAPS[v]);
  texture.flipY = false;
  texture.colorSpace = SRGBColorSpace;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
}

function bitmapOf(index, { imageOf, bitmaps }) {
  if (!bitmaps.has(index)) bitmaps.set(index, imageOf(index).then(decode));
  return bitmaps.get(index);
}

/** Decodes the pixels of an image without colour conversion. */
export function decode(file) {
  return createImageBitmap(file, { colorSpaceConversion: 'none', premultiplyAlpha: 'none' });
}

/** Sets flat or smooth shading of all covers, and whether edges are drawn over them. */
export async function setCovers({ materials }, flatShading, polygonOffset) {
  for (const material of await Promise.all(materials.values())) {
    Object.assign(material, { flatShading, polygonOffset, needsUpdate: true });
  }
}

/** Frees the graphics memory that the covers of a scene share. */
export async function disposeWardrobe({ bitmaps, materials }) {
  for (const material of await Promise.allSettled(materials.values())) {
    material.value?.map?.dispose();
    material.value?.dispose();
  }
  for (const bitmap of await Promise.allSettled(bitmaps.values())) bitmap.value?.close();
}
