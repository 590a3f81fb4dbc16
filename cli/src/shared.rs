//! Items shared with `neural-mesh-bench`.

pub use crate::escapes::escape_controls;
pub use crate::failure::{Failure, display_path};
pub use crate::messages::MessageStream;

use std::process::ExitCode;

use crate::messages;

/// Prints an error, including failed writes to standard output, and returns the exit code.
pub fn finish(result: Result<(), Failure>) -> ExitCode {
    crate::finish(result.and_then(|()| messages::check_stdout_written()))
}

/// Prints help, version, or an argument error, and returns the exit code.
pub fn print_help_or_error(answer: &clap::Error) -> ExitCode {
    crate::print_help_or_error(answer)
}

pub mod numbers {
    pub use crate::numbers::parse_thread_count;
    pub use neural_mesh::job::{number_parser, seed as parse_seed, share, whole_number_parser};
}

/// Files, read with errors that name them.
pub mod files {
    pub use crate::files::read;
}

/// The command `train` for networks other than the paper's.
pub mod train {
    pub use crate::train::{OtherNetwork, TrainArgs, run_for};
}

/// Ctrl-C for work that ends cleanly.
pub mod stopping {
    pub use crate::stopping::{handle_stop_signals, is_stop_requested};
}
