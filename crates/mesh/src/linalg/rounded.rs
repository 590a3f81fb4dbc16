//! Logarithm and exponential of single precision, rounded from double: nearly always the same bits on every target.
//!
//! Importance depends on both, and the order of merges on the last bit of importance. In single precision the libraries
//! of targets differ in one value of 500.

/// Returns the natural logarithm.
#[doc(hidden)]
#[inline]
pub fn ln(x: f32) -> f32 {
    f64::from(x).ln() as f32
}

/// Returns the exponential.
#[doc(hidden)]
#[inline]
pub fn exp(x: f32) -> f32 {
    f64::from(x).exp() as f32
}
