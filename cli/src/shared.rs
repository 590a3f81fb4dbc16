//! What another program of this repository has in common with this one: words, failures, numbers, files, pages.

pub use crate::failure::{Failure, name};
pub use crate::plain::plain;
pub use crate::words::{Voice, complain};

use std::process::ExitCode;

use crate::words;

/// Says what went wrong, if anything, also where standard output took not all; gives the exit code.
pub fn ended(done: Result<(), Failure>) -> ExitCode {
    crate::ended(done.and_then(|()| words::heard()))
}

/// Says help, the version, or what is wrong with the arguments; gives the exit code.
pub fn answered(answer: &clap::Error) -> ExitCode {
    crate::answered(answer)
}

/// Values of options.
pub mod numbers {
    pub use crate::numbers::{n_threads, number, seed, whole};
    pub use neural_mesh::job::share;
}

/// Files that appear whole or not at all.
pub mod files {
    pub use crate::files::{Pending, place, prepare, read};
}

/// The command `train`, for other networks than the paper's.
#[cfg(feature = "train")]
pub mod train {
    pub use crate::train::{OtherNetwork, TrainArgs, run_for};
}

/// Ctrl-C for work that comes to a good end by itself.
pub mod stopping {
    pub use crate::stopping::{is_stopping, watch_for_a_good_end};
}

/// HTML pages that ask for nothing outside themselves.
pub mod page {
    pub use crate::page::packed::Packed;
    pub use crate::page::pairs::{Distances, scale, surface};
    pub use crate::page::surface_data::{Layout, SurfaceData};
    pub use crate::page::{filled, island, json_island};
}
