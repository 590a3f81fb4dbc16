//! The main table: ours with its defaults and meshoptimizer, taking turns.

use std::path::PathBuf;

use anyhow::Result;
use clap::ValueEnum;

use crate::methods::{self, Method, Ours, Scores};
use crate::table;
use crate::turns::{Contestant, Plan, fill};

#[derive(clap::Args)]
pub struct Args {
    /// Mesh files.
    #[arg(long, num_args = 1.., required = true)]
    mesh: Vec<PathBuf>,
    #[command(flatten)]
    plan: Plan,
    /// Table to write.
    #[arg(long)]
    out: PathBuf,
    /// Samples drawn per vertex asked for; without it, the method's own choice.
    #[arg(long)]
    oversample: Option<f64>,
    /// Where our scores come from.
    #[arg(long, value_enum, default_value = "network")]
    scores: Scores,
    /// Methods to run; all of them without it.
    #[arg(long, value_enum, value_delimiter = ',')]
    method: Vec<Method>,
    /// Keep the rows that the table already has.
    #[arg(long)]
    resume: bool,
}

impl Args {
    /// The methods to run, ours first: the other one gets its number of faces.
    fn contestants(&self) -> Vec<Contestant<'_>> {
        let wanted = |method: &Method| self.method.is_empty() || self.method.contains(method);
        Method::value_variants().iter().filter(|method| wanted(method)).map(|&method| self.contestant(method)).collect()
    }

    fn contestant(&self, method: Method) -> Contestant<'_> {
        let Self { oversample, scores, .. } = *self;
        Contestant::new(method.name(scores), move |case, n_faces| match method {
            Method::Ours => methods::ours(&case.original.raw, case.ratio, Ours { oversample, scores, seed: case.seed }),
            Method::Meshoptimizer => methods::meshoptimizer(&case.original.mesh, n_faces),
        })
    }
}

/// Runs every case and writes the table after each of them.
pub fn run(args: &Args) -> Result<()> {
    let mut rows = if args.resume { table::read(&args.out)? } else { Vec::new() };
    fill(&mut rows, &args.mesh, &args.contestants(), &args.plan, Some(&args.out))
}
