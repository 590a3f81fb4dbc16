//! Samples drawn from a mesh and held, and the candidate faces that the network makes of them (Secs. 3.2, 3.3).

use super::scored::constant;
use crate::autodiff::{Tape, Value};
use crate::linalg::Csr;
use crate::mesh::TriMesh;
use crate::model::{
    CandidateFaces, EdgeFrame, Network, Weights, choose_candidates, edge_predictor, extended_graph, face_classifier,
    prior,
};
use crate::simplify::paper::{Quotient, assign_to_samples, quotient};
use crate::simplify::region_graph;
use std::sync::Arc;

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

/// The samples, given as vertices, with what the mesh says of them; a cloud says which regions touch along `rings` alone.
pub(super) fn draw(mesh: &TriMesh, points: &[[f32; 3]], rings: &Csr, samples: &[u32], as_cloud: bool) -> Drawn {
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
pub(super) fn classified(
    tape: &mut Tape,
    net: &Network<Value>,
    drawn: &Drawn,
    weights: &Weights,
) -> (Value, Candidates) {
    let original = Arc::new(drawn.edges.clone());
    let sizes = weights.architecture();
    let extended = Arc::new(extended_graph(&drawn.points, &original, sizes.edge_knn).with_loops());
    let edges = edge_predictor(tape, &net.edge_predictor, &constant(&drawn.points), &extended, &original);
    let given: &[[u32; 3]] = if drawn.as_cloud { &[] } else { &drawn.spanned };
    let predicted = (&*extended, edges.adjacency.matrix().data());
    let (faces, neighbours) = choose_candidates(sizes, &drawn.points, predicted, given);
    let prior = prior(tape, &edges.adjacency, &faces);
    let net = &net.face_classifier;
    let points = constant(&drawn.points);
    let probabilities = face_classifier(tape, net, &points, &faces.triangles, &neighbours, &prior);
    (probabilities, Candidates { faces, extended, neighbours })
}
