//! The attention-based refinement of samples (AttRef).

use super::Cloud;
use crate::learned_baselines::tensor;
use neural_mesh::autodiff::{Tape, Tensors, Value};
use neural_mesh::linalg::{Csr, Matrix};
use std::sync::Arc;

/// Samples and their displacements.
#[derive(Clone, Debug)]
pub struct Refinement {
    /// Normalised samples before the move, n x 3.
    pub from: Vec<[f32; 3]>,
    /// Units of the displacements, n: mean distances to the neighbours.
    pub radii: Vec<f32>,
    /// Displacements in these units, n x 3.
    pub displacement: Value,
}

/// Moves each sample by attention over its 15 nearest points.
///
/// # Shapes
/// - `latent`: n_points x n_latent; `samples`: indices of points
///
/// # Panics
/// If a sample does not exist.
pub fn refinement(
    tape: &mut Tape,
    tensors: &Tensors<Value>,
    cloud: &Cloud,
    latent: &Value,
    samples: &[u32],
) -> Refinement {
    let weights = |name: &str| tensor(tensors, &format!("refinement.{name}"));
    let graph = neighbourhoods(&cloud.graph, samples);
    let [rows, columns]: [Vec<u32>; 2] = [0, 1].map(|side| graph.entries().map(|entry| entry[side]).collect());
    let radii: Vec<f32> = samples.iter().map(|&s| cloud.radii[s as usize]).collect();
    // Hidden rows are `h_ij = ReLU(W_o z_i + W_n z_j + W_r [(x_j - x_i) / r_i | c] + b)`.
    let of_samples = tape.gather(latent, samples);
    let own = tape.product(&of_samples, weights("own"));
    let own = tape.gather(&own, &rows);
    let near = tape.product(latent, weights("near"));
    let near = tape.gather(&near, &columns);
    let offsets = Value::constant(offsets(cloud, samples, &graph));
    let place = tape.affine(&offsets, weights("offset"), weights("bias"));
    let both = tape.plus(&own, &near);
    let hidden = tape.plus(&both, &place);
    let hidden = tape.relu(&hidden);
    // Displacements are `d_i = r_i sum_j softmax_j(w_a . h_ij) W_m h_ij`.
    let logits = tape.product(&hidden, weights("attention"));
    let attention = tape.neighbour_softmax(&logits, &graph);
    let moves = tape.product(&hidden, weights("moved"));
    let displacement = tape.entry_sums(&attention, &moves, &graph);
    Refinement { from: samples.iter().map(|&s| cloud.points[s as usize]).collect(), radii, displacement }
}

fn neighbourhoods(graph: &Csr, samples: &[u32]) -> Arc<Csr> {
    let entries =
        samples.iter().enumerate().flat_map(|(row, &s)| graph.row(s as usize).iter().map(move |&j| [row as u32, j]));
    Csr::from_entries(samples.len(), graph.n_cols(), entries).into()
}

fn offsets(cloud: &Cloud, samples: &[u32], graph: &Csr) -> Matrix {
    // The root c of the sampled fraction is ours: one network serves all ratios.
    let closeness = (samples.len() as f32 / cloud.points.len() as f32).sqrt();
    let offset = |[row, j]: [u32; 2]| {
        let s = samples[row as usize] as usize;
        let ([from, to], radius) = ([cloud.points[s], cloud.points[j as usize]], cloud.radii[s].max(f32::MIN_POSITIVE));
        let [x, y, z] = std::array::from_fn(|axis| (to[axis] - from[axis]) / radius);
        [x, y, z, closeness]
    };
    Matrix::new(graph.n_entries(), 4, graph.entries().flat_map(offset).collect())
}

impl Refinement {
    /// Returns the moved samples, normalised, n x 3.
    pub fn points(&self) -> Vec<[f32; 3]> {
        let moves = self.displacement.matrix();
        let moved =
            |(i, from): (usize, &[f32; 3])| std::array::from_fn(|axis| from[axis] + self.radii[i] * moves.row(i)[axis]);
        self.from.iter().enumerate().map(moved).collect()
    }

    /// Converts a gradient by points to one by displacements.
    pub fn backward(&self, gradient: &[[f64; 3]]) -> Matrix {
        let of_row = |(g, &radius): (&[f64; 3], &f32)| g.map(|g| (g * f64::from(radius)) as f32);
        Matrix::from_owned_points(gradient.iter().zip(&self.radii).map(of_row).collect())
    }
}
