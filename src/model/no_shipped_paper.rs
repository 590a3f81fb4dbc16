//! Stub of the paper's weights for builds without them.

use super::Weights;

pub(crate) fn paper_weights() -> Option<&'static Weights> {
    None
}
