// The cover of a surface in three.js: corners with texture coordinates and colours, and images.

import {
  BufferAttribute, BufferGeometry, ClampToEdgeWrapping, Color, DoubleSide, Mesh, MeshPhongMaterial, MeshStandardMaterial,
  MirroredRepeatWrapping, NoColorSpace, RepeatWrapping, ShaderChunk, SRGBColorSpace, Texture,
} from 'three';

const WRAPS = { repeat: RepeatWrapping, clamp: ClampToEdgeWrapping, mirror: MirroredRepeatWrapping };

/** How bright the surroundings are that metal and polished surfaces reflect. */
const REFLECTED = 1.3;

/** Shader code of surroundings that are reflected and give no other light, which comes from the lamps, as on surfaces without maps. */
const ONLY_REFLECTED = ShaderChunk.lights_fragment_maps.replaceAll('iblIrradiance +=', 'vec3 unused =');

/**
 * Creates the store of images and materials that the covers of a scene share; `imageOf(index)` returns an image file as a blob,
 * `reflected()` a texture of what surfaces reflect.
 */
export function makeWardrobe(imageOf, reflected) {
  return { imageOf, reflected, bitmaps: new Map(), textures: new Map(), materials: new Map() };
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

async function makeMaterial({ image, wrap, color, coloured, finish }, wardrobe) {
  const texture = (index, colorSpace) => textureOf(index ?? null, wrap, colorSpace, wardrobe);
  const common = {
    map: await texture(image, SRGBColorSpace), color: new Color(...(color ?? [1, 1, 1])), vertexColors: coloured,
    side: DoubleSide, polygonOffsetFactor: 1, polygonOffsetUnits: 1,
  };
  if (!finish) return new MeshPhongMaterial({ ...common, shininess: 25, specular: 0x1c1c1c });
  const { maps, emission, roughness, metal, normalScale, occlusion } = finish;
  const [normalMap, roughnessMap, metalnessMap, aoMap] = await Promise.all(
    [maps.normal, maps.roughness, maps.metal, maps.occlusion].map((index) => texture(index, NoColorSpace)));
  const material = new MeshStandardMaterial({
    ...common, normalMap, roughnessMap, metalnessMap, aoMap, emissiveMap: await texture(maps.emission, SRGBColorSpace),
    emissive: new Color(...emission), roughness, metalness: metal, aoMapIntensity: occlusion,
    envMap: wardrobe.reflected(), envMapIntensity: REFLECTED,
  });
  material.onBeforeCompile = (shader) => {
    shader.fragmentShader = shader.fragmentShader.replace('#include <lights_fragment_maps>', ONLY_REFLECTED);
  };
  // Without stored tangents, those of the texture coordinates count, whose v runs downwards.
  material.normalScale.set(normalScale, -normalScale);
  return material;
}

/** Returns the texture of an image, shared by all materials that use it alike; null without an image that the browser can read. */
function textureOf(index, wrap, colorSpace, wardrobe) {
  const key = `${index} ${wrap} ${colorSpace}`;
  if (index === null) return null;
  if (!wardrobe.textures.has(key)) {
    wardrobe.textures.set(key, bitmapOf(index, wardrobe).then((bitmap) => makeTexture(bitmap, wrap, colorSpace), () => null));
  }
  return wardrobe.textures.get(key);
}

/** Creates the texture of an image, {repeat, clamp, mirror} along u and v. */
export function makeTexture(bitmap, [u, v], colorSpace = SRGBColorSpace) {
  const texture = new Texture(bitmap, undefined, WRAPS[u], WRAPS[v]);
  texture.flipY = false;
  texture.colorSpace = colorSpace;
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
export async function disposeWardrobe({ bitmaps, textures, materials }) {
  for (const held of [materials, textures]) for (const { value } of await Promise.allSettled(held.values())) value?.dispose();
  for (const bitmap of await Promise.allSettled(bitmaps.values())) bitmap.value?.close();
}
