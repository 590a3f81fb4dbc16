//! The objective of Sec. 3.4, one file per term: its value and its gradient to the probabilities or scores it judges.
//!
//! Every loss is a function over plain slices, forward and backward side by side; none knows the network. The
//! printed terms stand beside the forms that train: `docs/paper.md` says where the print fails and why.
//!
//! Machinery: what the modules that users call stand on; see the front page of the crate.

mod chamfer;
mod closure;
mod collision;
mod coverage;
mod curvature;
mod edge_crossings;
mod first_kept;
mod forward_distance;
mod inclusion;
mod overlap;
mod pairs;
mod planes;
mod quotient_agreement;
mod reverse_distance;
mod smoothness;
mod surface_error;
#[cfg(test)]
mod test_gradients;
mod total;
mod triangles;

pub use chamfer::{coverage_of_samples, probabilistic_chamfer};
pub use closure::closure;
pub use collision::collisions;
pub use coverage::{NearTriangles, coverage, near_triangles};
pub use curvature::curvature_of_samples;
pub use edge_crossings::edge_crossings;
pub use forward_distance::{forward_distance, forward_distances};
pub use inclusion::{Inclusion, inclusion, inclusion_gradient};
pub use overlap::{OverlapSettings, overlaps};
pub use pairs::{conflicts_by_count, conflicts_by_pair};
pub use planes::bending_of_samples;
pub use quotient_agreement::quotient_agreement;
pub use reverse_distance::{ReverseDistances, reverse_distance, reverse_distances};
pub use smoothness::smoothness;
pub use surface_error::{ErrorSums, PointErrors, error_sums, log_errors, parts, point_errors};
pub use total::{Candidates, FaceGeometry, FaceObjective, NamedTerm, face_geometry, face_terms, total};

/// A loss and its gradient to the probabilities (or scores) it was given, one entry each.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// The loss.
    pub value: f64,
    /// Its derivative to each probability.
    pub gradient: Vec<f32>,
}

impl Term {
    /// Returns the loss of nothing: zero, with a gradient of `n` zeros.
    ///
    /// ```
    /// assert_eq!(neural_mesh::loss::Term::zero(2).gradient, [0.0, 0.0]);
    /// ```
    pub fn zero(n: usize) -> Self {
        Self { value: 0.0, gradient: vec![0.0; n] }
    }

    /// Returns a value and a gradient that were summed in double precision, both divided by `n`; zero where n is 0.
    ///
    /// ```
    /// let term = neural_mesh::loss::Term::mean(3.0, &[1.0, 4.0], 2);
    /// assert_eq!((term.value, &term.gradient[..]), (1.5, &[0.5, 2.0][..]));
    /// ```
    pub fn mean(sum: f64, gradient: &[f64], n: usize) -> Self {
        if n == 0 {
            return Self::zero(gradient.len());
        }
        let n = n as f64;
        Self { value: sum / n, gradient: gradient.iter().map(|&g| (g / n) as f32).collect() }
    }

    /// The mean of `p_i w_i`, linear in p.
    pub(crate) fn mean_product(weights: &[f64], probabilities: &[f32]) -> Self {
        let products = weights.iter().zip(probabilities).map(|(w, &p)| w * f64::from(p));
        Self::mean(products.sum(), weights, weights.len())
    }
}
