//! The clock that JavaScript gives.
#![allow(unsafe_code, reason = "imported functions are unsafe to declare")]

#[cfg(target_arch = "wasm32")]
#[link(wasm_import_module = "env")]
unsafe extern "C" {
    safe fn now() -> f64;
}

/// Stub for builds outside of a browser: no clock.
#[cfg(not(target_arch = "wasm32"))]
fn now() -> f64 {
    0.0
}

/// Returns the seconds since some moment.
pub fn seconds() -> f64 {
    now() / 1e3
}
