//! Arguments of `train` as typed.

use std::path::PathBuf;

use clap::Parser;
use neural_mesh::job::whole_number_parser;

use crate::numbers::parse_thread_count;

const TRAIN_NOTES: &str = "\
The program creates RUN with config.toml (the settings used), data.csv (the meshes with their checksums), steps.csv and \
epochs.csv (the losses), best.safetensors and last.safetensors (weights for --weights), checkpoint.safetensors (for \
--resume), curves.svg (the losses as a picture). docs/training.md explains these files and all settings.

A training killed at any moment continues with the same command plus --resume, and ends with exactly the weights of \
an uninterrupted one. Ctrl-C stops it after the current step, with a checkpoint. With --resume, --epochs may be larger.

Exit codes: 0 success, 1 problem with the input or the disk, or a loss that is not finite, 2 wrong usage, 130 interrupted.";

/// Learn weights from a folder of meshes
#[derive(Debug, Parser)]
#[command(after_help = TRAIN_NOTES, override_usage = "neural-mesh train --data DIR --out RUN [OPTIONS]
       neural-mesh train --plot RUN")]
pub struct TrainArgs {
    /// Folder of meshes to learn from, in the formats of simplify
    #[arg(long, value_name = "DIR", required_unless_present = "plot")]
    pub data: Option<PathBuf>,
    /// Folder for the results
    #[arg(long, value_name = "RUN", required_unless_present = "plot")]
    pub out: Option<PathBuf>,
    /// Settings file; missing settings have defaults
    #[arg(long, value_name = "FILE.toml")]
    pub config: Option<PathBuf>,
    /// Objective, overrides the settings [possible values: bending, paper, shape]
    #[arg(long, value_name = "NAME")]
    pub objective: Option<String>,
    /// Number of epochs, overrides the settings
    #[arg(long, value_name = "N", value_parser = whole_number_parser::<usize>(1, u64::MAX), allow_negative_numbers = true)]
    pub epochs: Option<usize>,
    /// Continue from the checkpoint in RUN, or start if there is none
    #[arg(long)]
    pub resume: bool,
    /// Weights to start from (fine-tuning); they set the sizes of the network
    #[arg(long, value_name = "WEIGHTS")]
    pub init: Option<PathBuf>,
    /// Threads to use [default: one per core]; does not change the result
    #[arg(long, value_name = "N", value_parser = parse_thread_count, allow_negative_numbers = true)]
    pub threads: Option<usize>,
    /// Print errors only
    #[arg(short, long)]
    pub quiet: bool,
    /// Only draw the curves of a training, finished or not
    #[arg(long, value_name = "RUN", conflicts_with_all = ["data", "out", "config", "epochs", "resume", "init"])]
    pub plot: Option<PathBuf>,
}
