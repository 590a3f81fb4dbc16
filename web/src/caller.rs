//! Who hears how far a run is: JavaScript.
#![allow(unsafe_code, reason = "imported functions are unsafe to declare")]

use std::ops::ControlFlow;

#[cfg(target_arch = "wasm32")]
#[link(wasm_import_module = "env")]
unsafe extern "C" {
    safe fn progress(share: f64, part: u32) -> u32;
}

/// Nobody hears it outside of a browser.
#[cfg(not(target_arch = "wasm32"))]
fn progress(_: f64, _: u32) -> u32 {
    0
}

/// Tells how far a part of a run is; `Break` where JavaScript ends it.
pub fn tell(share: f64, part: u32) -> ControlFlow<()> {
    if progress(share, part) == 0 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
}
