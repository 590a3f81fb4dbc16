//! `neural-mesh-bench train-baseline`: trains a learned method of others.

use clap::Args;
use neural_mesh::train::Settings;
use neural_mesh_cli::shared::numbers::share;
use neural_mesh_cli::shared::train::{OtherNetwork, TrainArgs, run_for};
use neural_mesh_cli::shared::{Failure, files};

use crate::learned_baselines::{LearnedBaseline, LearnedWeights};

pub const USAGE: &str = "neural-mesh-bench train-baseline METHOD --data DIR --out RUN [OPTIONS]
       neural-mesh-bench train-baseline METHOD --plot RUN";

/// Train weights of a learned method of others on a folder of meshes
#[derive(Debug, Args)]
pub struct TrainBaselineArgs {
    /// Method: dse, potamias or pointtrinet
    #[arg(value_name = "METHOD", value_parser = parse_method)]
    method: LearnedBaseline,
    /// Widths of its networks as a fraction of the full ones; initial weights keep their widths
    #[arg(long, value_name = "SHARE", default_value = "1", value_parser = share)]
    width_share: f64,
    #[command(flatten)]
    train: TrainArgs,
}

fn parse_method(name: &str) -> Result<LearnedBaseline, String> {
    let names = LearnedBaseline::ALL.map(LearnedBaseline::name).join(", ");
    LearnedBaseline::from_name(name).ok_or_else(|| format!("give one of {names}"))
}

pub fn run(args: &TrainBaselineArgs) -> Result<(), Failure> {
    if args.train.objective.is_some() {
        return Err(Failure::Usage("--objective: METHOD already sets the objective: leave --objective out".into()));
    }
    let network = first_weights(args)?.network();
    let other =
        OtherNetwork { objective: args.method.name(), network: &network, step: &|| Box::new(args.method.step()) };
    run_for(&args.train, Some(&other))
}

fn first_weights(args: &TrainBaselineArgs) -> Result<LearnedWeights, Failure> {
    if let Some(path) = &args.train.init {
        let weights = LearnedWeights::from_bytes(&files::read(path)?).map_err(|error| Failure::in_file(path, error))?;
        let learned = weights.baseline();
        let what = format!("has weights for {}, not for {}: give others", learned.name(), args.method.name());
        return if learned == args.method { Ok(weights) } else { Err(Failure::in_file(path, what)) };
    }
    let text = args.train.config.as_deref().map(files::read).transpose()?.unwrap_or_default();
    let settings = Settings::from_toml(&String::from_utf8_lossy(&text));
    let settings = settings.map_err(|error| Failure::Failed(error.to_string()))?;
    Ok(LearnedWeights::random(args.method, args.width_share, settings.seed))
}
