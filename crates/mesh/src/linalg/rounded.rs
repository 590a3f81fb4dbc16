//! Logarithm and exponential of single precision as glibc rounds them, on every target.
//!
//! Importance depends on both, and the order of merges on the last bit of importance.

/// Returns the natural logarithm, as glibc rounds it but for one value in 500.
#[doc(hidden)]
#[inline]
pub fn ln(x: f32) -> f32 {
    // WebAssembly's own logarithm of single precision is less accurate than glibc's.
    if cfg!(target_family = "wasm") { f64::from(x).ln() as f32 } else { x.ln() }
}

/// Returns the exponential, as glibc rounds it but for one value in 1,600.
#[doc(hidden)]
#[inline]
pub fn exp(x: f32) -> f32 {
    if cfg!(target_family = "wasm") { f64::from(x).exp() as f32 } else { x.exp() }
}
