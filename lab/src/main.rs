//! Measures neural-mesh: makes every page of `docs/measured` and the table of the README in one command that can be
//! killed and goes on, and says which pages are of another version.
//!
//! What `neural_mesh::evaluate` does, meshes and methods to rows, is asked of it. Here is what has no home there: the pages,
//! stages, growth, memory, parts left out, textured models, levels of detail.

mod bench;
mod cgal;
mod clock;
mod largest;
mod markdown;
mod meshes;
mod pages;
mod quotients;
mod textured;
mod versions;
mod worker;

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::{Parser, Subcommand};

/// Measure neural-mesh.
#[derive(Parser)]
struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Make the pages of docs/measured and the table of the README; the same command goes on where it was stopped.
    Measure(Measure),
    /// List the pages that were made with other versions; exit 1 where there are any.
    Stale,
    /// Do one job of an evaluation, which comes as a line on standard input.
    #[command(hide = true)]
    Work,
    /// Simplify a file by meshoptimizer: the program that the whole of ours is timed against.
    #[command(hide = true)]
    WholeOther(pages::WholeOther),
}

#[derive(clap::Args)]
struct Measure {
    /// Folder that holds the folders of meshes: `train`, `test` and `tosca`.
    #[arg(long)]
    data: PathBuf,
    /// Folder for what is measured, kept by the versions that a page depends on; what is there is not measured again.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/target/measured"))]
    work: PathBuf,
    /// Pages to make; all of them without it.
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
}

/// The repository.
fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

fn main() -> Result<()> {
    match Args::parse().command {
        Command::Measure(Measure { data, work, only }) => pages::make(data, &work, &only),
        Command::Stale => stale(),
        Command::Work => worker::work(),
        Command::WholeOther(args) => pages::whole_other(&args),
    }
}

fn stale() -> Result<()> {
    let pages = versions::stale(root())?;
    pages.iter().for_each(|page| println!("{page}"));
    if pages.is_empty() { Ok(()) } else { bail!("{} pages are of another version: run lab measure", pages.len()) }
}
