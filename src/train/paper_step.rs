//! The step of the objective "paper": the network of Secs. 3.1 to 3.3 on one mesh, judged by the losses of Sec. 3.4.
//!
//! The Point Sampler learns from its own term alone; samples, candidates and their graph are drawn and then held, so
//! that the gradient reaches Edge Predictor and Face Classifier through the probabilities of the faces.

use super::face_terms::{Faces, face_terms, judges_faces};
use super::patch::patch;
use super::random::{below, uniform};
use super::sampler_terms::{Surface, sampler_terms};
use super::scored::{Scored, constant, scored, scored_along};
use super::{Item, Settings, Step, gradients_of};
use crate::autodiff::{Tape, Value};
use crate::linalg::{Csr, Matrix};
use crate::loss::{NamedTerm, total};
use crate::mesh::TriMesh;
use crate::model::{
    CandidateFaces, EdgeFrame, Network, Weights, candidate_faces, edge_predictor, extended_graph, face_classifier,
    prior, triangle_graph,
};
use crate::simplify::paper::{Quotient, assign_to_samples, quotient};
use crate::simplify::{cloud_graph, edge_graph, region_graph, scattered_samples};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;
use std::sync::Arc;

/// Fewer samples than this make no surface to learn from.
const LEAST_SAMPLES: usize = 16;

/// One step: its terms, each times its weight in the settings, and the gradient of their sum.
pub(super) fn paper_step(
    weights: &Weights,
    item: &Item,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<Step, String> {
    let mesh = piece(item, settings, random)?;
    let n_samples = (mesh.positions().len() as f64 * item.ratio) as usize;
    if n_samples < LEAST_SAMPLES {
        return Err(format!("has fewer than {LEAST_SAMPLES} samples at this ratio"));
    }
    let as_cloud = settings.clouds > 0.0 && uniform(random) < settings.clouds;
    let Scored { mut tape, net, rings, points, normals, scores } = match as_cloud {
        false => scored(weights, &mesh),
        true => scored_along(weights, mesh.positions(), unknown_normals(&mesh), cloud_graph(mesh.positions())),
    };
    let surface = Surface { points: &points, normals: &normals, rings: &rings };
    let of_scores = sampler_terms(&surface, scores.matrix().data(), n_samples, settings, random);
    let mut results = vec![(scores.clone(), of_scores)];
    if judges_faces(settings) {
        let samples = scattered_samples(&points, &rings, scores.matrix().data(), n_samples, random.next_u64());
        let drawn = draw(&mesh, &points, &rings, &samples, as_cloud);
        let (probabilities, candidates) = classified(&mut tape, &net, &drawn, weights);
        let faces = Faces { mesh: &mesh, drawn: &drawn, candidates: &candidates };
        let of_faces = face_terms(&faces, probabilities.matrix().data(), settings, random);
        results.push((probabilities, of_faces));
    }
    let terms = results.iter().flat_map(|(_, terms)| terms);
    let terms = terms.map(|term| (term.name, term.weight * term.term.value)).collect();
    let gradients: Vec<_> = results.iter().map(|(values, terms)| (values, gradient(values, terms))).collect();
    Ok(Step { terms, gradients: gradients_of(&net, &tape.backward(&gradients)) })
}

/// The mesh, or a piece of it where it would have too many samples.
fn piece(item: &Item, settings: &Settings, random: &mut Xoshiro256PlusPlus) -> Result<TriMesh, String> {
    let most = settings.max_samples as f64 / item.ratio;
    if settings.max_samples == 0 || item.mesh.positions().len() as f64 <= most {
        return Ok(item.mesh.clone());
    }
    let start = below(random, item.mesh.positions().len());
    patch(&item.mesh, &edge_graph(&item.mesh), most as usize, start as u32).ok_or("has no face in one piece".into())
}

fn unknown_normals(mesh: &TriMesh) -> Vec<[f32; 3]> {
    vec![[0.0; 3]; mesh.positions().len()]
}

/// Samples and what the mesh says of them.
pub(super) struct Drawn {
    /// The frame in which the network sees the samples.
    pub frame: EdgeFrame,
    /// The samples in that frame, n_samples x 3.
    pub points: Vec<[f32; 3]>,
    /// A of Eq. (3): which of their regions touch.
    pub edges: Csr,
    /// The triangles that the mesh spans between their regions.
    pub spanned: Vec<[u32; 3]>,
    /// Whether only A_s says which triangles are candidates.
    as_cloud: bool,
}

fn draw(mesh: &TriMesh, points: &[[f32; 3]], rings: &Csr, samples: &[u32], as_cloud: bool) -> Drawn {
    let assignment = assign_to_samples(points, rings, samples);
    let Quotient { edges, triangles: spanned, .. } =
        quotient(mesh.positions(), mesh.faces(), &assignment, samples.len());
    let edges = if as_cloud { region_graph(rings, &assignment, samples.len()) } else { edges };
    let sampled: Vec<[f32; 3]> = samples.iter().map(|&v| mesh.positions()[v as usize]).collect();
    let frame = EdgeFrame::of(&sampled, &edges);
    Drawn { points: frame.apply(&sampled), frame, edges, spanned, as_cloud }
}

/// Candidate faces, what they are joined with, and G_ext.
pub(super) struct Candidates {
    /// The candidates.
    pub faces: CandidateFaces,
    /// G_ext, whose entries they name.
    pub extended: Arc<Csr>,
    /// The nearest of them to each.
    pub neighbours: Arc<Csr>,
}

/// The Edge Predictor and the Face Classifier on the tape: the probabilities, and of what.
fn classified(tape: &mut Tape, net: &Network<Value>, drawn: &Drawn, weights: &Weights) -> (Value, Candidates) {
    let original = Arc::new(drawn.edges.clone());
    let sizes = weights.architecture();
    let extended = Arc::new(extended_graph(&drawn.points, &original, sizes.edge_knn).with_loops());
    let edges = edge_predictor(tape, &net.edge_predictor, &constant(&drawn.points), &extended, &original);
    let given: &[[u32; 3]] = if drawn.as_cloud { &[] } else { &drawn.spanned };
    let faces = candidate_faces(&extended, edges.adjacency.matrix().data(), given);
    let faces = faces.in_coherent_order(&drawn.points);
    let neighbours = Arc::new(triangle_graph(&drawn.points, &faces.triangles, sizes.face_knn));
    let prior = prior(tape, &edges.adjacency, &faces);
    let net = &net.face_classifier;
    let points = constant(&drawn.points);
    let probabilities = face_classifier(tape, net, &points, &faces.triangles, &neighbours, &prior);
    (probabilities, Candidates { faces, extended, neighbours })
}

/// The gradient of the weighted sum of terms to a column of values.
fn gradient(values: &Value, terms: &[NamedTerm]) -> Matrix {
    let n = values.matrix().n_rows();
    Matrix::new(n, 1, total(terms, n).gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::model::Weights;
    use rand_xoshiro::rand_core::SeedableRng;

    fn terms(toml: &str) -> Vec<(&'static str, f64)> {
        let settings = Settings::from_toml(toml).unwrap();
        let item = Item { name: "sphere".into(), mesh: shapes::wavy_sphere(3, 5.0), ratio: 0.1 };
        let weights = Weights::random(1);
        paper_step(&weights, &item, &settings, &mut Xoshiro256PlusPlus::seed_from_u64(0)).unwrap().terms
    }

    #[test]
    fn a_cloud_is_judged_by_the_mesh_it_came_from() {
        let (mesh, cloud) = (terms("clouds = 0.0"), terms("clouds = 1.0"));
        let names = |terms: &[(&'static str, f64)]| terms.iter().map(|term| term.0).collect::<Vec<_>>();
        assert_eq!(names(&mesh), names(&cloud));
        assert_ne!(mesh, cloud);
        assert!(cloud.iter().all(|term| term.1.is_finite()) && cloud.iter().any(|term| term.0 == "agreement"));
    }

    #[test]
    fn the_printed_losses_have_nothing_of_ours_among_them() {
        let printed = ["chamfer", "forward", "reverse", "collision", "crossing", "overlap"];
        assert_eq!(terms("literal = true").iter().map(|term| term.0).collect::<Vec<_>>(), printed);
    }
}
