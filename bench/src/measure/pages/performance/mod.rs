//! Time and memory of simplification.

mod batch;
mod check;
mod files;
mod growth;
mod speed;
mod whole;

use anyhow::Result;

use crate::measure::workbench::Bench;

pub use whole::{MeshoptimizerArgs, run_meshoptimizer};

const INTRO: &str = "Times on one thread are processor time. Times on two threads are wall-clock time and vary \
with other load. Compared methods run in turns. Nanoseconds are per face of the input.\n\n";

pub fn page(bench: &Bench) -> Result<String> {
    let sections = [
        speed::section(bench)?,
        growth::section(bench)?,
        whole::section(bench)?,
        batch::section(bench)?,
        files::section(bench)?,
        check::section(bench)?,
    ];
    Ok(INTRO.to_owned() + &sections.join("\n"))
}
