//! The command line: which commands there are.

use std::process::ExitCode;

use clap::{Parser, Subcommand};

use crate::measure::{self, MeasureArgs, WholeOther};
use crate::worker;

/// Measure neural-mesh.
#[derive(Parser)]
#[command(name = "neural-mesh-bench", version, arg_required_else_help = true)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Make the pages of docs/measured and the table of the README; the same command goes on where it was stopped.
    Measure(MeasureArgs),
    /// List the pages that were made with other versions; exit 1 where there are any.
    Stale,
    /// Do one job of an evaluation, which comes as a line on standard input.
    #[command(hide = true)]
    Work,
    /// Simplify a file by meshoptimizer: the program that the whole of ours is timed against.
    #[command(hide = true)]
    WholeOther(WholeOther),
}

/// Does what the words of the command line ask.
pub fn run() -> ExitCode {
    let done = match Args::parse().command {
        Command::Measure(args) => measure::run(args),
        Command::Stale => measure::print_stale(),
        Command::Work => worker::work(),
        Command::WholeOther(args) => measure::whole_other(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("neural-mesh-bench: {error:#}");
            ExitCode::FAILURE
        }
    }
}
