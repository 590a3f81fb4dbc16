//! The `neural-mesh` program: arguments in, files out; no algorithm lives here.
//!
//! `main.rs` is the program itself. Other faces call what `embedded` passes on: the same requests, without a terminal. `shared`
//! passes on what the package `neural-mesh-bench` has in common with this one.

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

/// Does what the words of the command line ask.
pub fn run() -> ExitCode {
    allocator::end_by(out_of_memory::end);
    memory::bound(None);
    memory::keep_freed();
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(answer) => return answered(&answer),
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
    // Words that nobody could hear are the worse failure than a result that is short of what was asked.
    ended(if let Ok(()) | Err(Failure::Unmet(_)) = done { words::heard().and(done) } else { done })
}

/// The command line as clap has it, for what is made of it: completions and man pages.
#[doc(hidden)]
pub fn command_line() -> clap::Command {
    Args::command()
}

fn ended(done: Result<(), Failure>) -> ExitCode {
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Told) => Failure::Told.exit_code(),
        Err(failure) => {
            words::complain(&failure);
            failure.exit_code()
        }
    }
}

/// Help, the version, or what is wrong with the arguments, which may be names of any bytes.
fn answered(answer: &clap::Error) -> ExitCode {
    if !answer.use_stderr() {
        let said = words::out(b"").and_then(|()| answer.print()).and_then(|()| words::out(b""));
        return ended(said.map_err(|error| words::closed(&error)));
    }
    if let Some(failure) = usage::refused_value(answer) {
        return ended(Err(failure));
    }
    match std::env::args_os().all(|word| matches!(plain(&word.to_string_lossy()), Cow::Borrowed(_))) {
        true => drop(answer.print()),
        // Without the colours, which are made of escapes as well.
        false => answer.to_string().lines().for_each(|line| Voice::Err.say(line)),
    }
    ExitCode::from(u8::try_from(answer.exit_code()).unwrap_or(2))
}
