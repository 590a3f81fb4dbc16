//! Agreement of probabilities with the triangles that the mesh spans between sample regions, an addition to the paper.

use super::Term;

/// Lower limit of the logarithm's argument, which also limits its slope.
const LEAST: f64 = 1e-4;

/// Computes the weighted cross-entropy of probabilities and labels, in nats.
///
/// Minus the sum of `w log p` over true and `w log (1 - p)` over false labels; the weights sum to 1. `balance` 0 weighs
/// candidates equally, 1 gives one half to each class.
///
/// # Shapes
/// - `labels`: true if the mesh spans the candidate between three regions
///
/// ```
/// # use neural_mesh_network as neural_mesh;
/// use neural_mesh::loss::quotient_agreement;
/// let term = quotient_agreement(&[true, false], 0.0, &[0.5, 0.5]);
/// assert!((term.value - 2f64.ln()).abs() < 1e-12);
/// assert_eq!(term.gradient, [-1.0, 1.0]);
/// ```
pub fn quotient_agreement(labels: &[bool], balance: f64, probabilities: &[f32]) -> Term {
    let n_true = labels.iter().filter(|&&label| label).count();
    let counts = [labels.len() - n_true, n_true];
    let n_classes = counts.iter().filter(|&&n| n > 0).count() as f64;
    let weights = counts.map(|n| (1.0 - balance) / labels.len() as f64 + balance / (n_classes * n as f64));
    let mut sum = 0.0;
    let slope = |(&label, &p): (&bool, &f32)| {
        let right = if label { f64::from(p) } else { 1.0 - f64::from(p) }.max(LEAST);
        let weight = weights[usize::from(label)];
        sum -= weight * right.ln();
        (if label { -weight / right } else { weight / right }) as f32
    };
    let gradient = labels.iter().zip(probabilities).map(slope).collect();
    Term { value: sum, gradient }
}

#[cfg(test)]
mod tests {
    use super::super::test_gradients::{assert_gradient, uniform};
    use super::*;

    #[test]
    fn agrees_with_differences() {
        let labels = [true, false, false, true, false];
        let p: Vec<f32> = uniform(5, 1).iter().map(|p| 0.1 + 0.8 * p).collect();
        for balance in [0.0, 0.3, 1.0] {
            assert_gradient(&p, 1e-3, |p| quotient_agreement(&labels, balance, p));
        }
    }

    #[test]
    fn balance_gives_the_few_as_much_weight_as_the_many() {
        let mut labels = [false; 10];
        labels[3] = true;
        let gradient = quotient_agreement(&labels, 1.0, &[0.5; 10]).gradient;
        assert!((gradient[3] + 1.0).abs() < 1e-6 && (gradient[0] - 1.0 / 9.0).abs() < 1e-6);
        let sure = labels.map(|label| if label { 1.0 } else { 0.0 });
        assert_eq!(quotient_agreement(&labels, 1.0, &sure).value, 0.0);
    }

    #[test]
    fn certain_mistakes_cost_a_lot_and_not_everything_and_one_class_is_enough() {
        let wrong = quotient_agreement(&[true], 0.5, &[0.0]);
        assert!((wrong.value + LEAST.ln()).abs() < 1e-9);
        assert_eq!(wrong.gradient, [-1e4]);
        assert_eq!(quotient_agreement(&[], 1.0, &[]), Term::zero(0));
    }
}
