//! Where a result comes from: input vertices to output vertices and back, output corners to points of the input.

use glam::Vec3;

use crate::mesh::TriMesh;

use super::closed::{Closed, CornerMap};
use super::components::Pruned;
use super::options::Map;

const NONE: u32 = u32::MAX;

/// The map of a result of the closed assembly.
pub(super) fn of(mesh: &TriMesh, closed: &Closed, corners: CornerMap) -> Map {
    let output_vertices = closed.vertex_of[..mesh.positions().len()].to_vec();
    let mut nearest = vec![(f32::INFINITY, NONE); closed.mesh.positions().len()];
    for (v, &x) in (0u32..).zip(&output_vertices) {
        let [p, q] = [mesh.positions()[v as usize], closed.mesh.positions()[x as usize]].map(Vec3::from);
        let distance = p.distance_squared(q);
        if distance < nearest[x as usize].0 || nearest[x as usize].1 == NONE {
            nearest[x as usize] = (distance, v);
        }
    }
    let input_vertices = nearest.into_iter().map(|(_, v)| v).collect();
    Map { output_vertices, input_vertices, corner_faces: corners.faces, corner_weights: corners.weights }
}

/// The map of a mesh to itself.
pub(super) fn of_unchanged(mesh: &TriMesh) -> Map {
    let n = mesh.positions().len() as u32;
    let unit = |corner: usize| std::array::from_fn(|k| f32::from(u8::from(k == corner)));
    Map {
        output_vertices: (0..n).collect(),
        input_vertices: (0..n).collect(),
        corner_faces: (0..mesh.faces().len() as u32).map(|f| [f; 3]).collect(),
        corner_weights: vec![[unit(0), unit(1), unit(2)]; mesh.faces().len()],
    }
}

/// The map from a mesh of which some components were dropped before.
pub(super) fn of_pruned(mut map: Map, mesh: &TriMesh, pruned: Option<&Pruned>) -> Map {
    if let Some(Pruned { sources, faces, .. }) = pruned {
        widen_vertices(&mut map, sources, mesh.positions().len());
        map.corner_faces.iter_mut().flatten().for_each(|f| *f = faces[*f as usize]);
    }
    map
}

/// The map from a mesh of more vertices, of which `sources` are those of the map.
pub(super) fn widen_vertices(map: &mut Map, sources: &[u32], n_vertices: usize) {
    let mut outputs = vec![NONE; n_vertices];
    sources.iter().zip(&map.output_vertices).for_each(|(&v, &x)| outputs[v as usize] = x);
    map.output_vertices = outputs;
    map.input_vertices.iter_mut().filter(|v| **v != NONE).for_each(|v| *v = sources[*v as usize]);
}
