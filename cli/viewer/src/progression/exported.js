// A level as files have it: one vertex for each position with its attributes, with all instances of a scene.

import { cornerValues } from './attributes.js';
import { ROLES } from './container.js';
import { meshOfLevel, ranksOf, sourceFacesOf } from './level.js';
import { cornerOf, listInstances, moveNormal, movePoint } from './placement.js';

/** Attributes that files get, and their widths: the first channel of each. */
const KINDS = { normal: [3], uv: [2], colour: [3, 4] };

/**
 * Returns a level {positions, faces, normal, uv, colour, origin, groups, materials}; an attribute is {width, values}, or null if the mesh
 * lacks it. As in OBJ and PLY, v grows upwards and colours are sRGB from 0 to 1. Positions are relative to `origin`; `groups` has that of
 * each face, whose materials are those of materials.js, or null.
 */
export function exportLevel(progression, level) {
  const mesh = meshOfLevel(progression, level);
  const ranks = isOriginal(progression, level) ? vertexRanks(progression) : ranksOf(progression, level);
  const channels = chooseChannels(progression.attributes);
  const present = Object.values(channels).filter(Boolean);
  const corners = isOriginal(progression, level) ? valuesOfMesh(progression, present) : cornerValues(progression, level, mesh, present);
  const { wedges, ofWedge } = joinCorners(mesh, corners);
  const instances = listInstances(progression.placement, ranks, mesh.faces);
  const { faces, copies } = numberWedges(wedges, instances);
  const exported = { positions: new Float32Array(3 * copies.length), faces, origin: progression.origin, materials: progression.materials };
  exported.groups = groupsOf(progression, level, instances);
  copies.forEach(({ wedge, instance }, vertex) => {
    movePoint(instance.matrix, mesh.positions, 3 * mesh.faces[ofWedge[wedge]], exported.positions, 3 * vertex);
  });
  let begin = 0;
  for (const [kind, channel] of Object.entries(channels)) {
    exported[kind] = channel ? { width: channel.width, values: new Float32Array(channel.width * copies.length) } : null;
    if (!channel) continue;
    const convert = CONVERSIONS[kind](progression.isScene);
    copies.forEach(({ wedge, instance }, vertex) => {
      const from = corners.width * ofWedge[wedge] + begin;
      exported[kind].values.set(convert(corners.values.subarray(from, from + channel.width), instance), channel.width * vertex);
    });
    begin += channel.width;
  }
  return exported;
}

/** Returns the group of each face of all instances. */
function groupsOf(progression, level, instances) {
  const sources = isOriginal(progression, level) ? null : sourceFacesOf(progression, level);
  const { groups } = progression.attributes;
  return Uint32Array.from(instances.flatMap(({ faces }) => Array.from(faces, (face) => groups[sources ? sources[face] : face] ?? 0)));
}

/** Returns whether a level is the mesh itself, with its vertices in their order. */
function isOriginal({ isMesh }, { isWhole }) {
  return isMesh && isWhole;
}

/** Returns the rank of each vertex of the mesh. */
function vertexRanks({ sequence: { vertices } }) {
  const ranks = new Uint32Array(vertices.length);
  vertices.forEach((vertex, rank) => { ranks[vertex] = rank; });
  return ranks;
}

/** Conversions of attributes; in scenes v grows downwards and colours are linear. */
const CONVERSIONS = {
  normal: () => (normal, { matrix }) => moveNormal(matrix, normal),
  uv: (isScene) => ([u, v]) => [u, isScene ? 1 - v : v],
  colour: (isScene) => (colour) => colour.map((value, i) => (isScene && i < 3 ? toSrgb(value) : value)),
};

function toSrgb(light) {
  const x = Math.min(Math.max(light, 0), 1);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
}

function chooseChannels({ channels }) {
  const choose = ([kind, widths]) => [kind, channels.find(({ role, width }) => role === ROLES[kind] && widths.includes(width))];
  return Object.fromEntries(Object.entries(KINDS).map(choose));
}

/** Returns the values at the corners of the mesh itself. */
function valuesOfMesh({ attributes: { wedges } }, channels) {
  const width = channels.reduce((sum, channel) => sum + channel.width, 0);
  const values = new Float32Array(width * wedges.length);
  let at = 0;
  for (const wedge of wedges) {
    for (const channel of channels) {
      values.set(channel.values.subarray(channel.width * wedge, channel.width * (wedge + 1)), at);
      at += channel.width;
    }
  }
  return { width, values };
}

/** Returns the wedge of each corner, corners of a vertex with equal values being one, and a corner of each wedge. */
function joinCorners({ positions, faces }, { width, values }) {
  const [first, next, ofWedge] = [new Int32Array(positions.length / 3).fill(-1), [], []];
  const isEqual = (a, b) => {
    for (let i = 0; i < width; i++) if (values[width * a + i] !== values[width * b + i]) return false;
    return true;
  };
  const wedges = faces.map((vertex, corner) => {
    let wedge = first[vertex];
    while (wedge >= 0 && !isEqual(ofWedge[wedge], corner)) wedge = next[wedge];
    if (wedge >= 0) return wedge;
    next.push(first[vertex]);
    first[vertex] = ofWedge.length;
    return ofWedge.push(corner) - 1;
  });
  return { wedges, ofWedge };
}

/** Numbers the wedges of all instances: faces by these numbers, and the wedge and the instance of each. */
function numberWedges(wedges, instances) {
  const [corners, copies, numbers] = [[], [], new Int32Array(wedges.length).fill(-1)];
  for (const instance of instances) {
    const first = copies.length;
    for (const face of instance.faces) {
      for (let k = 0; k < 3; k++) {
        const wedge = wedges[3 * face + cornerOf(k, instance.isMirrored)];
        // Numbers of earlier instances are below the first one of this.
        if (numbers[wedge] < first) numbers[wedge] = copies.push({ wedge, instance }) - 1;
        corners.push(numbers[wedge]);
      }
    }
  }
  return { faces: Uint32Array.from(corners), copies };
}
