//! Stub of the paper's weights for builds without them.

use super::Weights;

#[doc(hidden)]
pub fn paper_weights() -> Option<&'static Weights> {
    None
}
