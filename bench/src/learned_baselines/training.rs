//! How the networks of methods that learn are trained: by the library's loop, with a step for each method.

use neural_mesh::train::{OwnNetwork, StepFunction};

use super::dse::dse_step;
use super::pointtrinet::pointtrinet_step;
use super::potamias::potamias_step;
use super::{LearnedBaseline, LearnedWeights};

impl LearnedBaseline {
    /// Returns the step of its training.
    pub fn step(self) -> Box<StepFunction<'static>> {
        match self {
            Self::Dse => Box::new(dse_step),
            Self::Potamias => Box::new(potamias_step),
            Self::PointTriNet => Box::new(pointtrinet_step),
        }
    }
}

impl LearnedWeights {
    /// Returns the network as a training takes it, which begins with these weights.
    pub fn network(&self) -> OwnNetwork {
        OwnNetwork { tensors: self.tensors().clone(), about: self.about() }
    }
}
