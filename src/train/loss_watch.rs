//! Detection of losses that are not finite or explode.

use super::StepResult;
use serde::{Deserialize, Serialize};

/// Number of first steps in which no loss counts as an explosion.
const PATIENCE: u64 = 20;
/// Smallest weight of the newest loss in the running mean.
const FORGETTING: f64 = 0.02;

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct LossWatch {
    mean: f64,
    n: u64,
}

impl LossWatch {
    /// Returns the fault of a step, naming term or tensor; without one, updates the mean.
    pub fn find_trouble(&mut self, step: &StepResult, explosion: f64) -> Option<String> {
        find_non_finite(step).or_else(|| self.check_explosion(step, explosion))
    }

    fn check_explosion(&mut self, step: &StepResult, explosion: f64) -> Option<String> {
        let total = step.total();
        if explosion > 0.0 && self.n >= PATIENCE && self.mean > 0.0 && total > explosion * self.mean {
            let (name, value) = step.terms.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
            let factor = total / self.mean;
            return Some(format!(
                "the loss rose to {factor:.1} times its running mean, with {value} as the largest term, `{name}`"
            ));
        }
        self.n += 1;
        self.mean += (total - self.mean) * FORGETTING.max(1.0 / self.n as f64);
        None
    }
}

fn find_non_finite(step: &StepResult) -> Option<String> {
    if let Some((name, value)) = step.terms.iter().find(|(_, value)| !value.is_finite()) {
        return Some(format!("the term `{name}` is {value}"));
    }
    let checked = step.gradients.try_map(|name, matrix| {
        if matrix.data().iter().all(|x| x.is_finite()) { Ok(()) } else { Err(name.to_string()) }
    });
    checked.err().map(|name| format!("the gradient of `{name}` has an entry that is not finite"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::autodiff::Tensors;
    use crate::linalg::Matrix;

    fn step(total: f64) -> StepResult {
        let gradients: Tensors<Matrix> =
            ["a.weights", "a.bias"].map(|name| (name, Matrix::zeros(1, 1))).into_iter().collect();
        StepResult { terms: vec![("small", 0.1 * total), ("large", 0.9 * total)], gradients }
    }

    #[test]
    fn what_is_not_finite_is_named() {
        let mut watch = LossWatch::default();
        let bad = StepResult { terms: vec![("fine", 1.0), ("bad", f64::NAN)], ..step(1.0) };
        assert!(watch.find_trouble(&bad, 0.0).unwrap().contains("`bad` is NaN"));
        let mut bad = step(1.0);
        *bad.gradients.get_mut("a.bias").unwrap() = Matrix::new(1, 1, vec![f32::INFINITY]);
        assert!(watch.find_trouble(&bad, 0.0).unwrap().contains("`a.bias`"));
    }

    #[test]
    fn an_explosion_is_seen_after_some_patience() {
        let mut watch = LossWatch::default();
        assert_eq!(watch.find_trouble(&step(500.0), 10.0), None);
        for _ in 0..200 {
            assert_eq!(watch.find_trouble(&step(1.0), 10.0), None);
        }
        let mut careless = watch.clone();
        assert_eq!(careless.find_trouble(&step(1e6), 0.0), None);
        assert!(watch.find_trouble(&step(1e6), 10.0).unwrap().contains("`large`"));
    }
}
