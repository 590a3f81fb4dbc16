//! Makes every page of `docs/measured` and the table of the README in one command that can be killed and goes on, and says which
//! pages are of another version.
//!
//! Rows of methods and meshes come from `evaluate`. Here is what has no home there: the pages, stages, growth, memory, parts left
//! out, textured models, levels of detail.

mod cgal;
mod clock;
mod largest;
mod markdown;
mod meshes;
mod pages;
mod quotients;
mod textured;
mod versions;
mod workbench;

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};

pub use pages::{WholeOther, whole_other};

/// Arguments of `measure`.
#[derive(Debug, clap::Args)]
pub struct MeasureArgs {
    /// Folder that holds the folders of meshes: `train`, `test` and `tosca`.
    #[arg(long)]
    data: PathBuf,
    /// Folder for what is measured, kept by the versions that a page depends on; what is there is not measured again.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/../target/measured"))]
    work: PathBuf,
    /// Pages to make; all of them without it.
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
}

/// Makes the pages that the arguments name.
pub fn run(MeasureArgs { data, work, only }: MeasureArgs) -> Result<()> {
    pages::make(data, &work, &only)
}

/// Prints the pages that are of another version, which is an error.
pub fn print_stale() -> Result<()> {
    let pages = versions::stale(root())?;
    pages.iter().for_each(|page| println!("{page}"));
    if pages.is_empty() {
        Ok(())
    } else {
        bail!("{} pages are of another version: run neural-mesh-bench measure", pages.len())
    }
}

/// The repository.
fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}
