//! Shapes of the tensors of both networks, each over a patch (PointNet, Qi et al. 2017).
//!
//! `classifier` gives each point the logit of being a neighbour, `map` its two map coordinates. Layers `pointwise` see
//! each point, `pooled` the patch's pooled features; the stages `coarse` and `fine` join both.

use crate::learned_baselines::scale_width;
use neural_mesh::autodiff::Tensors;

/// Candidates per point; 120 in the paper.
pub const CANDIDATES: usize = 60;
/// Points of a patch besides its own; 30 in the paper.
pub const KEPT: usize = 24;

// Smallest width before the pooling, where layers cost little.
const LEAST_BEFORE_POOLING: usize = 32;

// Layer widths of one network: before the pooling, of the pooled features, and of both stages after the pooling.
struct Widths {
    pointwise: [usize; 5],
    pooled: [usize; 2],
    joined: [usize; 2],
}

impl Widths {
    /// Scales the widths of the paper's program by a factor in (0, 1].
    fn from_share(share: f64) -> Self {
        let at_least = |full: usize| scale_width(full, share).max(LEAST_BEFORE_POOLING);
        let [a, b, c, d] = [64, 64, 128, 256].map(at_least);
        Self {
            pointwise: [a, b, c, d, scale_width(1024, share)],
            pooled: [1024, 1024].map(|full| scale_width(full, share)),
            joined: [1024, 528].map(|full| scale_width(full, share)),
        }
    }
}

/// Returns the shapes of all tensors.
pub fn shapes(width_share: f64) -> Tensors<[usize; 2]> {
    let widths = Widths::from_share(width_share);
    let mut shapes = Tensors::default();
    push_network(&mut shapes, "classifier", &widths, 1);
    push_network(&mut shapes, "map", &widths, 2);
    shapes
}

fn push_network(shapes: &mut Tensors<[usize; 2]>, network: &str, widths: &Widths, n_out: usize) {
    let mut layer = |name: &str, n_in: usize, n_out: usize| {
        shapes.push(format!("{network}.{name}.weights"), [n_in, n_out]);
        shapes.push(format!("{network}.{name}.bias"), [1, n_out]);
    };
    let mut width = 4;
    for (i, next) in widths.pointwise.into_iter().enumerate() {
        layer(&format!("pointwise_{i}"), width, next);
        width = next;
    }
    for (i, next) in widths.pooled.into_iter().enumerate() {
        layer(&format!("pooled_{i}"), width, next);
        width = next;
    }
    let [first, second] = widths.joined;
    for (stage, n_out) in [("coarse", 3), ("fine", n_out)] {
        layer(&format!("{stage}.of_patch"), width, first);
        layer(&format!("{stage}.hidden"), first, second);
        layer(&format!("{stage}.out"), second, n_out);
    }
    for stage in ["coarse", "fine"] {
        shapes.push(format!("{network}.{stage}.of_point"), [4, first]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_widths_are_those_of_the_papers_program() {
        let [full, eighth] = [1.0, 0.125].map(|share| Widths::from_share(share).pointwise);
        assert_eq!((full, eighth), ([64, 64, 128, 256, 1024], [32, 32, 32, 32, 128]));
        let shapes = shapes(1.0);
        assert_eq!(
            ["weights", "bias"].map(|of| shapes.get(&format!("map.fine.out.{of}"))),
            [Some(&[528, 2]), Some(&[1, 2])]
        );
    }
}
