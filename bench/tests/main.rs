//! All integration tests in one program.

mod baselines;
#[path = "../../cli/tests/common/mod.rs"]
mod common;
#[cfg(unix)] // The tools are shell scripts.
mod evaluate;
mod train_baseline;

/// The program under test.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_neural-mesh-bench");
