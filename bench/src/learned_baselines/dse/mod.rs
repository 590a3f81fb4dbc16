//! Surfaces from points: "Learning Delaunay Surface Elements for Mesh Reconstruction" (Rakotosaona et al., CVPR 2021).
//!
//! One network selects neighbours of every point, another predicts their logarithmic map. Delaunay triangles of the
//! maps vote for the surface.

mod alignment;
mod exact_map;
mod forward;
mod learned_patches;
mod losses;
mod neighbourhoods;
mod network;
mod overlap;
mod patch;
mod reconstruct;
mod selection;
mod step;
mod turn;
mod umbrella;
mod votes;

use super::compact_with_first_point;
use crate::baselines::BaselineError;
use glam::Vec3;
use neural_mesh::autodiff::Tensors;
use neural_mesh::linalg::Matrix;
use neural_mesh::mesh::{TriMesh, compact, vertex_normals};
use neural_mesh::spatial::farthest_points;
use std::sync::Arc;

pub use network::{initial_tensors, shapes};
pub use step::dse_step;

use alignment::align_maps;
#[cfg(test)]
use exact_map::exact_patches;
use exact_map::{WalkSurface, exact_patches_around};
use forward::forward;
use learned_patches::learned_patches;
use losses::{Loss, map_loss, neighbour_loss};
use neighbourhoods::{Neighbourhoods, PatchFrame};
use network::{CANDIDATES, KEPT};
use overlap::are_overlapping;
use patch::Patch;
use reconstruct::reconstruct;
use selection::select_triangles;
use turn::Turn;
use umbrella::umbrella;
use votes::count_votes;

/// Draws farthest points of a mesh and meshes them.
///
/// # Errors
/// [`BaselineError`] where no face is left.
pub fn simplify(
    mesh: &TriMesh,
    n_vertices: usize,
    seed: u64,
    tensors: &Tensors<Arc<Matrix>>,
) -> Result<TriMesh, BaselineError> {
    let (mesh, first) = compact_with_first_point(mesh, seed)?;
    let samples = draw_samples(&mesh, n_vertices, first);
    let points: Vec<[f32; 3]> = samples.iter().map(|&v| mesh.positions()[v as usize]).collect();
    mesh_samples(&mesh, &samples, &learned_patches(&points, tensors))
}

fn draw_samples(mesh: &TriMesh, n: usize, first: u32) -> Vec<u32> {
    let mut samples = farthest_points(mesh.positions(), n, first);
    samples.sort_unstable();
    samples
}

fn mesh_samples(mesh: &TriMesh, samples: &[u32], patches: &[Patch]) -> Result<TriMesh, BaselineError> {
    let points: Vec<[f32; 3]> = samples.iter().map(|&v| mesh.positions()[v as usize]).collect();
    let all = vertex_normals(mesh);
    let normals: Vec<Vec3> = samples.iter().map(|&v| all[v as usize].into()).collect();
    let faces = reconstruct(&points, patches).into_iter().map(|face| orient_face(face, &points, &normals));
    Ok(compact(&points, faces.collect())?.0)
}

fn orient_face([a, b, c]: [u32; 3], points: &[[f32; 3]], normals: &[Vec3]) -> [u32; 3] {
    let [p, q, r] = [a, b, c].map(|v| Vec3::from(points[v as usize]));
    let side: f32 = [a, b, c].iter().map(|&v| normals[v as usize].dot((q - p).cross(r - p))).sum();
    if side < 0.0 { [a, c, b] } else { [a, b, c] }
}

// Networks are compared with NumPy (`bench/tests/golden/dse.py`), gradients with differences.
#[cfg(test)]
mod tests {
    use super::*;
    use crate::autodiff::test_gradients::check_gradients;
    use neural_mesh::autodiff::{Tape, Tensors, Value};
    use neural_mesh::linalg::Matrix;
    use std::sync::Arc;

    // Layers are 16 wide after the pooling, and have the minimum before it.
    const SHARE: f64 = 1.0 / 64.0;
    const GROUP: usize = 5;

    const LOGITS: [f64; 10] =
        [-2.88455, -2.80375, -2.42287, -1.28346, -1.87220, -2.88715, -2.72299, -2.22523, -1.26782, -2.00722];
    const MAP: [f64; 20] = [
        -2.23190, -5.21075, -3.13439, -5.28018, -3.04443, -5.56170, -2.60810, -5.10236, -2.69573, -5.00051, -2.23405,
        -5.21437, -3.18289, -5.37348, -2.99558, -5.49381, -2.56742, -5.05786, -2.76747, -4.99941,
    ];
    const NEIGHBOUR_LOSS: f64 = 0.996604954821307;
    const MAP_LOSS: f64 = 57.09674450355271;

    fn tensors() -> Tensors<Arc<Matrix>> {
        let mut number = -1.0;
        shapes(SHARE).map(|_, &[n_rows, n_cols]| {
            number += 1.0;
            let scale = (2.0 / n_rows as f64).sqrt();
            let entry = |i: f64, j: f64| scale * (1.0 + 1.7 * number + 0.9 * i * i + 2.3 * i * j + 1.1 * j).sin();
            Arc::new(Matrix::from_fn(n_rows, n_cols, |i, j| entry(i as f64, j as f64) as f32))
        })
    }

    fn places() -> Matrix {
        let coordinate = |row: usize, axis: usize| (1.3 * row as f64 + 2.1 * axis as f64).sin();
        Matrix::from_fn(2 * GROUP, 3, |row, axis| if row % GROUP == 0 { 0.0 } else { coordinate(row, axis) as f32 })
    }

    fn exact() -> Vec<[f64; 2]> {
        (0..2 * GROUP).map(|i| [(0.8 * i as f64).cos(), (1.9 * i as f64).sin()]).collect()
    }

    fn assert_near(found: &[f32], expected: &[f64]) {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!((f64::from(*found) - expected).abs() < 1e-4, "{found} {expected}");
        }
    }

    #[test]
    fn networks_and_losses_agree_with_numpy() {
        let (tensors, places) = (tensors().constants(), Value::constant(places()));
        let tape = &mut Tape::default();
        let logits = forward(tape, &tensors, "classifier", &places, GROUP);
        assert_near(logits.matrix().data(), &LOGITS);
        let map = forward(tape, &tensors, "map", &places, GROUP);
        assert_near(map.matrix().data(), &MAP);
        assert!(tape.is_empty());
        let are_neighbours: Vec<bool> = (0..2 * GROUP).map(|row| row % 3 == 1).collect();
        assert!((neighbour_loss(logits.matrix(), &are_neighbours, GROUP).value - NEIGHBOUR_LOSS).abs() < 1e-5);
        assert!((map_loss(map.matrix(), &exact(), GROUP).value - MAP_LOSS).abs() < 1e-5);
    }

    #[test]
    fn gradients_of_the_networks() {
        let shapes = shapes(SHARE);
        let matrices: Vec<Matrix> = tensors().iter().map(|(_, matrix)| matrix.as_ref().clone()).collect();
        check_gradients(&matrices, |tape, values| {
            let named: Tensors<Value> =
                shapes.iter().map(|(name, _)| name).zip(values).map(|(name, value)| (name, value.clone())).collect();
            let places = Value::constant(places());
            let logits = forward(tape, &named, "classifier", &places, GROUP);
            let map = forward(tape, &named, "map", &places, GROUP);
            let identity = Matrix::from_fn(3, 3, |i, j| f32::from(u8::from(i == j)));
            tape.concat_product(&logits, &map, &Value::constant(identity))
        });
    }

    #[test]
    fn patches_of_few_points_have_them_all() {
        let tensors = initial_tensors(0.05, 1);
        assert!(learned_patches(&[], &tensors).is_empty());
        let one = learned_patches(&[[1.0; 3]], &tensors);
        assert_eq!(one[0].points, [0]);
        let three = learned_patches(&[[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0]], &tensors);
        assert!(three.iter().all(|patch| patch.points.len() == 3));
        let patches = learned_patches(neural_mesh::mesh::shapes::icosphere(2).positions(), &tensors);
        assert_eq!((patches.len(), patches[9].points[0], patches[9].points.len()), (162, 9, 25));
    }

    #[test]
    fn the_same_bits_on_any_number_of_threads() {
        let sphere = neural_mesh::mesh::shapes::wavy_sphere(2, 4.0);
        let tensors = initial_tensors(0.05, 1);
        let on_threads = |n| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
            pool.install(|| reconstruct(sphere.positions(), &learned_patches(sphere.positions(), &tensors)))
        };
        assert_eq!(on_threads(1), on_threads(3));
    }

    #[test]
    fn a_mesh_is_made_again_on_its_side() {
        let sphere = neural_mesh::mesh::shapes::icosphere(3);
        let samples = draw_samples(&sphere, 160, 0);
        let simplified = mesh_samples(&sphere, &samples, &exact_patches(&sphere, &samples, KEPT)).unwrap();
        assert!((310..=316).contains(&simplified.faces().len()));
        let outward = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| Vec3::from(simplified.positions()[v as usize]));
            (b - a).cross(c - a).dot(a + b + c) > 0.0
        };
        assert!(simplified.faces().iter().all(outward));
        let nothing = TriMesh::new(Vec::new(), Vec::new()).unwrap();
        assert_eq!(simplify(&nothing, 9, 0, &initial_tensors(0.05, 1)), Err(BaselineError::NothingLeft));
    }
}
