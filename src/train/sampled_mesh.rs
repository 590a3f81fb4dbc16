//! Samples drawn from a mesh, and their candidate faces (Secs. 3.2, 3.3).

use super::scored_mesh::constant;
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

pub(super) struct SampledMesh {
    /// Frame of the network's coordinates.
    pub frame: EdgeFrame,
    /// The samples in that frame, n_samples x 3.
    pub points: Vec<[f32; 3]>,
    /// Graph A of Eq. (3), which joins samples whose regions touch.
    pub edges: Csr,
    /// Triples of samples whose regions meet in a face of the mesh.
    pub quotient_triangles: Vec<[u32; 3]>,
    /// True for a point cloud, whose candidates come from A_s alone.
    as_cloud: bool,
}

/// Connects the sampled vertices of a mesh; with `as_cloud`, regions touch where `rings` joins them.
pub(super) fn connect_samples(
    mesh: &TriMesh,
    points: &[[f32; 3]],
    rings: &Csr,
    samples: &[u32],
    as_cloud: bool,
) -> SampledMesh {
    let assignment = assign_to_samples(points, rings, samples);
    let Quotient { edges, triangles: quotient_triangles, .. } =
        quotient(mesh.positions(), mesh.faces(), &assignment, samples.len());
    let edges = if as_cloud { region_graph(rings, &assignment, samples.len()) } else { edges };
    let sampled: Vec<[f32; 3]> = samples.iter().map(|&v| mesh.positions()[v as usize]).collect();
    let frame = EdgeFrame::new(&sampled, &edges);
    SampledMesh { points: frame.apply(&sampled), frame, edges, quotient_triangles, as_cloud }
}

pub(super) struct CandidateGraph {
    pub faces: CandidateFaces,
    /// G_ext, to whose entries the candidates' edges refer.
    pub extended: Arc<Csr>,
}

pub(super) fn classify_faces(
    tape: &mut Tape,
    net: &Network<Value>,
    drawn: &SampledMesh,
    weights: &Weights,
) -> (Value, CandidateGraph) {
    let original = Arc::new(drawn.edges.clone());
    let sizes = weights.architecture();
    let extended = Arc::new(extended_graph(&drawn.points, &original, sizes.edge_knn).with_loops());
    let edges = edge_predictor(tape, &net.edge_predictor, &constant(&drawn.points), &extended, &original);
    let given: &[[u32; 3]] = if drawn.as_cloud { &[] } else { &drawn.quotient_triangles };
    let predicted = (&*extended, edges.adjacency.matrix().data());
    let (faces, neighbours) = choose_candidates(sizes, &drawn.points, predicted, given);
    let prior = prior(tape, &edges.adjacency, &faces);
    let net = &net.face_classifier;
    let points = constant(&drawn.points);
    let probabilities = face_classifier(tape, net, &points, &faces.triangles, &neighbours, &prior);
    (probabilities, CandidateGraph { faces, extended })
}
