//! The three stages together, and the one walk over all their tensors.

use super::{EdgePredictor, FaceClassifier, PointSampler};
use std::convert::Infallible;

/// The network: `T` is a shape, a stored matrix, or a value on a tape.
#[derive(Clone, Debug, PartialEq)]
pub struct Network<T> {
    /// Sec. 3.1.
    pub point_sampler: PointSampler<T>,
    /// Sec. 3.2.
    pub edge_predictor: EdgePredictor<T>,
    /// Sec. 3.3.
    pub face_classifier: FaceClassifier<T>,
}

impl<T> Network<T> {
    /// Applies `f(name, tensor)` to every tensor, in a fixed order.
    ///
    /// # Errors
    /// The first error of `f`.
    pub fn try_map<U, E>(&self, mut f: impl FnMut(&str, &T) -> Result<U, E>) -> Result<Network<U>, E> {
        Ok(Network {
            point_sampler: self.point_sampler.try_map("point_sampler", &mut f)?,
            edge_predictor: self.edge_predictor.try_map("edge_predictor", &mut f)?,
            face_classifier: self.face_classifier.try_map("face_classifier", &mut f)?,
        })
    }

    /// Applies `f(name, tensor)` to every tensor, in a fixed order.
    ///
    /// ```
    /// use neural_mesh::model::Architecture;
    /// let mut names = Vec::new();
    /// Architecture::default().shapes().map(|name, _| names.push(name.to_string()));
    /// assert_eq!(names[0], "point_sampler.dev_conv_0.theta");
    /// ```
    pub fn map<U>(&self, mut f: impl FnMut(&str, &T) -> U) -> Network<U> {
        match self.try_map(|name, tensor| Ok::<U, Infallible>(f(name, tensor))) {
            Ok(network) => network,
            Err(never) => match never {},
        }
    }
}
