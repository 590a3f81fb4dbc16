//! Stub of `neural-mesh train` for builds without the feature `train`.

use clap::Parser;

use crate::failure::Failure;
use crate::missing_feature::{AnyArgs, missing_feature_failure};

/// Learn weights from a folder of meshes (needs the feature train)
#[derive(Debug, Parser)]
pub struct TrainArgs {
    #[command(flatten)]
    _any: AnyArgs,
}

pub fn run(_: &TrainArgs) -> Result<(), Failure> {
    Err(missing_feature_failure("train"))
}
