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
mod selection;
mod step;
mod turn;
mod umbrella;

use super::{compact_with_first_point, farthest_vertices};
use crate::baselines::points_and_normals;
use anyhow::Result;
use glam::Vec3;
use neural_mesh::autodiff::Tensors;
use neural_mesh::linalg::Matrix;
use neural_mesh::mesh::{TriMesh, compact, orient_outward};
use std::sync::Arc;

pub use network::shapes;
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
use selection::select_triangles;
use turn::Turn;
use umbrella::count_votes;

/// A point of a cloud, its geodesic neighbours and their logarithmic map.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Patch {
    /// Indices of points, the patch's own first.
    pub points: Vec<u32>,
    /// Positions in the plane: geodesic distance and initial direction.
    pub map: Vec<[f64; 2]>,
}

impl Patch {
    /// Returns the largest distance from the origin.
    pub fn radius(&self) -> f64 {
        self.map.iter().map(|at| at[0].hypot(at[1])).fold(0.0, f64::max)
    }
}

/// Draws farthest points of a mesh and meshes them.
///
/// # Errors
/// One line where no face is left.
pub fn simplify(mesh: &TriMesh, n_vertices: usize, seed: u64, tensors: &Tensors<Arc<Matrix>>) -> Result<TriMesh> {
    let (mesh, first) = compact_with_first_point(mesh, seed)?;
    let samples = points_and_normals(&mesh, &farthest_vertices(&mesh, n_vertices, first));
    let patches = learned_patches(&samples[0], tensors);
    mesh_samples(&samples, &patches)
}

fn mesh_samples([points, normals]: &[Vec<[f32; 3]>; 2], patches: &[Patch]) -> Result<TriMesh> {
    let faces = reconstruct(points, patches).into_iter().map(|face| orient_face(face, points, normals));
    Ok(compact(points, faces.collect())?.0)
}

fn orient_face([a, b, c]: [u32; 3], points: &[[f32; 3]], normals: &[[f32; 3]]) -> [u32; 3] {
    let [p, q, r] = [a, b, c].map(|v| Vec3::from(points[v as usize]));
    let side: f32 = [a, b, c].iter().map(|&v| Vec3::from(normals[v as usize]).dot((q - p).cross(r - p))).sum();
    if side < 0.0 { [a, c, b] } else { [a, b, c] }
}

/// Meshes points by their patches: aligns maps, counts votes and selects triangles.
///
/// # Shapes
/// - `points`: n x 3, finite; `patches`: one per point, in order
fn reconstruct(points: &[[f32; 3]], patches: &[Patch]) -> Vec<[u32; 3]> {
    orient_outward(points, &select_triangles(points, &count_votes(&align_maps(patches))))
}

// Networks are compared with NumPy (`bench/tests/golden/dse.py`), gradients with differences.
#[cfg(test)]
mod tests {
    use super::*;
    use crate::autodiff::test_gradients::check_gradients;
    use crate::learned_baselines::LearnedBaseline;
    use crate::learned_baselines::tests::{assert_near, tensors_by_formula, with_names};
    use neural_mesh::autodiff::{Tape, Value};
    use neural_mesh::mesh::{edges, shapes};
    use neural_mesh::spatial::farthest_points;

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
        tensors_by_formula(&shapes(SHARE), |number, [i, j], n_rows| {
            (2.0 / n_rows).sqrt() * (1.0 + 1.7 * number + 0.9 * i * i + 2.3 * i * j + 1.1 * j).sin()
        })
    }

    fn places() -> Matrix {
        let coordinate = |row: usize, axis: usize| (1.3 * row as f64 + 2.1 * axis as f64).sin();
        Matrix::from_fn(2 * GROUP, 3, |row, axis| if row % GROUP == 0 { 0.0 } else { coordinate(row, axis) as f32 })
    }

    fn exact() -> Vec<[f64; 2]> {
        (0..2 * GROUP).map(|i| [(0.8 * i as f64).cos(), (1.9 * i as f64).sin()]).collect()
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
            let named = with_names(&shapes, values);
            let places = Value::constant(places());
            let logits = forward(tape, &named, "classifier", &places, GROUP);
            let map = forward(tape, &named, "map", &places, GROUP);
            let identity = Matrix::from_fn(3, 3, |i, j| f32::from(u8::from(i == j)));
            tape.concat_product(&logits, &map, &Value::constant(identity))
        });
    }

    #[test]
    fn patches_of_few_points_have_them_all() {
        let tensors = LearnedBaseline::Dse.initial_tensors(0.05, 1);
        assert!(learned_patches(&[], &tensors).is_empty());
        let one = learned_patches(&[[1.0; 3]], &tensors);
        assert_eq!(one[0].points, [0]);
        let three = learned_patches(&[[0.0; 3], [0.0; 3], [1.0, 0.0, 0.0]], &tensors);
        assert!(three.iter().all(|patch| patch.points.len() == 3));
        let patches = learned_patches(shapes::icosphere(2).positions(), &tensors);
        assert_eq!((patches.len(), patches[9].points[0], patches[9].points.len()), (162, 9, 25));
    }

    #[test]
    fn a_mesh_is_made_again_on_its_side() {
        let sphere = shapes::icosphere(3);
        let samples = farthest_vertices(&sphere, 160, 0);
        let patches = exact_patches(&sphere, &samples, KEPT);
        let simplified = mesh_samples(&points_and_normals(&sphere, &samples), &patches).unwrap();
        assert!((310..=316).contains(&simplified.faces().len()));
        let outward = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| Vec3::from(simplified.positions()[v as usize]));
            (b - a).cross(c - a).dot(a + b + c) > 0.0
        };
        assert!(simplified.faces().iter().all(outward));
        let nothing = TriMesh::new(Vec::new(), Vec::new()).unwrap();
        let refused = simplify(&nothing, 9, 0, &LearnedBaseline::Dse.initial_tensors(0.05, 1)).unwrap_err();
        assert!(refused.to_string().contains("no face"), "{refused}");
    }

    fn open_edges(mesh: &TriMesh, n: usize) -> [usize; 2] {
        let samples = farthest_points(mesh.positions(), n, 0);
        let points: Vec<[f32; 3]> = samples.iter().map(|&v| mesh.positions()[v as usize]).collect();
        let faces = reconstruct(&points, &exact_patches(mesh, &samples, 24));
        let all = edges(&TriMesh::new(points, faces).unwrap());
        assert!(all.iter().all(|edge| edge.n_faces() <= 2));
        [all.iter().filter(|edge| edge.n_faces() == 1).count(), all.len()]
    }

    #[test]
    fn a_plane_is_covered_once() {
        let grid = shapes::grid(20, 20);
        let samples: Vec<u32> = (0..441).collect();
        let faces = reconstruct(grid.positions(), &exact_patches(&grid, &samples, 24));
        let area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|v| glam::Vec3::from(grid.positions()[v as usize]));
            0.5 * (b - a).cross(c - a).length()
        };
        let [all, original] = [&faces[..], grid.faces()].map(|faces| faces.iter().map(area).sum::<f32>());
        assert!(all <= 1.0001 * original && all > 0.98 * original, "{all} {original}");
    }

    #[test]
    fn round_surfaces_are_nearly_closed() {
        let sphere = shapes::icosphere(3);
        let patches = exact_patches(&sphere, &(0..642).collect::<Vec<u32>>(), 24);
        assert_eq!(reconstruct(sphere.positions(), &patches).len(), 1280);
        for (mesh, n) in
            [(shapes::icosphere(4), 400), (shapes::wavy_sphere(4, 5.0), 600), (shapes::torus(80, 40, 1.0, 0.4), 500)]
        {
            let [open, all] = open_edges(&mesh, n);
            assert!(50 * open < all, "{open} of {all}");
        }
    }

    #[test]
    fn nothing_of_nothing() {
        assert!(reconstruct(&[], &[]).is_empty());
        let two = [
            Patch { points: vec![0, 1], map: vec![[0.0; 2], [1.0, 0.0]] },
            Patch { points: vec![1, 0], map: vec![[0.0; 2]; 2] },
        ];
        assert!(reconstruct(&[[0.0; 3], [1.0; 3]], &two).is_empty());
    }
}
