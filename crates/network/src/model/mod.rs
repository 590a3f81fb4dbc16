//! The paper's network, one file per stage or layer.
//!
//! Each stage is a function over a [`Tape`](crate::autodiff::Tape). Functions over slices with gradients end in `_forward`
//! and `_backward`. Positions come from [`in_edge_lengths`]. Functions panic if shapes do not match or an index is out of
//! range.

mod affine;
mod architecture;
mod candidate_faces;
mod dev_conv;
mod edge_predictor;
mod extended_graph;
mod face_classifier;
mod in_edge_lengths;
mod inference;
mod network;
mod normalized;
mod point_sampler;
mod shipped;
#[cfg(feature = "paper")]
mod shipped_paper;
#[cfg(not(feature = "paper"))]
#[path = "no_shipped_paper.rs"]
mod shipped_paper;
mod sparse_attention;
mod tiles;
mod tri_conv;
mod weights;
#[cfg(feature = "weights")]
mod weights_file;

pub use crate::autodiff::WeightsError;
pub use affine::Affine;
pub use architecture::Architecture;
pub use candidate_faces::{CandidateFaces, barycenters, candidate_faces, prior};
pub use dev_conv::{DevConv, dev_conv};
pub use edge_predictor::{EdgePredictor, Edges, edge_predictor};
pub use extended_graph::extended_graph;
pub use face_classifier::{FaceClassifier, face_classifier, triangle_graph};
pub use in_edge_lengths::{EdgeFrame, in_edge_lengths};
#[doc(hidden)]
pub use inference::choose_candidates;
pub use inference::{PredictedEdges, PredictedFaces, predict_edges, predict_faces, surface_scores, vertex_scores};
pub use network::Network;
pub use normalized::normalize_points;
pub use point_sampler::{PointSampler, Vertices, inclusion_probabilities, point_sampler};
#[doc(hidden)]
pub use shipped_paper::paper_weights;
pub use sparse_attention::{SparseAttention, sparse_attention};
pub use tri_conv::{TriConv, tri_conv, triangle_positions};
pub use weights::Weights;
