//! Time of the paper's assembly.

use std::ops::ControlFlow;

use anyhow::Result;
use neural_mesh::simplify::{Assembly, Options, Target, simplify};

use super::threads;
use crate::measure::clock::measure_time;
use crate::measure::markdown::{number, table};
use crate::measure::meshes::{load, name};
use crate::measure::workbench::Bench;

const RATIOS: [f64; 3] = [0.05, 0.1, 0.2];
const EVERY: usize = 8;

pub fn section(bench: &Bench) -> Result<String> {
    // Each mesh has the seconds at each ratio, on one thread and on two.
    let mut all: Vec<Vec<[f64; 2]>> = Vec::new();
    for path in bench.meshes("tosca")?.iter().step_by(EVERY) {
        all.push(bench.measure_once(&format!("paper-speed/{}", name(path)), || measure(path))?);
    }
    let line = |name: &str, of: usize| {
        let sum = |at: usize| number(Some(all.iter().map(|mesh| mesh[at][of]).sum()));
        [name.to_owned()].into_iter().chain((0..RATIOS.len()).map(sum)).collect::<Vec<String>>()
    };
    let mut head = vec![String::new()];
    head.extend(RATIOS.map(|ratio| ratio.to_string()));
    Ok(format!(
        "## The paper's assembly\n\nSeconds of `--assembly paper` for {} meshes of TOSCA, every {EVERY}th by name.\n\n{}",
        all.len(),
        table(&head, &[line("one thread", 0), line("two threads", 1)])
    ))
}

fn measure(path: &std::path::Path) -> Result<Vec<[f64; 2]>> {
    let mesh = load(path)?;
    let [one, two] = [threads(1)?, threads(2)?];
    let of = |ratio: f64| {
        let mut options = Options::new(Target::Ratio(ratio));
        options.assembly = Assembly::Paper;
        let ours = || Ok(simplify(&mesh, None, &options, &mut |_| ControlFlow::Continue(()))?);
        let [alone, shared] = [one.install(|| measure_time(ours))?.1, two.install(|| measure_time(ours))?.1];
        Ok([alone.thread, shared.wall])
    };
    RATIOS.iter().map(|&ratio| of(ratio)).collect()
}
