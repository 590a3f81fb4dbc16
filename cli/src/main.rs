//! The `neural-mesh` program: arguments in, files out; no algorithm lives here.

mod args;
mod batch;
mod command;
mod compare;
#[cfg(feature = "evaluate")]
mod evaluate;
#[cfg(not(feature = "evaluate"))]
#[path = "no_evaluate.rs"]
mod evaluate;
mod failure;
mod files;
mod info;
mod interrupt;
mod memory;
mod mesh_points;
#[cfg(not(all(feature = "evaluate", feature = "train")))]
mod missing;
mod progress;
mod read;
mod report;
mod request;
mod simplify;
#[cfg(any(feature = "evaluate", feature = "train"))]
mod stopping;
mod subject;
#[cfg(feature = "train")]
mod train;
#[cfg(not(feature = "train"))]
#[path = "no_train.rs"]
mod train;
mod words;

use std::process::ExitCode;

use clap::Parser;

use command::{Args, Command};

fn main() -> ExitCode {
    memory::keep_freed();
    let done = match Args::parse().command {
        Command::Simplify(args) if batch::is_meant(&args) => batch::run(*args),
        Command::Simplify(args) => request::resolve(*args).and_then(simplify::run),
        Command::MeshPoints(args) => mesh_points::run(args),
        Command::Info(args) => info::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Train(args) => train::run(&args),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::EvaluateOne => evaluate::work(),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            words::complain(&failure);
            failure.exit_code()
        }
    }
}
