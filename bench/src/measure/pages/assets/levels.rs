//! Levels of detail from one collapse against single runs.

use std::ops::ControlFlow;
use std::path::Path;

use crate::evaluate::median;
use anyhow::{Context, Result};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::simplify::{ClosedOptions, Input, Options, Target, simplify, simplify_levels_of_detail};
use serde::{Deserialize, Serialize};

use super::super::write_csv;
use super::spread_rows;
use crate::measure::clock::measure_time;
use crate::measure::markdown::{count, number, table};
use crate::measure::meshes::{load, name};
use crate::measure::pages::thread_pool;
use crate::measure::workbench::Bench;

const LEVELS: [f64; 4] = [0.5, 0.25, 0.1, 0.05];
const ABOVE: usize = 50_000;
const SAMPLES: usize = 50_000;
const ROUNDS: usize = 3;

#[derive(Serialize, Deserialize)]
struct LevelsCase {
    mesh: String,
    faces: usize,
    seconds: f64,
    time: f64,
    distances: [f64; 4],
}

pub fn section(bench: &Bench) -> Result<String> {
    let mut rows: Vec<LevelsCase> = Vec::new();
    for path in bench.meshes("test")? {
        rows.extend(bench.measure_once::<Option<LevelsCase>>(&format!("levels/{}", name(&path)), || measure(&path))?);
    }
    let line = |row: &LevelsCase| {
        let mut cells =
            vec![row.mesh.clone(), row.faces.to_string(), format!("{:.3}", row.seconds), number(Some(row.time))];
        cells.extend(row.distances.map(|distance| number(Some(distance))));
        cells
    };
    let lines: Vec<Vec<String>> = rows.iter().map(line).collect();
    let mut head: Vec<String> = ["mesh", "faces", "four runs, s", "time"].map(String::from).into();
    head.extend(LEVELS.map(|ratio| format!("mean distance at {ratio}")));
    let link = write_csv("assets-levels", &head, &lines)?;
    let mut columns = vec![rows.iter().map(|row| row.time).collect()];
    columns.extend((0..LEVELS.len()).map(|at| rows.iter().map(|row| row.distances[at]).collect()));
    head.drain(1..3);
    head[0].clear();
    Ok(format!(
        "## Levels of detail\n\nQuotients of `--lods 0.5,0.25,0.1,0.05`, which makes all levels in one collapse, over four runs with \
         `--ratio`; below 1 is better. {} meshes above {} faces, one thread, in turns, medians of {ROUNDS} rounds. Each mesh: {link}.\n\n{}",
        rows.len(),
        count(ABOVE),
        table(&head, &spread_rows(&columns))
    ))
}

fn measure(path: &Path) -> Result<Option<LevelsCase>> {
    let mesh = load(path)?;
    if mesh.faces().len() <= ABOVE {
        return Ok(None);
    }
    let one = thread_pool(1)?;
    let (mut alone, mut quotients) = (Vec::new(), Vec::new());
    let (mut chain, mut single) = (Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let (levels, together) = one.install(|| measure_time(|| simplify_levels(&mesh)))?;
        let (results, apart) = one.install(|| measure_time(|| simplify_each(&mesh)))?;
        quotients.push(together.thread / apart.thread);
        alone.push(apart.thread);
        (chain, single) = (levels, results);
    }
    let original = Surface::new(&mesh, SAMPLES, 0);
    let distance = |simplified: &TriMesh| {
        surface_distance(&original, &Surface::new(simplified, SAMPLES, 1))
            .map(|found| found.both.mean)
            .context("no faces")
    };
    let mut distances = [0.0; 4];
    for (at, quotient) in distances.iter_mut().enumerate() {
        *quotient = distance(&chain[at])? / distance(&single[at])?;
    }
    let [seconds, time] = [alone, quotients].map(|values| median(values).unwrap_or_default());
    Ok(Some(LevelsCase { mesh: name(path), faces: mesh.faces().len(), seconds, time, distances }))
}

fn simplify_levels(mesh: &TriMesh) -> Result<Vec<TriMesh>> {
    let (input, options, targets) = (Input::bare(mesh), ClosedOptions::default(), LEVELS.map(Target::Ratio));
    let levels = simplify_levels_of_detail(input, None, &options, &targets, &mut |_| ControlFlow::Continue(()))?;
    Ok(levels.into_iter().map(|level| level.mesh).collect())
}

fn simplify_each(mesh: &TriMesh) -> Result<Vec<TriMesh>> {
    let run = |ratio| simplify(mesh, None, &Options::new(Target::Ratio(ratio)), &mut |_| ControlFlow::Continue(()));
    LEVELS.map(run).into_iter().map(|result| Ok(result?.mesh)).collect()
}
