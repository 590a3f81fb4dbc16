//! The `neural-mesh` program: turns arguments into files; all algorithms are in the library.
//!
//! Module `embedded` offers the commands to other programs.

mod allocator;
mod args;
mod bar;
mod batch;
mod closed_stdout;
mod clusters;
mod command;
mod compare;
mod content;
mod document;
mod drawing;
pub mod embedded;
mod escapes;
mod failure;
mod files;
mod finished_run;
mod info;
mod interrupt;
mod levels_info;
mod memory;
mod mesh_points;
mod messages;
mod names;
mod numbers;
mod out_of_core;
mod out_of_memory;
mod page;
mod plan;
mod progress;
mod progression;
mod read;
mod request;
mod scene_info;
#[doc(hidden)]
pub mod shared;
mod simplify;
mod size_limits;
mod stopping;
mod train;
mod usage;

use std::borrow::Cow;
use std::process::ExitCode;

use clap::{CommandFactory, Parser};

pub use allocator::BoundedAllocator;
use command::{Args, Command};
use escapes::escape_controls;
use failure::Failure;
use messages::MessageStream;

/// Runs the command line and returns the exit code.
pub fn run() -> ExitCode {
    allocator::set_out_of_memory_handler(out_of_memory::end_program);
    memory::limit_memory(None);
    memory::retain_freed_blocks();
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(answer) => return print_help_or_error(&answer),
    };
    let result = match args.command {
        Command::Simplify(args) if batch::is_batch(&args) => batch::run(*args),
        Command::Simplify(args) => request::resolve_request(*args).and_then(simplify::run),
        Command::MeshPoints(args) => mesh_points::run(args),
        Command::Progression(args) => progression::run(&args),
        Command::Info(args) => info::run(&args),
        Command::Clusters(args) => clusters::run(&args),
        Command::Limits(args) => size_limits::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Train(args) => train::run(&args),
    };
    // A failed write to standard output outranks a missed target.
    finish(if let Ok(()) | Err(Failure::Unmet(_)) = result {
        messages::check_stdout_written().and(result)
    } else {
        result
    })
}

/// Returns the command line definition, for completions and man pages.
#[doc(hidden)]
pub fn command_line() -> clap::Command {
    Args::command()
}

fn finish(result: Result<(), Failure>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Reported) => Failure::Reported.exit_code(),
        Err(failure) => {
            messages::print_error(&failure);
            failure.exit_code()
        }
    }
}

fn print_help_or_error(answer: &clap::Error) -> ExitCode {
    if !answer.use_stderr() {
        // Writes of no bytes detect a standard output that is closed or full.
        let written =
            messages::write_stdout(b"").and_then(|()| answer.print()).and_then(|()| messages::write_stdout(b""));
        return finish(written.map_err(|error| messages::stdout_failure(&error)));
    }
    let words: Vec<String> = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned()).collect();
    if let Some(failure) = usage::explain_error(answer, &words) {
        return finish(Err(failure));
    }
    match std::env::args_os().all(|word| matches!(escape_controls(&word.to_string_lossy()), Cow::Borrowed(_))) {
        true => drop(answer.print()),
        // Without colours, since their escape codes would be spelled out too.
        false => answer.to_string().lines().for_each(|line| MessageStream::Err.print_line(line)),
    }
    ExitCode::from(u8::try_from(answer.exit_code()).unwrap_or(2))
}
