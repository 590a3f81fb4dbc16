//! Terms of the training objective of Sec. 3.4, one file per term, each with its gradient.
//!
//! `docs/paper.md` explains the terms that replace printed ones. Functions panic if an index is out of range. Support code
//! for the main modules; see the front page of the crate.

mod chamfer;
mod closure;
mod collision;
mod conflicts;
mod coverage;
mod curvature;
mod edge_crossings;
mod expected_cost;
mod forward_distance;
mod inclusion;
mod overlap;
mod quotient_agreement;
mod reverse_distance;
mod smoothness;
mod surface_error;
#[cfg(test)]
mod test_gradients;
mod through_draw;
mod total;
mod triangles;

pub use chamfer::{coverage_of_samples, deviation_of_samples, probabilistic_chamfer};
pub use closure::closure;
pub use collision::collisions;
pub use conflicts::{conflicts_by_count, conflicts_by_pair};
pub use coverage::{NearTriangles, coverage, near_triangles};
pub use curvature::curvature_of_samples;
pub use edge_crossings::edge_crossings;
pub use forward_distance::{forward_distance, forward_distances};
pub use inclusion::{Inclusion, inclusion, inclusion_gradient};
pub use overlap::{OverlapSettings, overlaps};
pub use quotient_agreement::quotient_agreement;
pub use reverse_distance::{ReverseDistances, reverse_distance, reverse_distances};
pub use smoothness::smoothness;
pub use surface_error::{ErrorSums, PointErrors, error_shares, error_sums, log_errors, point_errors};
pub use through_draw::{DrawnFaces, gradient_through_draw};
pub use total::{Candidates, FaceGeometry, FaceObjective, NamedTerm, face_geometry, face_terms, total};

/// A loss and its gradient by probabilities or scores.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// Value of the loss.
    pub value: f64,
    /// Derivative by each probability or score.
    pub gradient: Vec<f32>,
}

impl Term {
    /// Returns a zero loss with a gradient of `n` zeros.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
    /// assert_eq!(neural_mesh::loss::Term::zero(2).gradient, [0.0, 0.0]);
    /// ```
    pub fn zero(n: usize) -> Self {
        Self { value: 0.0, gradient: vec![0.0; n] }
    }

    /// Returns a value and a gradient divided by `n`; zero if `n` is 0.
    ///
    /// ```
    /// # use neural_mesh_network as neural_mesh;
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

    /// Returns the mean of `p_i w_i`, a loss of the probabilities p.
    pub(crate) fn mean_product(weights: &[f64], probabilities: &[f32]) -> Self {
        let products = weights.iter().zip(probabilities).map(|(w, &p)| w * f64::from(p));
        Self::mean(products.sum(), weights, weights.len())
    }
}
