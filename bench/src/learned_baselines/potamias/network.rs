//! Shapes of the network's tensors.
//!
//! A layer `projection_i` has weights `theta` of differences, `phi` of their maximum, and, except the first, `mixed`
//! of its input and the maximum mapped by `phi`. The refinement has weights of the sample (`own`), of a neighbour
//! (`near`), of offset and density (`offset`), and those of attention and displacement.

use crate::learned_baselines::scale_width;
use neural_mesh::autodiff::Tensors;

const WIDTH: usize = 64;
/// Layers of the projection.
pub const LAYERS: usize = 3;
// Full latent width besides the position; small, so that farthest points are cheap.
const LATENT: usize = 16;

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
