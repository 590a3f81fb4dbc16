//! What stands for the commands that a build lacks: any arguments, and a line that says how to get the command.

use std::ffi::OsString;

use clap::Parser;

use crate::failure::Failure;

/// Arguments of a command that is not there.
#[derive(Debug, Parser)]
#[command(disable_help_flag = true)]
pub struct AnyArgs {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _any: Vec<OsString>,
}

/// The refusal of a command that has the name of its feature.
pub fn refusal(command: &str) -> Failure {
    Failure::Usage(format!(
        "{command}: this build lacks the feature {command}: run `cargo run --release --features {command} -- {command} ...`, or \
         install with `cargo install --path cli --features {command}`"
    ))
}
