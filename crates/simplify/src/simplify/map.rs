//! Correspondence between input and output.

use glam::Vec3;

use crate::mesh::TriMesh;

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
