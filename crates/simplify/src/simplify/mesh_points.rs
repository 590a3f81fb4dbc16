//! Surfaces from point clouds by the Edge Predictor and the Face Classifier (Secs. 3.2 and 3.3).
//!
//! A cloud has no triangles. Those of local Delaunay triangulations take the place of the mesh's, an addition to the paper.

use super::cloud::{ManifoldFaces, StarTriangles, close_surface, smooth_noise, star_triangles};
use super::paper::{NO_SAMPLE, Quotient, RegionQuadrics, assign_to_samples, quotient};
use super::progress::{POINTS, Progress, run_with_listener};
use super::{Listener, SimplifyError, scattered_samples};
use crate::geometry::triangle::area_normal_f64;
use crate::linalg::Csr;
use crate::mesh::{TriMesh, compact, orient_outward};
use crate::model::{
    PredictedFaces, Weights, extended_graph, in_edge_lengths, predict_edges, predict_faces, vertex_scores,
};
use glam::Vec3;
use std::sync::Arc;

/// Neighbours per point: the mean valence of a triangle mesh.
// Clouds of twelve training meshes: with 5 the result is 29 % farther from the original; with 8 (measured on nine), 37
// % farther.
const NEIGHBOURS: usize = 6;

/// Neighbours of a point whose triangulation is looked at; the Edge Predictor's k.
const AROUND: usize = 15;

/// Options of [`mesh_points`].
#[derive(Clone, Copy, Debug)]
pub struct PointsOptions<'a> {
    /// Points that become vertices; more than there are means all.
    pub n_vertices: usize,
    /// Whether vertices stay at their points, and noise with them.
    pub keep_points: bool,
    /// Normal of each point, n x 3, towards which the faces look; without, they look outward.
    pub normals: Option<&'a [[f32; 3]]>,
    /// Seed of the sampling.
    pub seed: u64,
}

impl PointsOptions<'_> {
    /// Makes the default options for `n_vertices` vertices.
    pub fn new(n_vertices: usize) -> Self {
        Self { n_vertices, keep_points: false, normals: None, seed: 0 }
    }
}

/// Mesh over points of a cloud.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct MeshedPoints {
    /// Oriented mesh with at most two faces per edge and one fan or disk of faces per vertex.
    pub mesh: TriMesh,
    /// Point of the cloud at each vertex, ascending.
    pub source_points: Vec<u32>,
    /// Number of sampled points on no face.
    pub unused_points: usize,
    /// Neighbours over which noise was smoothed, if it was.
    pub smoothed_over: Option<usize>,
    /// Whether vertices were moved from their points, by smoothing or placing.
    pub has_moved: bool,
}

/// Builds a mesh over `options.n_vertices` points of a cloud; over all if it has fewer.
///
/// The Point Sampler's scores choose the points. Noisy points are smoothed. If not all points are vertices, vertices are
/// placed as with [`PaperOptions::place`](super::PaperOptions::place). Holes are closed except large ones.
///
/// # Shapes
/// - `points`: n x 3, finite
///
/// # Errors
/// [`SimplifyError::TooFewPoints`], [`SimplifyError::NothingKept`] or [`SimplifyError::Interrupted`].
///
/// # Panics
/// If there are normals, but not one per point.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::shapes, model::Weights, simplify::{PointsOptions, SimplifyError, mesh_points}};
/// use std::ops::ControlFlow;
/// let cloud = shapes::icosphere(2);
/// let options = PointsOptions::new(100);
/// match mesh_points(cloud.positions(), &options, &Weights::random(1), &mut |_| ControlFlow::Continue(())) {
///     Ok(result) => assert_eq!(result.source_points.len() + result.unused_points, 100),
///     Err(error) => assert_eq!(error, SimplifyError::NothingKept),
/// }
/// ```
pub fn mesh_points(
    points: &[[f32; 3]],
    options: &PointsOptions,
    weights: &Weights,
    progress: &mut Listener,
) -> Result<MeshedPoints, SimplifyError> {
    assert!(options.normals.is_none_or(|normals| normals.len() == points.len()), "one normal per point");
    let n_samples = options.n_vertices.min(points.len());
    if n_samples < 3 {
        return Err(SimplifyError::TooFewPoints(n_samples));
    }
    run_with_listener(progress, &POINTS, |progress| {
        mesh_cloud(points, &PointsOptions { n_vertices: n_samples, ..*options }, weights, progress)
    })
}

fn mesh_cloud(
    points: &[[f32; 3]],
    options: &PointsOptions,
    weights: &Weights,
    progress: Progress,
) -> Result<MeshedPoints, SimplifyError> {
    progress.enter("scores", 1)?;
    let smoothed = if options.keep_points { None } else { smooth_noise(points) };
    let (points, crowding) = smoothed.as_ref().map_or((points, None), |all| (&all.points[..], Some(&all.crowding[..])));
    let smoothed_over = smoothed.as_ref().map(|all| all.neighbours);
    let cloud = TriangulatedCloud::new(points)?;
    let places = !options.keep_points && options.n_vertices < points.len();
    let sampled = cloud.draw_samples(options, crowding, weights, progress)?;
    progress.enter("edges", 1)?;
    // Edges between samples are longer, so the units change.
    let between = quotient(points, cloud.surface.faces(), &sampled.assignment, sampled.samples.len());
    let scaled = in_edge_lengths(&gather(points, &sampled.samples), &between.edges);
    let edges = predict_edges(weights, &scaled, &Arc::new(between.edges.clone()));
    progress.enter("faces", 1)?;
    let stars = match options.n_vertices == points.len() {
        true => cloud.stars,
        false => star_triangles(&scaled, &edges.graph),
    };
    let faces = predict_faces(weights, &scaled, &edges, &unite(&between, stars, &edges.graph));
    progress.enter("assemble", 1)?;
    let mut chosen = choose_faces(&scaled, &faces);
    close_surface(&scaled, &mut chosen);
    let faces = orient(&scaled, chosen, options.normals.map(|normals| gather(normals, &sampled.samples)));
    let in_cloud: Vec<[u32; 3]> = faces.iter().map(|face| face.map(|at| sampled.samples[at as usize])).collect();
    let positions = match places {
        true => RegionQuadrics::new(&cloud.surface, &sampled.samples, &sampled.assignment).place_samples(&in_cloud),
        false => gather(points, &sampled.samples),
    };
    let meshed = assemble_mesh(&positions, &sampled.samples, faces)?;
    Ok(MeshedPoints { smoothed_over, has_moved: places || smoothed_over.is_some(), ..meshed })
}

/// A cloud with the triangles on which its points agree.
struct TriangulatedCloud {
    /// Points, and triangles that two of their corners have in their stars.
    surface: TriMesh,
    stars: StarTriangles,
    /// Edges of the triangles, n x n.
    graph: Arc<Csr>,
    /// Points in units of these edges, n x 3.
    scaled: Vec<[f32; 3]>,
}

struct CloudSamples {
    /// Sampled points, ascending.
    samples: Vec<u32>,
    /// Sample of each point, or [`NO_SAMPLE`].
    assignment: Vec<u32>,
}

impl TriangulatedCloud {
    fn new(points: &[[f32; 3]]) -> Result<Self, SimplifyError> {
        let near = extended_graph(points, &Csr::from_edges(points.len(), []), AROUND);
        let stars = star_triangles(points, &near);
        let surface = TriMesh::new(points.to_vec(), stars.list_agreed()).map_err(|_| SimplifyError::Overflow)?;
        let graph = Arc::new(super::edge_graph(&surface));
        // The network expects points in units of edge lengths.
        let scaled = in_edge_lengths(points, &graph);
        Ok(Self { surface, stars, graph, scaled })
    }

    /// Draws samples, whose density does not grow with the `crowding` of points.
    fn draw_samples(
        &self,
        options: &PointsOptions,
        crowding: Option<&[f32]>,
        weights: &Weights,
        progress: Progress,
    ) -> Result<CloudSamples, SimplifyError> {
        let Self { surface, graph, scaled, .. } = self;
        let n = options.n_vertices;
        // All points are wanted, so no scores are needed.
        if n == scaled.len() {
            progress.enter("assign", 1)?;
            let all: Vec<u32> = (0..n as u32).collect();
            return Ok(CloudSamples { assignment: all.clone(), samples: all });
        }
        let mut scores = vertex_scores(weights, scaled, None, graph);
        let crowds = scores.iter_mut().zip(crowding.into_iter().flatten());
        crowds.for_each(|(score, crowding)| *score -= crowding.ln());
        let mut samples = scattered_samples(scaled, graph, &scores, n, options.seed);
        progress.enter("assign", 1)?;
        let mut assignment = assign_to_samples(scaled, graph, &samples);
        if !options.keep_points {
            let scores = RegionQuadrics::new(surface, &samples, &assignment).scores(&assignment, &scores);
            samples = scattered_samples(scaled, graph, &scores, n, options.seed);
            assignment = assign_to_samples(scaled, graph, &samples);
        }
        Ok(CloudSamples { samples, assignment })
    }
}

/// Unites the triangles of regions with those of stars whose edges are in `graph`; sorted, without repeats.
fn unite(between: &Quotient, stars: StarTriangles, graph: &Csr) -> Vec<[u32; 3]> {
    let has_edges = |[i, j, k]: &[u32; 3]| {
        [(i, j), (i, k), (j, k)].into_iter().all(|(&from, &to)| graph.position(from as usize, to).is_some())
    };
    let mut triangles: Vec<[u32; 3]> = stars.triangles.into_iter().filter(has_edges).collect();
    triangles.extend(&between.triangles);
    triangles.sort_unstable();
    triangles.dedup();
    triangles
}

/// Chooses candidates, the likeliest first, as long as they form a manifold.
fn choose_faces<'a>(points: &'a [[f32; 3]], faces: &PredictedFaces) -> ManifoldFaces<'a> {
    let PredictedFaces { candidates, probabilities, .. } = faces;
    let mut ranked: Vec<usize> = (0..probabilities.len()).collect();
    let triangle = |at: usize| candidates.triangles[at];
    ranked.sort_unstable_by(|&a, &b| {
        probabilities[b].total_cmp(&probabilities[a]).then_with(|| triangle(a).cmp(&triangle(b)))
    });
    let mut chosen = ManifoldFaces::new(points);
    ranked.into_iter().filter(|&at| probabilities[at] > 0.5).for_each(|at| _ = chosen.add_unfolded(triangle(at)));
    chosen
}

/// Winds the faces of each component towards the normals of the points, or outward.
fn orient(points: &[[f32; 3]], mut chosen: ManifoldFaces, normals: Option<Vec<[f32; 3]>>) -> Vec<[u32; 3]> {
    let mut faces = chosen.list_wound_faces();
    let Some(normals) = normals else { return orient_outward(points, &faces) };
    let components = chosen.components();
    let mut agreement = vec![0.0; faces.len()];
    for (face, &root) in faces.iter().zip(&components) {
        let double = |p: [f32; 3]| Vec3::from(p).as_dvec3();
        let normal = area_normal_f64(face.map(|v| double(points[v as usize])));
        agreement[root as usize] += face.iter().map(|&v| normal.dot(double(normals[v as usize]))).sum::<f64>();
    }
    let turned = faces.iter_mut().zip(&components).filter(|(_, root)| agreement[**root as usize] < 0.0);
    turned.for_each(|(face, _)| face.swap(1, 2));
    faces
}

fn gather(rows: &[[f32; 3]], some: &[u32]) -> Vec<[f32; 3]> {
    some.iter().map(|&at| rows[at as usize]).collect()
}

fn assemble_mesh(positions: &[[f32; 3]], samples: &[u32], faces: Vec<[u32; 3]>) -> Result<MeshedPoints, SimplifyError> {
    if faces.is_empty() {
        return Err(SimplifyError::NothingKept);
    }
    let (mesh, used) = compact(positions, faces).map_err(|_| SimplifyError::Overflow)?;
    let source_points: Vec<u32> = used.iter().map(|&at| samples[at as usize]).collect();
    let unused_points = samples.len() - source_points.len();
    Ok(MeshedPoints { mesh, source_points, unused_points, smoothed_over: None, has_moved: false })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::run_on_threads;
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

    fn run(points: &[[f32; 3]], options: &PointsOptions, weights: &Weights) -> Result<MeshedPoints, SimplifyError> {
        mesh_points(points, options, weights, &mut go_on)
    }

    #[test]
    fn any_weights_give_an_oriented_manifold_over_points_of_the_cloud() {
        let mut n_results = 0;
        for (shape, n) in [(shapes::icosphere(3), 642), (shapes::torus(24, 12, 1.0, 0.4), 150)] {
            for seed in 0..6 {
                let options = PointsOptions { keep_points: true, seed, ..PointsOptions::new(n) };
                let Ok(result) = run(shape.positions(), &options, &small_weights(seed)) else { continue };
                n_results += 1;
                let figures = topology(&result.mesh);
                assert_eq!((figures.non_manifold_edges, figures.inconsistent_edges), (0, 0));
                assert_eq!(result.source_points.len() + result.unused_points, n);
                assert!(result.source_points.is_sorted_by(|a, b| a < b) && !result.has_moved);
                assert_eq!(result.mesh.positions(), gather(shape.positions(), &result.source_points));
            }
        }
        assert!(n_results > 2);
    }

    #[cfg(feature = "paper")]
    #[test]
    fn clouds_of_closed_surfaces_become_closed() {
        let (ball, box_) = (shapes::icosphere(4), shapes::cuboid([1.0, 2.0, 3.0], 12));
        for shape in [ball, box_, shapes::torus(60, 30, 1.0, 0.4), shapes::wavy_sphere(4, 5.0)] {
            for (share, keep_points) in [(1.0, true), (0.5, false), (0.5, true), (0.2, false), (0.2, true)] {
                let n_vertices = (share * shape.positions().len() as f64) as usize;
                let options = PointsOptions { keep_points, ..PointsOptions::new(n_vertices) };
                let result = run(shape.positions(), &options, Weights::shipped_paper_open()).unwrap();
                let figures = topology(&result.mesh);
                assert!(figures.is_closed_manifold(), "{share}: {figures:?}");
                assert!(crate::metrics::volume(&result.mesh).unwrap() > 0.0);
            }
        }
    }

    #[cfg(feature = "paper")]
    #[test]
    fn placed_vertices_are_nearer_to_a_smooth_surface() {
        use crate::metrics::quick_distance;
        let shape = shapes::wavy_sphere(5, 5.0);
        let means = [false, true].map(|keep_points| {
            let options = PointsOptions { keep_points, ..PointsOptions::new(400) };
            let result = run(shape.positions(), &options, Weights::shipped_paper_open()).unwrap();
            quick_distance(&shape, &result.mesh, 4000, 0).unwrap().mean
        });
        assert!(means[0] < 0.8 * means[1], "{means:?}");
    }

    #[cfg(feature = "paper")]
    #[test]
    fn noise_leaves_an_oriented_manifold_nearer_to_the_surface() {
        use crate::metrics::quick_distance;
        use rand_xoshiro::Xoshiro256PlusPlus;
        use rand_xoshiro::rand_core::{Rng, SeedableRng};
        let sphere = shapes::icosphere(4);
        let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
        let mut noise = || 0.25 * ((random.next_u64() >> 40) as f32 / (1u64 << 24) as f32 - 0.5);
        let noisy: Vec<[f32; 3]> = sphere.positions().iter().map(|p| p.map(|x| x + noise())).collect();
        let means = [false, true].map(|keep_points| {
            let options = PointsOptions { keep_points, ..PointsOptions::new(noisy.len()) };
            let result = run(&noisy, &options, Weights::shipped_paper_open()).unwrap();
            let figures = topology(&result.mesh);
            assert_eq!((figures.non_manifold_edges, figures.inconsistent_edges), (0, 0));
            assert_eq!(result.has_moved, !keep_points);
            quick_distance(&sphere, &result.mesh, 4000, 0).unwrap().mean
        });
        assert!(means[0] < 0.5 * means[1], "{means:?}");
    }

    #[cfg(feature = "paper")]
    #[test]
    fn faces_look_where_the_normals_do() {
        let sphere = shapes::icosphere(3);
        for sign in [1.0, -1.0] {
            let normals: Vec<[f32; 3]> = sphere.positions().iter().map(|p| p.map(|x| sign * x)).collect();
            let options = PointsOptions { normals: Some(&normals), ..PointsOptions::new(642) };
            let result = run(sphere.positions(), &options, Weights::shipped_paper_open()).unwrap();
            assert!(f64::from(sign) * crate::metrics::volume(&result.mesh).unwrap() > 3.0);
        }
    }

    #[cfg(feature = "paper")]
    #[test]
    fn a_large_boundary_of_a_cloud_stays() {
        let mut bowl = shapes::icosphere(4).positions().to_vec();
        bowl.retain(|p| p[2] < 0.5);
        let result = run(&bowl, &PointsOptions::new(9999), Weights::shipped_paper_open()).unwrap();
        let figures = topology(&result.mesh);
        assert_eq!((figures.boundary_loops, figures.components, figures.non_manifold_vertices), (1, 1, 0));
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
        let on = |n| {
            run_on_threads(n, || {
                run(torus.positions(), &PointsOptions { seed: 3, ..PointsOptions::new(120) }, &small_weights(1))
            })
        };
        assert_eq!(on(1), on(3));
    }

    #[test]
    fn tiny_clouds_are_refused_and_flat_or_distant_parts_are_fine() {
        let weights = small_weights(1);
        let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 9.0]];
        for n in 0..3 {
            assert_eq!(run(&points[..n], &PointsOptions::new(9), &weights), Err(SimplifyError::TooFewPoints(n)));
            assert_eq!(run(&points, &PointsOptions::new(n), &weights), Err(SimplifyError::TooFewPoints(n)));
        }
        for n in 3..5 {
            let result = run(&points[..n], &PointsOptions::new(9), &weights);
            assert!(result.is_ok() || result == Err(SimplifyError::NothingKept));
        }
        let line: Vec<[f32; 3]> = (0..40).map(|i| [i as f32, 0.0, 0.0]).collect();
        assert_eq!(run(&line, &PointsOptions::new(20), &weights), Err(SimplifyError::NothingKept));
    }

    #[test]
    fn progress_can_stop_every_stage() {
        let sphere = shapes::icosphere(1);
        for name in ["scores", "assign", "edges", "faces", "assemble"] {
            let mut stop = |event: Event| if event.stage == name { ControlFlow::Break(()) } else { go_on(event) };
            let result = mesh_points(sphere.positions(), &PointsOptions::new(40), &small_weights(1), &mut stop);
            assert_eq!(result, Err(SimplifyError::Interrupted), "{name}");
        }
    }
}
