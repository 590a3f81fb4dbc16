//! The command line of the program.

mod evaluate;
mod train_baseline;

use std::io::{BufRead, Read};
use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};
use neural_mesh_cli::shared::{Failure, finish, print_help_or_error};
use nix::sys::signal::{Signal, killpg};
use nix::unistd::{getpgrp, getpid};

use crate::evaluate::answer_job;
use crate::measure::{self, MeasureArgs, MeshoptimizerArgs};
use evaluate::EvaluateArgs;
use train_baseline::TrainBaselineArgs;

/// Measure neural-mesh and other methods
#[derive(Parser)]
#[command(name = "neural-mesh-bench", version, arg_required_else_help = true)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    Evaluate(Box<EvaluateArgs>),
    #[command(override_usage = train_baseline::USAGE, mut_arg("objective", |objective| objective.hide(true)))]
    TrainBaseline(Box<TrainBaselineArgs>),
    /// Make the pages of docs/measured and the table of the README; resumes where it was stopped
    Measure(MeasureArgs),
    /// List the pages that were made with other versions; exit 1 if there are any
    Stale,
    /// Do one job of an evaluation, given as a line on standard input
    #[command(hide = true)]
    Work,
    /// Simplify a file with meshoptimizer: the reference for the time of the whole program
    #[command(name = "whole-other", hide = true)]
    WholeMeshoptimizer(MeshoptimizerArgs),
}

/// Runs the command line.
pub fn run() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) => return print_help_or_error(&error),
    };
    let result = match args.command {
        Command::Evaluate(args) => evaluate::run(&args),
        Command::TrainBaseline(args) => train_baseline::run(&args),
        Command::Measure(args) => with_causes(measure::run(args)),
        Command::Stale => with_causes(measure::print_stale()),
        Command::Work => with_causes(run_job()),
        Command::WholeMeshoptimizer(args) => with_causes(measure::run_meshoptimizer(&args)),
    };
    finish(result)
}

fn with_causes(result: Result<()>) -> Result<(), Failure> {
    result.map_err(|error| Failure::Failed(format!("{error:#}")))
}

// Runs one job of an evaluation in this process, whose crash affects nothing else.
fn run_job() -> Result<()> {
    let mut line = String::new();
    std::io::stdin().lock().read_line(&mut line)?;
    // Standard input closes when the caller stops waiting; then this process ends with its children.
    std::thread::spawn(|| {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        if getpgrp() == getpid() {
            let _ = killpg(getpgrp(), Signal::SIGKILL);
        }
        std::process::exit(1);
    });
    print!("{}", answer_job(&line));
    Ok(())
}
