//! All tests of the program in one executable, which links faster than many.

mod advice;
mod assets;
#[cfg(feature = "bake")]
mod bake;
mod batch;
mod bounds;
mod clusters;
mod common;
mod compare;
mod components;
mod compressed;
mod degenerate;
mod files;
mod first_contact;
mod formats;
#[cfg(unix)]
mod guides;
mod hidden;
mod info;
mod levels;
mod limits;
mod memory;
mod mesh_points;
mod names;
mod numbers;
mod option_tables;
mod overwriting;
mod packed;
mod poses;
mod progression;
mod repair;
mod scenes;
mod simplify;
mod sizes;
mod streams;
mod terminal;
mod textures;
mod train;
mod usage;

/// Program under test.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_neural-mesh");
