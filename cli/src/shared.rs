//! Items shared with `neural-mesh-bench`.

pub use crate::failure::{Failure, name};
pub use crate::plain::plain;
pub use crate::words::{Voice, complain};

use std::process::ExitCode;

use crate::words;

/// Prints an error, including failed writes to standard output, and returns the exit code.
pub fn finish(done: Result<(), Failure>) -> ExitCode {
    crate::finish(done.and_then(|()| words::check_written()))
}

/// Prints help, version, or an argument error, and returns the exit code.
pub fn print_answer(answer: &clap::Error) -> ExitCode {
    crate::print_answer(answer)
}

pub mod numbers {
    pub use crate::numbers::{n_threads, number, seed, whole};
    pub use neural_mesh::job::share;
}

/// Files that appear complete or not at all.
pub mod files {
    pub use crate::files::{Pending, place, prepare, read};
}

/// The command `train` for networks other than the paper's.
#[cfg(feature = "train")]
pub mod train {
    pub use crate::train::{OtherNetwork, TrainArgs, run_for};
}

/// Ctrl-C for work that ends cleanly.
pub mod stopping {
    pub use crate::stopping::{is_stopping, watch_for_a_good_end};
}

pub mod page {
    pub use crate::page::packed::Packed;
    pub use crate::page::pairs::{Distances, scale, surface};
    pub use crate::page::surface_data::{Layout, SurfaceData};
    pub use crate::page::{fill_page, island, json_island};
}
