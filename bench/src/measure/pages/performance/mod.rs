//! What simplification costs: time against meshoptimizer, by stage, as the mesh grows, of files, batches and the program.

mod batch;
mod check;
mod files;
mod growth;
mod paper;
mod speed;
mod whole;

use anyhow::Result;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::measure::workbench::Bench;

pub use whole::{Other as WholeOther, other as whole_other};

const INTRO: &str = "Times on one thread are the processor's, on two threads the wall's, which other work on the machine disturbs. \
What is compared takes turns. Nanoseconds are per face of the input.\n\n";

pub fn page(bench: &Bench) -> Result<String> {
    let sections = [
        speed::section(bench)?,
        growth::section(bench)?,
        whole::section(bench)?,
        batch::section(bench)?,
        files::section(bench)?,
        check::section(bench)?,
        paper::section(bench)?,
    ];
    Ok(INTRO.to_owned() + &sections.join("\n"))
}

fn threads(n: usize) -> Result<ThreadPool> {
    Ok(ThreadPoolBuilder::new().num_threads(n).build()?)
}
