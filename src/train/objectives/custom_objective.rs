//! Objectives from any function of a mesh and its result.

use super::{ErrorShares, JudgedErrors, Objective};
use crate::mesh::TriMesh;
use crate::simplify::WeightedResult;

/// Errors of a result from a custom function: at least 0, smaller is better.
#[derive(Clone, Debug, PartialEq)]
pub enum Errors {
    /// Errors at each vertex of the original, n_vertices.
    Vertices(Vec<f64>),
    /// Errors at each face of the original, n_faces.
    Faces(Vec<f64>),
    /// A single error of the whole result; its gradient needs more probes.
    Whole(f64),
}

/// An objective that minimises the logarithm of a function's errors.
///
/// ```
/// use neural_mesh::mesh::{TriMesh, shapes};
/// use neural_mesh::simplify::{WeightedResult, simplify_with_importance, vertex_areas};
/// use neural_mesh::train::{Errors, CustomObjective, Objective};
/// let sphere = shapes::icosphere(4);
/// let even = vec![1.0; sphere.positions().len()];
/// let simplify_to = |n| simplify_with_importance(&sphere, n, &even).unwrap();
/// let area = |mesh: &TriMesh| vertex_areas(mesh).iter().sum::<f64>();
/// let lost = CustomObjective(|original: &TriMesh, result: &WeightedResult| Ok(Errors::Whole((area(original) - area(&result.mesh)).abs())));
/// let verdict = lost.judge(&sphere, [&simplify_to(100), &simplify_to(90)]).unwrap();
/// assert!(verdict.terms[0].0 == "objective" && verdict.terms[0].1.is_finite());
/// ```
pub struct CustomObjective<F>(pub F);

impl<F: Fn(&TriMesh, &WeightedResult) -> Result<Errors, String> + Sync> Objective for CustomObjective<F> {
    fn judge(&self, original: &TriMesh, results: [&WeightedResult; 2]) -> Result<JudgedErrors, String> {
        let [first, second] = results.map(|result| (self.0)(original, result));
        let [first, second] = [first?, second?];
        let [a, b] = [check_errors(&first, original)?, check_errors(&second, original)?];
        // A zero error is replaced by a tiny one, so that logarithms stay finite.
        let mean = (0.5 * (a + b)).max(f64::MIN_POSITIVE);
        let shares = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) / mean).collect();
        let error_shares = match (&first, &second) {
            (Errors::Vertices(a), Errors::Vertices(b)) => ErrorShares::Vertices(shares(a, b)),
            (Errors::Faces(a), Errors::Faces(b)) => ErrorShares::Faces(shares(a, b)),
            _ => ErrorShares::Everywhere((a - b) / mean),
        };
        Ok(JudgedErrors { terms: vec![("objective", mean.ln())], error_shares })
    }
}

fn check_errors(errors: &Errors, original: &TriMesh) -> Result<f64, String> {
    let (values, expected): (&[f64], _) = match errors {
        Errors::Vertices(values) => (values, original.positions().len()),
        Errors::Faces(values) => (values, original.faces().len()),
        Errors::Whole(value) => (std::slice::from_ref(value), 1),
    };
    if values.len() != expected {
        return Err(format!("the objective returned {} errors instead of {expected}", values.len()));
    }
    match values.iter().find(|value| !value.is_finite() || **value < 0.0) {
        Some(value) => Err(format!("the objective returned the error {value}: give numbers of at least 0")),
        None => Ok(values.iter().sum()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn judge_errors(first: Errors, second: Errors) -> Result<JudgedErrors, String> {
        let original = shapes::tetrahedron();
        let result = |n: u32| WeightedResult { mesh: original.clone(), vertex_of: vec![n; 4] };
        let given = CustomObjective(|_: &TriMesh, result: &WeightedResult| {
            Ok(if result.vertex_of[0] == 0 { first.clone() } else { second.clone() })
        });
        given.judge(&original, [&result(0), &result(1)])
    }

    #[test]
    fn errors_have_their_golden_shares() {
        let vertices =
            judge_errors(Errors::Vertices(vec![3.0, 1.0, 0.0, 1.0]), Errors::Vertices(vec![1.0, 1.0, 1.0, 0.0]));
        // The errors of the two results sum to 5 and 3, with mean 4.
        let error_shares = ErrorShares::Vertices(vec![0.5, 0.0, -0.25, 0.25]);
        assert_eq!(vertices.unwrap(), JudgedErrors { terms: vec![("objective", 4.0f64.ln())], error_shares });
        let whole = judge_errors(Errors::Whole(5.0), Errors::Whole(3.0)).unwrap();
        assert_eq!(whole.error_shares, ErrorShares::Everywhere(0.5));
        assert!(judge_errors(Errors::Whole(0.0), Errors::Whole(0.0)).unwrap().terms[0].1.is_finite());
    }

    #[test]
    fn what_is_no_error_is_refused() {
        for bad in [Errors::Whole(f64::NAN), Errors::Whole(-1.0), Errors::Vertices(vec![1.0; 3]), Errors::Faces(vec![])]
        {
            assert!(judge_errors(bad, Errors::Whole(1.0)).unwrap_err().starts_with("the objective returned"));
        }
    }
}
