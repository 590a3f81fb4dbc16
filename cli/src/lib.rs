//! The `neural-mesh` program: turns arguments into files; all algorithms are in the library.
//!
//! Module `embedded` offers the commands to other programs.

mod allocator;
mod args;
mod bar;
mod batch;
mod closed;
mod command;
mod compare;
mod content;
mod document;
mod done;
mod drawing;
pub mod embedded;
mod failure;
mod files;
mod info;
mod interrupt;
mod memory;
mod mesh_points;
#[cfg(not(feature = "train"))]
mod missing;
mod names;
mod numbers;
mod out_of_core;
mod out_of_memory;
mod page;
mod plain;
mod plan;
mod progress;
mod read;
mod request;
mod scene_info;
#[doc(hidden)]
pub mod shared;
mod simplify;
mod size_limits;
mod stopping;
#[cfg(feature = "train")]
mod train;
#[cfg(not(feature = "train"))]
#[path = "no_train.rs"]
mod train;
mod usage;
mod words;

use std::borrow::Cow;
use std::process::ExitCode;

use clap::{CommandFactory, Parser};

pub use allocator::Bounded;
use command::{Args, Command};
use failure::Failure;
use plain::plain;
use words::Voice;

/// Runs the command line and returns the exit code.
pub fn run() -> ExitCode {
    allocator::end_by(out_of_memory::end);
    memory::bound(None);
    memory::keep_freed();
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(answer) => return print_answer(&answer),
    };
    let done = match args.command {
        Command::Simplify(args) if batch::is_meant(&args) => batch::run(*args),
        Command::Simplify(args) => request::resolve(*args).and_then(simplify::run),
        Command::MeshPoints(args) => mesh_points::run(args),
        Command::Info(args) => info::run(&args),
        Command::Limits(args) => size_limits::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Train(args) => train::run(&args),
    };
    // A failed write to standard output outranks a missed target.
    finish(if let Ok(()) | Err(Failure::Unmet(_)) = done { words::check_written().and(done) } else { done })
}

/// Returns the command line definition, for completions and man pages.
#[doc(hidden)]
pub fn command_line() -> clap::Command {
    Args::command()
}

fn finish(done: Result<(), Failure>) -> ExitCode {
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Reported) => Failure::Reported.exit_code(),
        Err(failure) => {
            words::complain(&failure);
            failure.exit_code()
        }
    }
}

fn print_answer(answer: &clap::Error) -> ExitCode {
    if !answer.use_stderr() {
        // The empty writes detect a standard output that is closed or full.
        let said = words::write_stdout(b"").and_then(|()| answer.print()).and_then(|()| words::write_stdout(b""));
        return finish(said.map_err(|error| words::stdout_failure(&error)));
    }
    if let Some(failure) = usage::refused_value(answer) {
        return finish(Err(failure));
    }
    match std::env::args_os().all(|word| matches!(plain(&word.to_string_lossy()), Cow::Borrowed(_))) {
        true => drop(answer.print()),
        // Without colours, since their escape codes would be spelled out too.
        false => answer.to_string().lines().for_each(|line| Voice::Err.say(line)),
    }
    ExitCode::from(u8::try_from(answer.exit_code()).unwrap_or(2))
}
