//! The projection into the latent space.

use super::Cloud;
use super::network::LAYERS;
use crate::learned_baselines::tensor;
use neural_mesh::autodiff::{Tape, Tensors, Value};
use neural_mesh::linalg::Matrix;

/// Projects each point to its latent row.
///
/// # Shapes
/// - returns n x n_latent
pub fn projection(tape: &mut Tape, tensors: &Tensors<Value>, cloud: &Cloud) -> Value {
    // The first layer sees positions, as DevConv: `f_i = ReLU(W_phi max_j W_theta (x_i - x_j))`. The others see
    // features: `f_i' = ReLU(W [f_i | ReLU(W_phi max_j W_theta (f_i - f_j))] + b)`. The last map is linear.
    let mut features = Value::constant(Matrix::from_points(&cloud.points));
    for i in 0..LAYERS {
        let weights = |name: &str| tensor(tensors, &format!("projection_{i}.{name}"));
        let mapped = tape.product(&features, weights("theta"));
        let seen = tape.neighbour_max_product_relu(&mapped, &cloud.graph, weights("phi"));
        features = if i == 0 {
            seen
        } else {
            let both = tape.concat_product(&features, &seen, weights("mixed"));
            let both = tape.plus_row(&both, weights("mixed.bias"));
            tape.relu(&both)
        };
    }
    tape.product(&features, tensor(tensors, "latent"))
}
