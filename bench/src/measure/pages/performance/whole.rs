//! The whole program against a small one around meshoptimizer.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::baselines::meshoptimizer_faces;
use crate::evaluate::median;
use anyhow::Result;
use neural_mesh::io::{Format, read_path, write, write_path};
use neural_mesh::mesh::{Frame, RawMesh, TriMesh, compact};

use super::super::{RATIOS, build_program};
use crate::measure::clock::{format_spread, measure_program_time};
use crate::measure::markdown::{count, table};
use crate::measure::meshes::{load, name};
use crate::measure::workbench::Bench;

const ABOVE: usize = 50_000;
const ROUNDS: usize = 3;

/// Arguments of the program around meshoptimizer.
#[derive(clap::Args)]
pub struct MeshoptimizerArgs {
    input: PathBuf,
    output: PathBuf,
    faces: usize,
}

pub fn run_meshoptimizer(args: &MeshoptimizerArgs) -> Result<()> {
    let RawMesh { positions, faces, .. } = read_path(&args.input, None)?;
    let positions = positions.into_iter().map(|p| p.map(|x| x as f32)).collect();
    let mesh = TriMesh::new(positions, faces)?;
    let faces = meshoptimizer_faces(&mesh, args.faces);
    let simplified = compact(mesh.positions(), faces)?.0;
    Ok(write_path(&args.output, &write(&simplified, &Frame::default(), Format::Ply)?, true)?)
}

type TimeQuotients = Vec<(f64, [f64; 2])>;

pub fn section(bench: &Bench) -> Result<String> {
    let mut quotients = TimeQuotients::new();
    for path in bench.meshes("test")?.iter().filter(|path| path.extension().is_some_and(|ending| ending == "ply")) {
        quotients
            .extend(bench.measure_once::<TimeQuotients>(&format!("whole/{}", name(path)), || measure(bench, path))?);
    }
    let line = |name: String, ratios: &[f64]| {
        let of = |at: usize| {
            let some = quotients.iter().filter(|(ratio, _)| ratios.contains(ratio));
            format_spread(&some.map(|(_, both)| both[at]).collect::<Vec<_>>())
        };
        vec![name, of(0), of(1)]
    };
    let mut lines: Vec<Vec<String>> = RATIOS.iter().map(|&ratio| line(ratio.to_string(), &[ratio])).collect();
    lines.push(line("all".into(), &RATIOS));
    Ok(format!(
        "## The whole program\n\n`neural-mesh simplify` with its defaults on all threads, from file to file: time \
         divided by that of a small program around meshoptimizer, which reads and writes with the same code, \
         without cleanup and check. The {} PLY files of the \
         benchmark above {} faces; median (least to largest) of medians of {ROUNDS} rounds.\n\n{}",
        quotients.len() / RATIOS.len(),
        count(ABOVE),
        table(&["ratio", "wall-clock time", "processor time"], &lines)
    ))
}

fn measure(bench: &Bench, path: &Path) -> Result<TimeQuotients> {
    let n_faces = load(path)?.faces().len();
    if n_faces <= ABOVE {
        return Ok(Vec::new());
    }
    let (program, output) = (build_program()?, bench.scratch("whole")?.join("out.ply"));
    let of = |ratio: f64| {
        let mut ours = Command::new(&program);
        ours.arg("simplify").arg(path).arg("-o").arg(&output).args([
            "--quiet",
            "--force",
            "--ratio",
            &ratio.to_string(),
        ]);
        let mut other = Command::new(std::env::current_exe()?);
        let n_left = (ratio * n_faces as f64).round() as usize;
        other.arg("whole-other").arg(path).arg(&output).arg(n_left.to_string());
        let mut rounds = [const { Vec::new() }; 2];
        for _ in 0..ROUNDS {
            let (own, other) = (measure_program_time(&mut ours)?, measure_program_time(&mut other)?);
            (0..2).for_each(|at| rounds[at].push(own[at] / other[at]));
        }
        Ok((ratio, rounds.map(|values| median(values).unwrap_or_default())))
    };
    RATIOS.iter().map(|&ratio| of(ratio)).collect()
}
