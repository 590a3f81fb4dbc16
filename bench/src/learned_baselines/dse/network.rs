//! Tensors of both networks by name.

use super::Widths;
use neural_mesh::autodiff::{Tensors, WeightsError};
use neural_mesh::linalg::Matrix;
use std::sync::Arc;

/// Both networks; `T` is a shape, a matrix or a value on a tape.
#[derive(Clone, Debug, PartialEq)]
pub struct Dse<T> {
    /// Network that gives each point the logit of being a neighbour.
    pub classifier: PointNetwork<T>,
    /// Network that gives each point its two map coordinates.
    pub map: PointNetwork<T>,
}

/// A network over a patch (PointNet, Qi et al. 2017).
#[derive(Clone, Debug, PartialEq)]
pub struct PointNetwork<T> {
    /// Layers applied to each point, as `[weights, bias]`.
    pub pointwise: Vec<[T; 2]>,
    /// Layers applied to the patch's pooled features.
    pub pooled: Vec<[T; 2]>,
    /// First stage after the pooling, with three outputs per point.
    pub coarse: JoinedLayers<T>,
    /// Second stage, with the network's outputs.
    pub fine: JoinedLayers<T>,
}

/// Layers that join each point with the patch's pooled features.
#[derive(Clone, Debug, PartialEq)]
pub struct JoinedLayers<T> {
    /// Weights of a position and its distance from the patch's first point, 4 x width.
    pub of_point: T,
    /// Weights and bias of pooled features, n_pooled x width and 1 x width.
    pub of_patch: [T; 2],
    /// Hidden layer, width x width.
    pub hidden: [T; 2],
    /// Output layer, width x n_out.
    pub out: [T; 2],
}

impl<T: Clone> Dse<T> {
    /// Makes the networks of named tensors.
    ///
    /// # Errors
    /// [`WeightsError::Missing`] names the first missing tensor.
    ///
    /// ```
    /// use neural_mesh_bench::learned_baselines::dse::{Dse, shapes};
    /// assert_eq!(Dse::from_tensors(&shapes(1.0)).unwrap().map.fine.out, [[528, 2], [1, 2]]);
    /// ```
    pub fn from_tensors(tensors: &Tensors<T>) -> Result<Self, WeightsError> {
        Ok(Self { classifier: point_network(tensors, "classifier")?, map: point_network(tensors, "map")? })
    }
}

fn point_network<T: Clone>(tensors: &Tensors<T>, network: &str) -> Result<PointNetwork<T>, WeightsError> {
    let named = |name: &str| tensors.find_tensor(&format!("{network}.{name}")).cloned();
    let layer = |name: &str| Ok([named(&format!("{name}.weights"))?, named(&format!("{name}.bias"))?]);
    let layers =
        |name: &str, n: usize| (0..n).map(|i| layer(&format!("{name}_{i}"))).collect::<Result<_, WeightsError>>();
    let joined = |name: &str| {
        Ok(JoinedLayers {
            of_point: named(&format!("{name}.of_point"))?,
            of_patch: layer(&format!("{name}.of_patch"))?,
            hidden: layer(&format!("{name}.hidden"))?,
            out: layer(&format!("{name}.out"))?,
        })
    };
    Ok(PointNetwork {
        pointwise: layers("pointwise", 5)?,
        pooled: layers("pooled", 2)?,
        coarse: joined("coarse")?,
        fine: joined("fine")?,
    })
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

/// Returns random initial tensors.
pub fn initial_tensors(width_share: f64, seed: u64) -> Tensors<Arc<Matrix>> {
    shapes(width_share).draw(seed)
}
