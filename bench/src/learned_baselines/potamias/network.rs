//! Tensors of the network by name.

use crate::learned_baselines::scale_width;
use neural_mesh::autodiff::{Tensors, WeightsError};
use neural_mesh::linalg::Matrix;
use std::sync::Arc;

const WIDTH: usize = 64;
const LAYERS: usize = 3;
// Full latent width besides the position; small, so that farthest points are cheap.
const LATENT: usize = 16;

/// The network; `T` is a shape, a matrix or a value on a tape.
#[derive(Clone, Debug, PartialEq)]
pub struct Potamias<T> {
    /// Layers of the projection.
    pub layers: Vec<ProjectionLayer<T>>,
    /// Last linear map of the projection, width x n_latent.
    pub latent: T,
    /// Weights of the refinement.
    pub refinement: RefinementWeights<T>,
}

/// A projection layer over a point's neighbourhood.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectionLayer<T> {
    /// Weights of differences, n_in x width.
    pub theta: T,
    /// Weights of their maximum, width x width.
    pub phi: T,
    /// Weights of the layer's input and of the maximum mapped by `phi`, (n_in + width) x width; none in the first
    /// layer.
    pub mixed: Option<T>,
    /// Bias, 1 x width.
    pub bias: Option<T>,
}

/// Attention of a sample over its neighbours.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinementWeights<T> {
    /// Weights of the sample, n_latent x width.
    pub own: T,
    /// Weights of a neighbour, n_latent x width.
    pub near: T,
    /// Weights of offset and density, 4 x width.
    pub offset: T,
    /// Bias, 1 x width.
    pub bias: T,
    /// Attention logits, width x 1.
    pub attention: T,
    /// Displacements, width x 3.
    pub moved: T,
}

impl<T: Clone> Potamias<T> {
    /// Makes the network of named tensors.
    ///
    /// # Errors
    /// [`WeightsError::Missing`] names the first missing tensor.
    ///
    /// ```
    /// use neural_mesh_bench::learned_baselines::potamias::{Potamias, shapes};
    /// assert_eq!(Potamias::from_tensors(&shapes(1.0)).unwrap().layers.len(), 3);
    /// ```
    pub fn from_tensors(tensors: &Tensors<T>) -> Result<Self, WeightsError> {
        let named = |name: &str| tensors.find_tensor(name).cloned();
        let layer = |i: usize| {
            let of_layer = |name: &str| named(&format!("projection_{i}.{name}"));
            let mixes = i > 0;
            Ok(ProjectionLayer {
                theta: of_layer("theta")?,
                phi: of_layer("phi")?,
                mixed: mixes.then(|| of_layer("mixed")).transpose()?,
                bias: mixes.then(|| of_layer("mixed.bias")).transpose()?,
            })
        };
        Ok(Self {
            layers: (0..LAYERS).map(layer).collect::<Result<_, WeightsError>>()?,
            latent: named("latent")?,
            refinement: RefinementWeights {
                own: named("refinement.own")?,
                near: named("refinement.near")?,
                offset: named("refinement.offset")?,
                bias: named("refinement.bias")?,
                attention: named("refinement.attention")?,
                moved: named("refinement.moved")?,
            },
        })
    }
}

/// Returns the shapes of all tensors.
pub fn shapes(width_share: f64) -> Tensors<[usize; 2]> {
    let [width, latent] = [WIDTH, LATENT].map(|full| scale_width(full, width_share));
    let mut shapes = Tensors::default();
    for i in 0..LAYERS {
        shapes.push(format!("projection_{i}.theta"), [if i == 0 { 3 } else { width }, width]);
        shapes.push(format!("projection_{i}.phi"), [width, width]);
        if i > 0 {
            shapes.push(format!("projection_{i}.mixed"), [2 * width, width]);
            shapes.push(format!("projection_{i}.mixed.bias"), [1, width]);
        }
    }
    shapes.push("latent", [width, latent]);
    shapes.push("refinement.own", [latent, width]);
    shapes.push("refinement.near", [latent, width]);
    shapes.push("refinement.offset", [4, width]);
    shapes.push("refinement.bias", [1, width]);
    shapes.push("refinement.attention", [width, 1]);
    shapes.push("refinement.moved", [width, 3]);
    shapes
}

/// Returns random initial tensors.
pub fn initial_tensors(width_share: f64, seed: u64) -> Tensors<Arc<Matrix>> {
    // Small initial weights of the displacements, so that samples move little at first.
    shapes(width_share).draw_scaled(seed, |name| if name == "refinement.moved" { 0.1 } else { 1.0 })
}
