//! The `neural-mesh` program: arguments in, files out; no algorithm lives here.

mod args;
mod batch;
mod chart;
mod compare;
mod curves;
mod evaluate;
mod evaluate_progress;
mod failure;
mod files;
mod info;
mod interrupt;
mod memory;
mod mesh_points;
mod progress;
mod read;
mod report;
mod request;
mod simplify;
mod subject;
mod train;
mod train_progress;
mod words;

use std::process::ExitCode;

use clap::Parser;

use args::{Args, Command};

fn main() -> ExitCode {
    memory::keep_freed();
    let done = match Args::parse().command {
        Command::Simplify(args) if batch::is_meant(&args) => batch::run(args),
        Command::Simplify(args) => request::resolve(args).and_then(simplify::run),
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
