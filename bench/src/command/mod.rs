//! The command line: which commands there are.

mod evaluate;
mod train_baseline;
mod work;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};
use neural_mesh_cli::shared::{Failure, answered, ended};

use crate::measure::{self, MeasureArgs, MeshoptimizerArgs};
use evaluate::EvaluateArgs;
use train_baseline::TrainBaselineArgs;

pub use work::worker;

/// Measure neural-mesh, and methods of others.
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
    /// Make the pages of docs/measured and the table of the README; the same command goes on where it was stopped
    Measure(MeasureArgs),
    /// List the pages that were made with other versions; exit 1 where there are any
    Stale,
    /// Do one job of an evaluation, which comes as a line on standard input
    #[command(hide = true)]
    Work,
    /// Simplify a file by meshoptimizer: the program that the whole of ours is timed against
    #[command(hide = true)]
    WholeOther(MeshoptimizerArgs),
}

/// Does what the words of the command line ask.
pub fn run() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(answer) => return answered(&answer),
    };
    let done = match args.command {
        Command::Evaluate(args) => evaluate::run(&args),
        Command::TrainBaseline(args) => train_baseline::run(&args),
        Command::Measure(args) => told(measure::run(args)),
        Command::Stale => told(measure::print_stale()),
        Command::Work => told(work::work()),
        Command::WholeOther(args) => told(measure::run_meshoptimizer(&args)),
    };
    ended(done)
}

/// A failure that tells the whole story.
fn told(done: Result<()>) -> Result<(), Failure> {
    done.map_err(|error| Failure::Failed(format!("{error:#}")))
}
