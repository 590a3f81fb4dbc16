//! What the corners of the result carry.

pub(super) mod corners;
pub(super) mod values;
