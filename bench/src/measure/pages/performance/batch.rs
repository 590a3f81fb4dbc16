//! A folder in one batch against one process per mesh.

use std::process::Command;

use anyhow::Result;

use super::super::build_program;
use crate::measure::clock::{format_spread, measure_program_time};
use crate::measure::meshes::name;
use crate::measure::workbench::Bench;

const ROUNDS: usize = 3;

pub fn section(bench: &Bench) -> Result<String> {
    let meshes = bench.meshes("train")?;
    // Rates are in meshes per second: in one batch, one by one.
    let rounds: Vec<[f64; 2]> = bench.measure_once("batch", || {
        let (program, folder) = (build_program()?, bench.scratch("batch")?);
        let simplify = |arguments: &mut dyn FnMut(&mut Command)| {
            let mut command = Command::new(&program);
            command.args(["simplify", "--ratio", "0.1", "--quiet", "--force"]);
            arguments(&mut command);
            Ok::<f64, anyhow::Error>(measure_program_time(&mut command)?[0])
        };
        let round = |_| {
            let mut one_by_one = 0.0;
            for mesh in &meshes {
                let output = folder.join(name(mesh)).with_extension("ply");
                one_by_one += simplify(&mut |command| {
                    command.arg(mesh).arg("-o").arg(&output).args(["--threads", "1"]);
                })?;
            }
            let at_once = simplify(&mut |command| {
                command.args(&meshes).arg("-o").arg(folder.join("all"));
            })?;
            std::fs::remove_dir_all(folder.join("all"))?;
            Ok([at_once, one_by_one].map(|seconds| meshes.len() as f64 / seconds))
        };
        (0..ROUNDS).map(round).collect()
    })?;
    let of = |value: fn(&[f64; 2]) -> f64| format_spread(&rounds.iter().map(value).collect::<Vec<_>>());
    Ok(format!(
        "## Batches\n\nThe {} training meshes at ratio 0.1 in one batch on all threads: {} meshes per second, {} times the rate of one \
         single-threaded process per mesh. Median (least to largest) of {ROUNDS} rounds.\n",
        meshes.len(),
        of(|[at_once, _]| *at_once),
        of(|[at_once, one_by_one]| at_once / one_by_one)
    ))
}
