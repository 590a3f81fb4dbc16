//! Correspondence between input and output.

use glam::Vec3;

use crate::mesh::TriMesh;

use super::components::PrunedMesh;
use super::options::Map;

const NONE: u32 = u32::MAX;

/// Finds the nearest of the input vertices merged into each output vertex; `u32::MAX` if there is none.
pub(super) fn nearest_inputs(mesh: &TriMesh, simplified: &TriMesh, outputs: &[u32]) -> Vec<u32> {
    let mut nearest = vec![(f32::INFINITY, NONE); simplified.positions().len()];
    for (v, &x) in (0u32..).zip(outputs) {
        let [p, q] = [mesh.positions()[v as usize], simplified.positions()[x as usize]].map(Vec3::from);
        let distance = p.distance_squared(q);
        // The first distance always counts, even if it is not finite.
        if distance < nearest[x as usize].0 || nearest[x as usize].1 == NONE {
            nearest[x as usize] = (distance, v);
        }
    }
    nearest.into_iter().map(|(_, v)| v).collect()
}

pub(super) fn identity_map(mesh: &TriMesh) -> Map {
    let n = mesh.positions().len() as u32;
    let unit = |corner: usize| std::array::from_fn(|k| f32::from(u8::from(k == corner)));
    Map {
        output_vertices: (0..n).collect(),
        input_vertices: (0..n).collect(),
        corner_faces: (0..mesh.faces().len() as u32).map(|f| [f; 3]).collect(),
        corner_weights: vec![[unit(0), unit(1), unit(2)]; mesh.faces().len()],
    }
}

pub(super) fn renumber_pruned_map(map: &mut Map, mesh: &TriMesh, PrunedMesh { sources, faces, .. }: &PrunedMesh) {
    renumber_map(map, sources, mesh.positions().len());
    map.corner_faces.iter_mut().flatten().for_each(|f| *f = faces[*f as usize]);
}

/// Extends the map to a mesh of `n_vertices`, in which its input vertices are `sources`.
pub(super) fn renumber_map(map: &mut Map, sources: &[u32], n_vertices: usize) {
    let mut outputs = vec![NONE; n_vertices];
    sources.iter().zip(&map.output_vertices).for_each(|(&v, &x)| outputs[v as usize] = x);
    map.output_vertices = outputs;
    map.input_vertices.iter_mut().filter(|v| **v != NONE).for_each(|v| *v = sources[*v as usize]);
}
