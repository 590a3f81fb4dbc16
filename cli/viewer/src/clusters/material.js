// The material of clusters: plain, or coloured by cluster, by level, or by the size of triangles on the screen.

import { Color, DoubleSide, MeshPhongMaterial } from 'three';
import { tintInside } from '../model.js';

/** What colours can show, in the order of the shader's numbers. */
export const COLOURINGS = ['surface', 'clusters', 'levels', 'sizes', 'texture'];

/** Colours of levels, from fine to coarse; they repeat. Paul Tol's "muted", which is readable for colour-blind people. */
export const LEVEL_COLOURS = ['#88ccee', '#44aa99', '#117733', '#999933', '#ddcc77', '#cc6677', '#aa4499', '#882255', '#332288'];

/** Sides of triangles in pixels at the ends of the scale of sizes. */
export const SIZES = [1, 64];

/** Colours of sizes from small to large, of matplotlib's magma (CC0). */
export const SIZE_COLOURS = ['#440f76', '#9e2f7f', '#f1605d', '#feca8d', '#fcfdbf'];

const VERTEX = `
attribute vec3 facts;
uniform float pixels;
flat varying vec2 vNumbers;
varying float vSide;
void main() {
  vNumbers = facts.xy;
  vSide = facts.z * pixels / max(-(modelViewMatrix * vec4(position, 1.0)).z, 1e-9);`;

const FRAGMENT = `
uniform int colouring;
uniform vec3 paint;
uniform vec3 levelColours[${LEVEL_COLOURS.length}];
uniform vec3 sizeColours[${SIZE_COLOURS.length}];
flat varying vec2 vNumbers;
varying float vSide;
vec3 clusterColour(float cluster) {
  // Hues by the golden ratio, so that neighbours in the file differ.
  float hue = fract(cluster * 0.61803398875);
  vec3 full = clamp(abs(fract(hue + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
  float light = 0.6 + 0.4 * fract(cluster * 0.7548776662);
  return mix(vec3(0.5), full, 0.6) * light;
}
vec3 sizeColour(float side) {
  float along = clamp(log2(max(side, 1e-9) / ${SIZES[0].toFixed(1)}) / ${Math.log2(SIZES[1] / SIZES[0]).toFixed(1)}, 0.0, 1.0);
  float step = along * ${(SIZE_COLOURS.length - 1).toFixed(1)};
  int low = min(int(step), ${SIZE_COLOURS.length - 2});
  return mix(sizeColours[low], sizeColours[low + 1], step - float(low));
}
void main() {`;

const MAP = `
  if (colouring == 4) {
    diffuseColor.rgb = paint;
    #include <map_fragment>
  }`;

const COLOUR = `#include <color_fragment>
  if (colouring == 1) diffuseColor.rgb = clusterColour(vNumbers.x);
  if (colouring == 2) diffuseColor.rgb = levelColours[int(mod(vNumbers.y + 0.5, ${LEVEL_COLOURS.length.toFixed(1)}))];
  if (colouring == 3) diffuseColor.rgb = sizeColour(vSide);`;

/** Creates values that all materials share; `pixels` is that of the view, times the scale. */
export function makeUniforms() {
  const linear = (colours) => colours.map((colour) => new Color(colour));
  return {
    colouring: { value: 0 }, pixels: { value: 1 },
    levelColours: { value: linear(LEVEL_COLOURS) }, sizeColours: { value: linear(SIZE_COLOURS) },
  };
}

/** Creates the material of a paint {map, colour, isCut}, the last for textures with holes; without normals in the file, triangles are flat. */
export function makeClusterMaterial(shared, { isFlat, map, colour, isCut }) {
  const uniforms = { ...shared, paint: { value: new Color(...colour) } };
  const material = new MeshPhongMaterial({ side: DoubleSide, shininess: 25, specular: 0x1c1c1c, flatShading: isFlat, map, alphaTest: map && isCut ? 0.5 : 0 });
  material.onBeforeCompile = (shader) => {
    tintInside(shader);
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader.replace('void main() {', VERTEX);
    shader.fragmentShader = shader.fragmentShader.replace('void main() {', FRAGMENT).replace('#include <map_fragment>', MAP)
      .replace('#include <color_fragment>', COLOUR);
  };
  return material;
}
