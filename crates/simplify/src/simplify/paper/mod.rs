//! The paper's pipeline: sample, connect, classify, assemble (Secs. 3.1 to 3.3 and 4). The result need not be closed.

mod assembly;
mod assignment;
mod close;
mod place;
mod quotient;

pub use assembly::{choose_faces, orient_triangle};
pub use assignment::{NO_SAMPLE, assign_to_samples};
pub use close::close_holes;
pub use quotient::{Quotient, quotient};

pub(super) use self::place::RegionQuadrics;
use super::network_scores::edge_graph;
use super::progress::{PAPER_STAGES, Progress, run_with_listener};
use super::{Listener, PaperOptions, SimplifyError, vertex_normals};
use crate::mesh::TriMesh;
use crate::model::{PredictedEdges, PredictedFaces, in_edge_lengths, predict_edges, predict_faces, vertex_scores};
use std::sync::Arc;

/// Simplified mesh over vertices of the input.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperResult {
    /// Sampled vertices of the input, ascending; some may be on no face.
    pub vertices: Vec<u32>,
    /// Positions of these vertices: those of the input, unless they were placed.
    pub positions: Vec<[f32; 3]>,
    /// Vertices of the input at the corners, n_faces x 3; each edge has at most two faces.
    pub faces: Vec<[u32; 3]>,
}

/// Results of the stages before the assembly.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperStages {
    /// Score of each input vertex.
    pub scores: Vec<f32>,
    /// Sampled vertices of the input, ascending.
    pub samples: Vec<u32>,
    /// Sample of each input vertex, or [`NO_SAMPLE`].
    pub assignment: Vec<u32>,
    /// Edges, triangles and normals between the regions of the samples.
    pub quotient: Quotient,
    /// Predicted edges: the paper's G_ext, S and A_s.
    pub edges: PredictedEdges,
    /// Candidate faces with prior and probability.
    pub faces: PredictedFaces,
}

/// Simplifies a mesh as the paper does: `n_target_vertices` of its vertices stay.
///
/// # Errors
/// [`SimplifyError::Empty`], [`SimplifyError::NothingKept`] or [`SimplifyError::Interrupted`].
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::TriMesh, model::Weights, simplify::{PaperOptions, SimplifyError, paper::simplify_paper}};
/// use std::ops::ControlFlow;
/// let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let mesh = TriMesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]).unwrap();
/// let options = PaperOptions { weights: Some(Weights::random(1).into()), ..PaperOptions::default() };
/// match simplify_paper(&mesh, 4, &options, &mut |_| ControlFlow::Continue(())) {
///     Ok(result) => assert_eq!(result.vertices, [0, 1, 2, 3]),
///     Err(error) => assert_eq!(error, SimplifyError::NothingKept),
/// }
/// ```
pub fn simplify_paper(
    mesh: &TriMesh,
    n_target_vertices: usize,
    options: &PaperOptions,
    progress: &mut Listener,
) -> Result<PaperResult, SimplifyError> {
    run_with_listener(progress, &PAPER_STAGES, |progress| simplify_in_run(mesh, n_target_vertices, options, progress))
}

/// Simplifies as [`simplify_paper`] does, within a run.
pub(super) fn simplify_in_run(
    mesh: &TriMesh,
    n_target_vertices: usize,
    options: &PaperOptions,
    progress: Progress,
) -> Result<PaperResult, SimplifyError> {
    let stages = run_stages(mesh, n_target_vertices, options, progress)?;
    progress.enter("assemble", 1)?;
    let samples = &stages.samples;
    let mut faces = assemble(&gather(mesh.positions(), samples), &stages);
    if faces.is_empty() {
        return Err(SimplifyError::NothingKept);
    }
    if options.close {
        faces = close_holes(mesh, samples, &stages.assignment, faces);
    }
    let positions = match options.place {
        true => RegionQuadrics::new(mesh, samples, &stages.assignment).place_samples(&faces),
        false => gather(mesh.positions(), samples),
    };
    Ok(PaperResult { vertices: stages.samples, positions, faces })
}

/// Runs the stages before the assembly; see [`simplify_paper`].
///
/// # Errors
/// [`SimplifyError::Empty`] or [`SimplifyError::Interrupted`].
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::TriMesh, model::Weights, simplify::{PaperOptions, paper::paper_stages}};
/// use std::ops::ControlFlow;
/// let mesh = TriMesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]).unwrap();
/// let options = PaperOptions { weights: Some(Weights::random(1).into()), ..PaperOptions::default() };
/// let stages = paper_stages(&mesh, 3, &options, &mut |_| ControlFlow::Continue(())).unwrap();
/// assert_eq!(stages.faces.candidates.triangles, [[0, 1, 2]]);
/// ```
pub fn paper_stages(
    mesh: &TriMesh,
    n_target_vertices: usize,
    options: &PaperOptions,
    progress: &mut Listener,
) -> Result<PaperStages, SimplifyError> {
    run_with_listener(progress, &PAPER_STAGES, |progress| run_stages(mesh, n_target_vertices, options, progress))
}

fn run_stages(
    mesh: &TriMesh,
    n_target_vertices: usize,
    options: &PaperOptions,
    progress: Progress,
) -> Result<PaperStages, SimplifyError> {
    if mesh.faces().is_empty() {
        return Err(SimplifyError::Empty);
    }
    let weights = options.used_weights()?;
    progress.enter("scores", 1)?;
    let rings = Arc::new(edge_graph(mesh));
    let points = in_edge_lengths(mesh.positions(), &rings);
    let normals = (weights.architecture().point_sampler_inputs == 6).then(|| vertex_normals(mesh));
    let mut scores = vertex_scores(weights, &points, normals.as_deref(), &rings);
    progress.enter("sample", 1)?;
    let draw_samples =
        |scores: &[f32]| options.draw.draw_samples(&points, &rings, scores, n_target_vertices, options.seed);
    let mut samples = draw_samples(&scores);
    progress.enter("assign", 1)?;
    let mut assignment = assign_to_samples(&points, &rings, &samples);
    if options.place {
        scores = RegionQuadrics::new(mesh, &samples, &assignment).scores(&assignment, &scores);
        samples = draw_samples(&scores);
        assignment = assign_to_samples(&points, &rings, &samples);
    }
    let quotient = quotient(mesh.positions(), mesh.faces(), &assignment, samples.len());
    progress.enter("edges", 1)?;
    let sampled = in_edge_lengths(&gather(&points, &samples), &quotient.edges);
    let edges = predict_edges(weights, &sampled, &Arc::new(quotient.edges.clone()));
    progress.enter("faces", 1)?;
    let faces = predict_faces(weights, &sampled, &edges, &quotient.triangles);
    Ok(PaperStages { scores, samples, assignment, quotient, edges, faces })
}

fn assemble(sampled: &[[f32; 3]], stages: &PaperStages) -> Vec<[u32; 3]> {
    let chosen = choose_faces(&stages.faces, stages.edges.graph.n_entries());
    let triangles = chosen.iter().map(|&at| stages.faces.candidates.triangles[at]);
    let turned = triangles.map(|triangle| orient_triangle(triangle, sampled, &stages.quotient));
    turned.map(|face| face.map(|sample| stages.samples[sample as usize])).collect()
}

fn gather(points: &[[f32; 3]], samples: &[u32]) -> Vec<[f32; 3]> {
    samples.iter().map(|&vertex| points[vertex as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::run_on_threads;
    use crate::model::{Architecture, Weights};
    use crate::simplify::Event;
    use rustc_hash::FxHashMap;
    use std::f32::consts::TAU;
    use std::ops::ControlFlow;

    fn torus(n: u32, m: u32) -> TriMesh {
        let point = |i: u32| {
            let (u, v) = ((i / m) as f32 / n as f32 * TAU, (i % m) as f32 / m as f32 * TAU);
            [(2.0 + v.cos()) * u.cos(), (2.0 + v.cos()) * u.sin(), v.sin()]
        };
        let vertex = |i: u32, j: u32| i % n * m + j % m;
        let quads = (0..n).flat_map(|i| (0..m).map(move |j| [i, j]));
        let faces = quads.flat_map(|[i, j]| {
            let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
            [[a, b, c], [a, c, d]]
        });
        TriMesh::new((0..n * m).map(point).collect(), faces.collect()).unwrap()
    }

    fn go_on(_: Event) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    /// Options with small weights of seed `of_weights`.
    fn paper_options(of_weights: u64, seed: u64) -> PaperOptions {
        let weights = Weights::random_of(Architecture::narrow(), of_weights);
        PaperOptions { weights: Some(weights.into()), seed, ..PaperOptions::default() }
    }

    #[test]
    fn results_are_at_most_two_faces_per_edge_over_the_sampled_vertices() {
        let mesh = torus(24, 12);
        let mut n_results = 0;
        for seed in 0..4 {
            let Ok(result) = simplify_paper(&mesh, 60, &paper_options(seed, seed), &mut go_on) else {
                continue;
            };
            n_results += 1;
            assert_eq!(result.vertices.len(), 60);
            let mut n_faces_of_edge = FxHashMap::default();
            for [a, b, c] in result.faces {
                for [v, w] in [[a, b], [b, c], [c, a]] {
                    assert!(result.vertices.binary_search(&v).is_ok());
                    *n_faces_of_edge.entry([v.min(w), v.max(w)]).or_insert(0) += 1;
                }
            }
            assert!(n_faces_of_edge.values().all(|n| *n <= 2));
        }
        assert!(n_results > 0);
    }

    #[test]
    fn quotient_triangles_are_always_candidates() {
        let mesh = torus(24, 12);
        let stages = paper_stages(&mesh, 40, &paper_options(1, 5), &mut go_on).unwrap();
        assert!(!stages.quotient.triangles.is_empty());
        let candidates = &stages.faces.candidates.triangles;
        assert!(stages.quotient.triangles.iter().all(|triangle| candidates.contains(triangle)));
        assert!(candidates.len() > stages.quotient.triangles.len());
    }

    #[test]
    fn with_all_quotient_triangles_likely_a_torus_comes_back_closed() {
        let mesh = torus(24, 12);
        let mut stages = paper_stages(&mesh, 288, &paper_options(1, 5), &mut go_on).unwrap();
        let likely = |triangle| if stages.quotient.triangles.binary_search(triangle).is_ok() { 0.9 } else { 0.1 };
        stages.faces.probabilities = stages.faces.candidates.triangles.iter().map(likely).collect();
        let rotated = |face: &[u32; 3]| {
            let first = (0..3).min_by_key(|&i| face[i]).unwrap();
            [0, 1, 2].map(|i| face[(first + i) % 3])
        };
        let mut faces: Vec<[u32; 3]> = assemble(mesh.positions(), &stages).iter().map(rotated).collect();
        let mut original: Vec<[u32; 3]> = mesh.faces().iter().map(rotated).collect();
        faces.sort_unstable();
        original.sort_unstable();
        assert_eq!(faces, original);
    }

    #[cfg(feature = "paper")]
    #[test]
    fn placed_vertices_lie_nearer_to_the_surface() {
        use crate::mesh::{compact, shapes};
        use crate::metrics::quick_distance;
        let mesh = shapes::wavy_sphere(5, 5.0);
        let mean = |place| {
            let options = PaperOptions { close: true, place, ..PaperOptions::default() };
            let result = simplify_paper(&mesh, 400, &options, &mut go_on).unwrap();
            assert_eq!((result.vertices.len(), result.positions.len()), (400, 400));
            let mut positions = mesh.positions().to_vec();
            result.vertices.iter().zip(&result.positions).for_each(|(&v, &p)| positions[v as usize] = p);
            quick_distance(&mesh, &compact(&positions, result.faces).unwrap().0, 4000, 0).unwrap().mean
        };
        let [kept, placed] = [false, true].map(mean);
        assert!(placed < 0.7 * kept, "{placed} {kept}");
    }

    #[test]
    fn the_same_seed_gives_the_same_result_on_any_number_of_threads() {
        let mesh = torus(30, 20);
        let on_threads = |n| run_on_threads(n, || paper_stages(&mesh, 150, &paper_options(3, 9), &mut go_on)).unwrap();
        let one = on_threads(1);
        assert_eq!(one, on_threads(2));
        assert_eq!(one, on_threads(8));
    }

    #[test]
    fn tiny_targets_and_empty_meshes_have_sensible_answers() {
        assert_eq!(simplify_paper(&TriMesh::default(), 5, &paper_options(1, 0), &mut go_on), Err(SimplifyError::Empty));
        for n in 0..3 {
            let result = simplify_paper(&torus(5, 4), n, &paper_options(1, 0), &mut go_on);
            assert_eq!(result, Err(SimplifyError::NothingKept));
        }
        let stages = paper_stages(&torus(5, 4), 1000, &paper_options(1, 0), &mut go_on).unwrap();
        assert_eq!(stages.samples.len(), 20);
    }

    #[test]
    fn progress_can_stop_every_stage() {
        let mesh = torus(6, 5);
        let mut names = Vec::new();
        let _ = paper_stages(&mesh, 12, &paper_options(1, 0), &mut |event| {
            names.push(event.stage);
            go_on(event)
        });
        assert_eq!(names, ["scores", "sample", "assign", "edges", "faces"]);
        for name in names {
            let mut stop = |event: Event| if event.stage == name { ControlFlow::Break(()) } else { go_on(event) };
            assert_eq!(simplify_paper(&mesh, 12, &paper_options(1, 0), &mut stop), Err(SimplifyError::Interrupted));
        }
    }
}
