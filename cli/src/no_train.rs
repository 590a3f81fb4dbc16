//! What stands for `neural-mesh train` in a build without the feature `train`: a refusal.

use clap::Parser;

use crate::failure::Failure;
use crate::missing::{AnyArgs, refusal};

/// Learn weights from a folder of meshes (needs the feature train)
#[derive(Debug, Parser)]
pub struct TrainArgs {
    #[command(flatten)]
    _any: AnyArgs,
}

/// Refuses.
pub fn run(_: &TrainArgs) -> Result<(), Failure> {
    Err(refusal("train"))
}
