//! Clock of JavaScript.
#![allow(unsafe_code, reason = "imported functions are unsafe to declare")]

#[cfg(target_arch = "wasm32")]
#[link(wasm_import_module = "env")]
unsafe extern "C" {
    safe fn now() -> f64;
}

#[cfg(not(target_arch = "wasm32"))]
fn now() -> f64 {
    0.0
}

/// Returns the seconds since an arbitrary moment.
pub fn seconds() -> f64 {
    now() / 1e3
}
