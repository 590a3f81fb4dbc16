//! The tensors of the network, by name.

use crate::learned_baselines::share_of;
use neural_mesh::autodiff::{Tensors, WeightsError};
use neural_mesh::linalg::Matrix;
use std::sync::Arc;

/// Width of the layers.
const WIDTH: usize = 64;
/// Layers of the projection.
const LAYERS: usize = 3;
/// Numbers of the latent space beside the position. Few, so that farthest points in it cost little.
const LATENT: usize = 16;

/// The network: `T` is a shape, a stored matrix, or a value on a tape.
#[derive(Clone, Debug, PartialEq)]
pub struct Potamias<T> {
    /// The projection's layers.
    pub layers: Vec<ProjectionLayer<T>>,
    /// width x n_latent: the projection's last map.
    pub latent: T,
    /// The refinement.
    pub refinement: RefinementWeights<T>,
}

/// How a layer sees the neighbourhood of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct ProjectionLayer<T> {
    /// n_in x width, over differences.
    pub theta: T,
    /// width x width, over the largest of them.
    pub phi: T,
    /// (n_in + width) x width, over what was there and what this layer sees; none in the first, which knows no place.
    pub mixed: Option<T>,
    /// 1 x width.
    pub bias: Option<T>,
}

/// How a sample looks at its neighbours, and moves.
#[derive(Clone, Debug, PartialEq)]
pub struct RefinementWeights<T> {
    /// n_latent x width, over the sample.
    pub own: T,
    /// n_latent x width, over a neighbour.
    pub near: T,
    /// 4 x width, over where the neighbour lies and how many points stay.
    pub offset: T,
    /// 1 x width.
    pub bias: T,
    /// width x 1: how much the neighbour counts.
    pub attention: T,
    /// width x 3: where it moves the sample.
    pub moved: T,
}

impl<T: Clone> Potamias<T> {
    /// The network of these tensors.
    ///
    /// # Errors
    /// [`WeightsError::Missing`] names the first that is not there.
    ///
    /// ```
    /// use neural_mesh_bench::learned_baselines::potamias::{Potamias, shapes};
    /// assert_eq!(Potamias::of(&shapes(1.0)).unwrap().layers.len(), 3);
    /// ```
    pub fn of(tensors: &Tensors<T>) -> Result<Self, WeightsError> {
        let named = |name: &str| tensors.named(name).cloned();
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

/// The shapes of all tensors, for a share of the widths.
pub fn shapes(width_share: f64) -> Tensors<[usize; 2]> {
    let [width, latent] = [WIDTH, LATENT].map(|full| share_of(full, width_share));
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

/// The tensors that a training begins with. Samples hardly move then: a tenth of what other layers begin with.
pub fn drawn(width_share: f64, seed: u64) -> Tensors<Arc<Matrix>> {
    shapes(width_share).drawn_by(seed, |name| if name == "refinement.moved" { 0.1 } else { 1.0 })
}
