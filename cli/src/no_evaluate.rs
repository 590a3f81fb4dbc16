//! What stands for `neural-mesh evaluate` in a build without the feature `evaluate`: a refusal.

use clap::Parser;

use crate::failure::Failure;
use crate::missing::{AnyArgs, refusal};

/// Measure methods at several sizes on a folder of meshes (needs the feature evaluate)
#[derive(Debug, Parser)]
pub struct EvaluateArgs {
    #[command(flatten)]
    _any: AnyArgs,
}

/// Refuses.
pub fn run(_: &EvaluateArgs) -> Result<(), Failure> {
    Err(refusal("evaluate"))
}

/// Refuses the job that an evaluation would ask for.
pub fn work() -> Result<(), Failure> {
    Err(refusal("evaluate"))
}
