//! Stub of the paper's weights for builds without them.

use super::Weights;

/// Returns `None`: this build has no weights for the paper's assembly.
pub(crate) fn paper_weights() -> Option<&'static Weights> {
    None
}
