//! The projection into the latent space.

use super::{Cloud, Potamias};
use neural_mesh::autodiff::{Tape, Value};
use neural_mesh::linalg::Matrix;

/// Projects each point to its latent row.
///
/// # Shapes
/// - returns n x n_latent
///
/// ```
/// use neural_mesh::autodiff::Tape;
/// use neural_mesh_bench::learned_baselines::potamias::{Cloud, Potamias, initial_tensors, projection};
/// let cloud = Cloud::new(neural_mesh::mesh::shapes::icosphere(2).positions()).unwrap();
/// let net = Potamias::from_tensors(&initial_tensors(1.0, 1).constants()).unwrap();
/// assert_eq!(projection(&mut Tape::default(), &net, &cloud).matrix().shape(), [162, 16]);
/// ```
pub fn projection(tape: &mut Tape, net: &Potamias<Value>, cloud: &Cloud) -> Value {
    // The first layer sees positions, as DevConv: `f_i = ReLU(W_phi max_j W_theta (x_i - x_j))`. The others see
    // features: `f_i' = ReLU(W [f_i | ReLU(W_phi max_j W_theta (f_i - f_j))] + b)`. The last map is linear.
    let mut features = Value::constant(Matrix::from_points(&cloud.points));
    for layer in &net.layers {
        let mapped = tape.product(&features, &layer.theta);
        let seen = tape.neighbour_max_product_relu(&mapped, &cloud.graph, &layer.phi);
        features = match (&layer.mixed, &layer.bias) {
            (Some(mixed), Some(bias)) => {
                let both = tape.concat_product(&features, &seen, mixed);
                let both = tape.plus_row(&both, bias);
                tape.relu(&both)
            }
            _ => seen,
        };
    }
    tape.product(&features, &net.latent)
}
