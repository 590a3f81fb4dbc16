//! Progress listener in JavaScript.
#![allow(unsafe_code, reason = "imported functions are unsafe to declare")]

use std::ops::ControlFlow;

#[cfg(target_arch = "wasm32")]
#[link(wasm_import_module = "env")]
unsafe extern "C" {
    safe fn progress(share: f64, step: u32) -> u32;
}

#[cfg(not(target_arch = "wasm32"))]
fn progress(_: f64, _: u32) -> u32 {
    0
}

/// Reports the finished share of step `part`; returns `Break` if JavaScript ends the run.
pub fn report_progress(share: f64, step: u32) -> ControlFlow<()> {
    if progress(share, step) == 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}
