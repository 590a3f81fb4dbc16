//! Stubs of commands whose feature the build lacks; they accept any arguments.

use std::ffi::OsString;

use clap::Parser;

use crate::failure::Failure;

/// Arguments of a missing command.
#[derive(Debug, Parser)]
#[command(disable_help_flag = true)]
pub struct AnyArgs {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    _any: Vec<OsString>,
}

/// Creates the error for a command whose feature, of the same name, is missing.
pub fn missing_feature_failure(command: &str) -> Failure {
    Failure::Usage(format!(
        "{command}: this build lacks the feature {command}: run `cargo run --release --features {command} -- {command} ...`, or \
         install with `cargo install --path cli --features {command}`"
    ))
}
