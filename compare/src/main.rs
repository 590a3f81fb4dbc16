//! Measures neural-mesh against meshoptimizer on mesh files: one CSV row per mesh, ratio, seed and method.
//!
//! Simplification is timed on one thread, the methods taking turns in one process; metrics use all threads.

mod load;
mod measure;
mod methods;
mod row;
mod run;

use clap::Parser;

fn main() -> anyhow::Result<()> {
    run::run(&run::Args::parse())
}
