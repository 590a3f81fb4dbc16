//! Build script of both libraries for C: the shared one is named after its interface, as `libneural_mesh_core.so.1`.
//!
//! A program then asks for that name when it starts, and not for a file of another interface. cargo-c sets the name itself.

use std::env::{var, var_os};

fn main() {
    let source = include_str!("core/src/lib.rs");
    let number = source.split_once("NM_ABI_VERSION: u32 = ").and_then(|(_, rest)| rest.split_once(';'));
    let library = var("CARGO_PKG_NAME").map(|name| name.replace('-', "_"));
    let is_elf = var("CARGO_CFG_TARGET_FAMILY").is_ok_and(|family| family == "unix")
        && var("CARGO_CFG_TARGET_VENDOR").is_ok_and(|vendor| vendor != "apple");
    // Arguments for shared libraries alone would go to those of other packages, too.
    if let (Some((number, _)), Ok(library), true, None) = (number, library, is_elf, var_os("CARGO_FEATURE_CAPI")) {
        println!("cargo::rustc-link-arg=-Wl,-soname,lib{library}.so.{number}");
    }
}
