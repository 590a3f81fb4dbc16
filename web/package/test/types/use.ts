// Uses all of the interface once, so that the compiler reads all types. It is compiled and not run.

import { Document, type Transform } from '@gltf-transform/core';
import { simplify as transformSimplify } from '@gltf-transform/functions';
import { BoxGeometry, type BufferGeometry } from 'three';
import { compare, formats, look, NeuralMeshError, simplify, type SimplifyResult } from 'neural-mesh';
import { neuralSimplify } from 'neural-mesh/gltf-transform';
import { NeuralSimplifier, simplifyIndices } from 'neural-mesh/simplifier';
import { simplifyModifier } from 'neural-mesh/three';

const signal: AbortSignal = new AbortController().signal;
const progress = (share: number, part: number): void => console.log(share, part);

export async function useAll(file: File, bytes: Uint8Array): Promise<void> {
  const result: SimplifyResult = await simplify(file, { ratio: 0.1, effort: 'fast', error: '1%' }, { signal, progress });
  const beside = { 'a.mtl': bytes, 'a.png': new Blob([]) };
  await simplify(bytes, { lods: [0.5, '10%'] }, { name: 'a.obj', beside, out: 'a.glb', arrays: true, worker: false });
  await simplify({ name: 'a.obj', bytes: bytes.buffer as ArrayBuffer, beside: [{ name: 'a.mtl', bytes }] }, { faces: '10k' });
  const written: Uint8Array | undefined = result.bytes ?? result.files[0]?.beside[0]?.bytes;
  const arrays = { positions: new Float64Array(9), faces: [0, 1, 2], uv: new Float32Array(6) };
  const { results: [light] } = await simplify(arrays, { vertices: 3, map: true });
  const map: Uint32Array | undefined = light?.map;
  const { comparison, distances } = await compare(file, [{ name: 'b.glb', bytes }], { samples: 1000, signal });
  const { mesh, notes } = await look(bytes, { name: 'a.obj', beside: {} });
  const image: Uint8Array | undefined = mesh.groups[0]?.image;
  const { read, write, version } = await formats();
  console.log(written, map, comparison, distances[0]?.of_original, notes, image, read, write, version);
}

export async function useSimplifier(): Promise<void> {
  const simplifier = NeuralSimplifier;
  const supported: boolean = simplifier.supported;
  await simplifier.ready;
  const positions = new Float32Array(9);
  const [narrow, error]: [Uint16Array, number] = simplifier.simplify(Uint16Array.of(0, 1, 2), positions, 3, 3, 0.01, ['LockBorder', 'ErrorAbsolute']);
  const [wide] = simplifier.simplifyWithAttributes(Uint32Array.of(0, 1, 2), positions, 3, positions, 3, [1, 1, 1], null, 3, 0.01);
  const [count] = simplifier.simplifyWithUpdate(wide, positions, 3, positions, 3, [1], new Uint8Array(3), 3, 0.01);
  const [remap, used] = simplifier.compactMesh(wide);
  const same: Uint32Array = simplifier.generatePositionRemap(positions, 3);
  const points: Uint32Array = simplifier.simplifyPoints(positions, 3, 1, positions, 3, 0.5);
  const pruned: Uint32Array = simplifier.simplifyPrune(wide, positions, 3, 0.1);
  const goal = { target: 3, error: 0.1, flags: ['Prune' as const], move: true, signal, progress };
  const { indices: chosen, positions: moved, groups } = await simplifyIndices({ indices: wide, positions, groups: Uint32Array.of(0) }, goal);
  console.log(supported, narrow, error, count, remap, used, same, points, pruned, chosen, moved, groups, simplifier.getScale(positions, 3));
}

export async function useOthers(): Promise<void> {
  const geometry: BufferGeometry = await simplifyModifier(new BoxGeometry(), { ratio: 0.5, lockBorder: true, move: false, worker: false, signal });
  const transform: Transform = neuralSimplify({ faces: 100, error: 0.01, progress: (share) => console.log(share, geometry) });
  await new Document().transform(transform, transformSimplify({ simplifier: NeuralSimplifier, ratio: 0.5, error: 0.01 }));
  try {
    await formats({ worker: false });
  } catch (error) {
    if (error instanceof NeuralMeshError) console.log(error.message);
  }
}

// @ts-expect-error a simplifier needs to know how far
neuralSimplify();
// @ts-expect-error no such format of a mesh
void simplify(5, { ratio: 0.5 });
