//! Connected patches of a mesh, which bound the cost of a step.

use super::random::random_below;
use super::{Settings, TrainingItem};
use crate::linalg::Csr;
use crate::mesh::TriMesh;
use crate::simplify::edge_graph;
use rand_xoshiro::Xoshiro256PlusPlus;
use std::collections::VecDeque;

/// Returns the mesh of a step, or a connected patch if it would have more than `max_samples` samples.
///
/// # Errors
/// If the patch has no face.
///
/// ```
/// use neural_mesh::mesh::shapes;
/// use neural_mesh::train::{TrainingItem, Settings, cut_patch};
/// use rand_xoshiro::{Xoshiro256PlusPlus, rand_core::SeedableRng};
/// let settings = Settings::from_toml("max_samples = 50").unwrap();
/// let item = TrainingItem { name: "ball".into(), mesh: shapes::icosphere(4), ratio: 0.5 };
/// let piece = cut_patch(&item, &settings, &mut Xoshiro256PlusPlus::seed_from_u64(0)).unwrap();
/// assert_eq!(piece.positions().len(), 100);
/// ```
pub fn cut_patch(item: &TrainingItem, settings: &Settings, random: &mut Xoshiro256PlusPlus) -> Result<TriMesh, String> {
    let most = settings.max_samples as f64 / item.ratio;
    if settings.max_samples == 0 || item.mesh.positions().len() as f64 <= most {
        return Ok(item.mesh.clone());
    }
    let start = random_below(random, item.mesh.positions().len());
    patch(&item.mesh, &edge_graph(&item.mesh), most as usize, start as u32)
        .ok_or("has no complete face in the patch cut from it: raise `max_samples`".into())
}

/// Returns the faces between the first `n_vertices` vertices reached over the edges from `start`.
fn patch(mesh: &TriMesh, rings: &Csr, n_vertices: usize, start: u32) -> Option<TriMesh> {
    let n = mesh.positions().len();
    if n_vertices >= n {
        return Some(mesh.clone());
    }
    let mut number = vec![u32::MAX; n];
    let mut reached = vec![start];
    number[start as usize] = 0;
    let mut pending = VecDeque::from([start]);
    while let Some(v) = pending.pop_front() {
        for &w in rings.row(v as usize) {
            if number[w as usize] == u32::MAX && reached.len() < n_vertices {
                number[w as usize] = reached.len() as u32;
                reached.push(w);
                pending.push_back(w);
            }
        }
    }
    let renumbered = mesh.faces().iter().map(|face| face.map(|v| number[v as usize]));
    let faces: Vec<[u32; 3]> = renumbered.filter(|face| !face.contains(&u32::MAX)).collect();
    let positions = reached.iter().map(|&v| mesh.positions()[v as usize]).collect();
    if faces.is_empty() { None } else { TriMesh::new(positions, faces).ok() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, topology};

    #[test]
    fn a_patch_is_one_piece_of_the_surface() {
        let mesh = shapes::icosphere(4);
        let rings = edge_graph(&mesh);
        let piece = patch(&mesh, &rings, 500, 7).unwrap();
        assert_eq!(piece.positions().len(), 500);
        let found = topology(&piece);
        assert_eq!((found.components, found.non_manifold_edges, found.closed), (1, 0, false));
        assert_eq!(patch(&mesh, &rings, 1 << 20, 7).as_ref(), Some(&mesh));
        assert_eq!(patch(&mesh, &rings, 1, 7), None);
    }
}
