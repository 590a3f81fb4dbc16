//! Surfaces from point clouds by the Edge Predictor and the Face Classifier (Secs. 3.2 and 3.3).

use std::sync::Arc;

use super::paper::{NO_SAMPLE, assign_to_samples, choose_faces};
use super::progress::{POINTS, Progress, run_with_listener};
use super::{Listener, SimplifyError, scattered_samples};
use crate::linalg::Csr;
use crate::mesh::{TriMesh, compact, orient_outward};
use crate::model::{Weights, extended_graph, in_edge_lengths, predict_edges, predict_faces, vertex_scores};

/// Neighbours per point: the mean valence of a triangle mesh.
// Clouds of twelve training meshes: with 5 the result is 29 % farther from the original; with 8 (measured on nine), 37
// % farther.
const NEIGHBOURS: usize = 6;

/// Mesh over points of a cloud.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MeshedPoints {
    /// Mesh with at most two faces per edge.
    pub mesh: TriMesh,
    /// Point of the cloud at each vertex, ascending.
    pub source_points: Vec<u32>,
    /// Number of sampled points on no face.
    pub unused_points: usize,
}

/// Builds a mesh over `n_vertices` points of a cloud, which stay in place; over all if it has fewer.
///
/// The Point Sampler's scores choose the points.
///
/// # Shapes
/// - `points`: n x 3, finite
///
/// # Errors
/// [`SimplifyError::TooFewPoints`], [`SimplifyError::NothingKept`] or [`SimplifyError::Interrupted`].
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::shapes, model::Weights, simplify::{SimplifyError, mesh_points}};
/// use std::ops::ControlFlow;
/// let cloud = shapes::icosphere(2);
/// match mesh_points(cloud.positions(), 100, &Weights::random(1), 0, &mut |_| ControlFlow::Continue(())) {
///     Ok(result) => assert_eq!(result.source_points.len() + result.unused_points, 100),
///     Err(error) => assert_eq!(error, SimplifyError::NothingKept),
/// }
/// ```
pub fn mesh_points(
    points: &[[f32; 3]],
    n_vertices: usize,
    weights: &Weights,
    seed: u64,
    progress: &mut Listener,
) -> Result<MeshedPoints, SimplifyError> {
    let n_samples = n_vertices.min(points.len());
    if n_samples < 3 {
        return Err(SimplifyError::TooFewPoints(n_samples));
    }
    run_with_listener(progress, &POINTS, |progress| mesh_cloud(points, n_samples, weights, seed, progress))
}

fn mesh_cloud(
    points: &[[f32; 3]],
    n_samples: usize,
    weights: &Weights,
    seed: u64,
    progress: Progress,
) -> Result<MeshedPoints, SimplifyError> {
    progress.enter("scores", 1)?;
    let graph = Arc::new(cloud_graph(points));
    // The network expects points in units of edge lengths.
    let cloud = in_edge_lengths(points, &graph);
    let samples = draw_samples(&cloud, &graph, n_samples, weights, seed);
    progress.enter("assign", 1)?;
    let assignment = assign_to_samples(&cloud, &graph, &samples);
    let original = Arc::new(region_graph(&graph, &assignment, samples.len()));
    progress.enter("edges", 1)?;
    let sampled: Vec<[f32; 3]> = samples.iter().map(|&at| cloud[at as usize]).collect();
    // Edges between samples are longer, so the units change.
    let sampled = in_edge_lengths(&sampled, &original);
    let edges = predict_edges(weights, &sampled, &original);
    progress.enter("faces", 1)?;
    let faces = predict_faces(weights, &sampled, &edges, &[]);
    progress.enter("assemble", 1)?;
    let chosen = choose_faces(&faces, edges.graph.n_entries());
    let chosen: Vec<[u32; 3]> = chosen.into_iter().map(|at| faces.candidates.triangles[at]).collect();
    assemble_mesh(points, &samples, &orient_outward(&sampled, &chosen))
}

/// Builds the graph (n x n) that joins each point of a cloud (n x 3) and its six nearest points, in both directions.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::simplify::cloud_graph;
/// assert_eq!(cloud_graph(&[[0.0; 3], [1.0, 0.0, 0.0]]).row(0), [1]);
/// ```
pub fn cloud_graph(points: &[[f32; 3]]) -> Csr {
    extended_graph(points, &Csr::from_edges(points.len(), []), NEIGHBOURS)
}

fn draw_samples(cloud: &[[f32; 3]], graph: &Arc<Csr>, n: usize, weights: &Weights, seed: u64) -> Vec<u32> {
    // All points are wanted, so no scores are needed.
    if n == cloud.len() {
        return (0..n as u32).collect();
    }
    scattered_samples(cloud, graph, &vertex_scores(weights, cloud, None, graph), n, seed)
}

/// Builds the graph of the samples whose regions an edge of `graph` joins: A of Eq. (3) for a cloud.
///
/// # Shapes
/// - `graph`: n x n; `assignment`: n, the sample of each point, `u32::MAX` for none
/// - returns n_samples x n_samples
///
/// # Panics
/// If an assignment is neither below `n_samples` nor `u32::MAX`, or there are fewer than n.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::simplify::{cloud_graph, region_graph};
/// let graph = cloud_graph(&[[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
/// assert_eq!(region_graph(&graph, &[0, 1, 1], 2).row(0), [1]);
/// ```
pub fn region_graph(graph: &Csr, assignment: &[u32], n_samples: usize) -> Csr {
    let regions = graph.entries().map(|edge| edge.map(|at| assignment[at as usize]));
    Csr::from_edges(n_samples, regions.filter(|regions| !regions.contains(&NO_SAMPLE)))
}

fn assemble_mesh(points: &[[f32; 3]], samples: &[u32], faces: &[[u32; 3]]) -> Result<MeshedPoints, SimplifyError> {
    if faces.is_empty() {
        return Err(SimplifyError::NothingKept);
    }
    let positions: Vec<[f32; 3]> = samples.iter().map(|&at| points[at as usize]).collect();
    let (mesh, used) = compact(&positions, faces.to_vec()).map_err(|_| SimplifyError::Overflow)?;
    let source_points: Vec<u32> = used.iter().map(|&at| samples[at as usize]).collect();
    Ok(MeshedPoints { mesh, unused_points: samples.len() - source_points.len(), source_points })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, topology};
    use crate::model::Architecture;
    use crate::simplify::Event;
    use std::ops::ControlFlow;

    fn go_on(_: Event) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn small_weights(seed: u64) -> Weights {
        Weights::random_of(Architecture::narrow(), seed)
    }

    fn results(points: &[[f32; 3]], n: usize) -> Vec<MeshedPoints> {
        let results: Vec<MeshedPoints> =
            (0..6).filter_map(|seed| mesh_points(points, n, &small_weights(seed), seed, &mut go_on).ok()).collect();
        assert!(results.len() > 1);
        results
    }

    #[test]
    fn every_edge_has_at_most_two_faces_and_vertices_are_points_of_the_cloud() {
        for (shape, n) in [(shapes::icosphere(3), 642), (shapes::torus(24, 12, 1.0, 0.4), 150)] {
            for result in results(shape.positions(), n) {
                assert_eq!(topology(&result.mesh).non_manifold_edges, 0);
                assert_eq!(result.source_points.len() + result.unused_points, n.min(shape.positions().len()));
                assert!(result.source_points.is_sorted_by(|a, b| a < b));
                let moved = |(p, &at): (&[f32; 3], &u32)| *p != shape.positions()[at as usize];
                assert!(!result.mesh.positions().iter().zip(&result.source_points).any(moved));
            }
        }
    }

    #[test]
    fn faces_agree_across_edges_wherever_they_can() {
        for result in results(shapes::icosphere(3).positions(), 200) {
            let figures = topology(&result.mesh);
            assert!(!figures.orientable || figures.inconsistent_edges == 0);
        }
    }

    #[test]
    fn the_graph_of_regions_joins_neighbours_only() {
        let sphere = shapes::icosphere(4);
        let graph = cloud_graph(sphere.positions());
        let cloud = in_edge_lengths(sphere.positions(), &graph);
        let everyone: Vec<u32> = (0..cloud.len() as u32).collect();
        assert_eq!(region_graph(&graph, &everyone, everyone.len()), graph);
        let samples: Vec<u32> = (0..cloud.len() as u32).step_by(16).collect();
        let assignment = assign_to_samples(&cloud, &graph, &samples);
        let regions = region_graph(&graph, &assignment, samples.len());
        let degree = regions.n_entries() as f64 / samples.len() as f64;
        assert!((5.0..8.0).contains(&degree), "{degree}");
    }

    #[test]
    fn the_same_seed_gives_the_same_mesh_on_any_number_of_threads() {
        let torus = shapes::torus(24, 12, 1.0, 0.4);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| mesh_points(torus.positions(), 120, &small_weights(1), 3, &mut go_on))
        };
        assert_eq!(on(1), on(3));
    }

    #[test]
    fn tiny_clouds_are_refused_and_flat_or_distant_parts_are_fine() {
        let weights = small_weights(1);
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 9.0]];
        for n in 0..3 {
            let refused = mesh_points(&points[..n], 9, &weights, 0, &mut go_on);
            assert_eq!(refused, Err(SimplifyError::TooFewPoints(n)));
            assert_eq!(mesh_points(&points, n, &weights, 0, &mut go_on), Err(SimplifyError::TooFewPoints(n)));
        }
        for n in 3..5 {
            let result = mesh_points(&points[..n], 9, &weights, 0, &mut go_on);
            assert!(result.is_ok() || result == Err(SimplifyError::NothingKept));
        }
    }

    #[test]
    fn progress_can_stop_every_stage() {
        let sphere = shapes::icosphere(1);
        for name in ["scores", "assign", "edges", "faces", "assemble"] {
            let mut stop = |event: Event| if event.stage == name { ControlFlow::Break(()) } else { go_on(event) };
            let result = mesh_points(sphere.positions(), 40, &small_weights(1), 0, &mut stop);
            assert_eq!(result, Err(SimplifyError::Interrupted), "{name}");
        }
    }
}
