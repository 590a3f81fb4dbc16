//! Training of learned methods.

use neural_mesh::train::{OwnNetwork, StepFunction};

use super::dse::dse_step;
use super::pointtrinet::pointtrinet_step;
use super::potamias::potamias_step;
use super::{LearnedBaseline, LearnedWeights};

impl LearnedBaseline {
    /// Returns the training step of the method.
    pub fn step(self) -> Box<StepFunction<'static>> {
        match self {
            Self::Dse => Box::new(dse_step),
            Self::Potamias => Box::new(potamias_step),
            Self::PointTriNet => Box::new(pointtrinet_step),
        }
    }
}

impl LearnedWeights {
    /// Returns the network as the start of a training.
    pub fn network(&self) -> OwnNetwork {
        OwnNetwork { tensors: self.tensors().clone(), about: self.metadata() }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use neural_mesh::autodiff::Tensors;
    use neural_mesh::linalg::Matrix;
    use neural_mesh::mesh::shapes;
    use neural_mesh::train::{Moments, Settings, StepResult, TrainingItem, adam_step};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use rand_xoshiro::rand_core::SeedableRng;
    use std::sync::Arc;

    pub fn train_twelve_steps(baseline: LearnedBaseline, mut tensors: Tensors<Arc<Matrix>>) -> Vec<StepResult> {
        let settings = Settings::from_toml(&format!("objective = \"{}\"", baseline.name())).unwrap();
        let item = TrainingItem { name: "sphere".into(), mesh: shapes::wavy_sphere(4, 5.0), ratio: 0.1 };
        let mut moments = Moments::zero(&tensors.map(|_, matrix| matrix.shape()));
        let mut steps = Vec::new();
        for _ in 0..12 {
            let random = &mut Xoshiro256PlusPlus::seed_from_u64(0);
            let step = baseline.step()(&tensors, &item, &settings, random).unwrap();
            tensors = adam_step(&tensors, &step.gradients, &mut moments, &settings, 0.003);
            steps.push(step);
        }
        steps
    }
}
