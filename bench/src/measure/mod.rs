//! Makes the pages of `docs/measured` and the README's table.

mod cgal;
mod clock;
mod hausdorff;
mod markdown;
mod meshes;
mod pages;
mod quotients;
mod textured;
mod versions;
mod workbench;

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

pub use pages::{MeshoptimizerArgs, run_meshoptimizer};

/// Arguments of `measure`.
#[derive(Debug, clap::Args)]
pub struct MeasureArgs {
    /// Folder with the mesh folders `train`, `test` and `tosca`
    #[arg(long)]
    data: PathBuf,
    /// Folder for measurements, by version; those already there are not repeated
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/measured"))]
    work: PathBuf,
    /// Pages to make [default: all]
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
}

pub fn run(MeasureArgs { data, work, only }: MeasureArgs) -> Result<()> {
    pages::make_pages(data, &work, &only)
}

pub fn print_stale() -> Result<()> {
    let pages = versions::stale_pages(root())?;
    pages.iter().for_each(|page| println!("{page}"));
    if pages.is_empty() {
        Ok(())
    } else {
        bail!("{} pages are of another version: run neural-mesh-bench measure", pages.len())
    }
}

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}
