//! Separates touching bodies slightly, since other programs would weld them again.

use glam::{DVec3, Vec3};

use crate::geometry::triangle::area_normal_f64;
use crate::mesh::{TriMesh, manifold};

use super::Repaired;

/// Step by which vertices move, relative to the mesh's size: sixteen steps of single precision.
const STEP: f64 = 1.0 / 1_048_576.0;

/// Gives touching sheets their own vertices, each moved inward.
pub(super) fn separate_touching(repaired: Repaired) -> Repaired {
    let mesh = &repaired.mesh;
    let cut = manifold(mesh.positions(), mesh.faces());
    if cut.copies.is_empty() {
        return repaired;
    }
    let mut positions = mesh.positions().to_vec();
    positions.extend(cut.copies.iter().map(|&vertex| mesh.positions()[vertex as usize]));
    let mut is_split = vec![false; positions.len()];
    is_split[mesh.positions().len()..].fill(true);
    cut.copies.iter().for_each(|&vertex| is_split[vertex as usize] = true);
    let faces = cut.faces.into_owned();
    // Area-weighted normals of the split vertices: only these move.
    let mut outward = vec![DVec3::ZERO; positions.len()];
    for face in faces.iter().filter(|face| face.iter().any(|&v| is_split[v as usize])) {
        let normal = area_normal_f64(face.map(|v| Vec3::from(positions[v as usize]).as_dvec3()));
        face.iter().for_each(|&v| outward[v as usize] += normal);
    }
    // Each copy of a vertex moves one step farther, to separate sheets that face the same way.
    let mut n_steps = vec![1.0; positions.len()];
    for (copy, &vertex) in cut.copies.iter().enumerate() {
        n_steps[mesh.positions().len() + copy] = n_steps[vertex as usize] + 1.0;
        n_steps[vertex as usize] += 1.0;
    }
    cut.copies.iter().for_each(|&vertex| n_steps[vertex as usize] = 1.0);
    // Far from the origin the spacing of f32 decides, not the size of the mesh.
    let reach = positions.as_flattened().iter().fold(mesh.diagonal(), |reach, x| reach.max(f64::from(x.abs())));
    for (vertex, position) in positions.iter_mut().enumerate().filter(|(vertex, _)| is_split[*vertex]) {
        let inward = -outward[vertex].normalize_or_zero();
        let moved = Vec3::from(*position).as_dvec3() + n_steps[vertex] * STEP * reach * inward;
        *position = moved.as_vec3().to_array();
    }
    let sources: Vec<u32> =
        repaired.sources.iter().copied().chain(cut.copies.iter().map(|&v| repaired.sources[v as usize])).collect();
    match TriMesh::new(positions, faces) {
        Ok(mesh) => Repaired { mesh, sources, ..repaired },
        Err(_) => repaired,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, join_positions, shapes, topology};
    use crate::repair::printable;

    #[test]
    fn touching_vertices_are_separated_by_tiny_moves() {
        for (mesh, n_copies) in [(shapes::tetrahedra_sharing_edge(), 2), (shapes::tetrahedra_sharing_vertex(), 1)] {
            let apart = printable(&mesh, Attributes::NONE, 0.0).unwrap();
            assert!(topology(&apart.mesh).is_closed_manifold() && apart.mesh.faces().len() == mesh.faces().len());
            assert_eq!(apart.mesh.positions().len(), mesh.positions().len() + n_copies);
            let moved = |(p, &source): (&[f32; 3], &u32)| {
                let q = mesh.positions()[source as usize];
                (0..3).map(|k| (p[k] - q[k]).abs()).fold(0.0, f32::max)
            };
            let moved: Vec<f32> = apart.mesh.positions().iter().zip(&apart.sources).map(moved).collect();
            assert!(moved.iter().all(|&moved| f64::from(moved) < 3.0 * STEP * mesh.diagonal()));
            assert!(!join_positions(apart.mesh.positions()).1);
        }
    }
}
