//! Time against meshoptimizer's `simplify`, and by stage.

use std::ops::ControlFlow;

use crate::baselines::meshoptimizer_faces;
use crate::evaluate::median;
use anyhow::Result;
use neural_mesh::mesh::TriMesh;
use neural_mesh::simplify::{ClosedOptions, Options, ScoreSource, Target, simplify};
use serde::{Deserialize, Serialize};

use super::super::RATIOS;
use crate::evaluate::thread_time;
use crate::measure::clock::{format_spread, measure_time};
use crate::measure::markdown::{count, number, table};
use crate::measure::meshes::{load, name};
use crate::measure::pages::thread_pool;
use crate::measure::workbench::Bench;

const ABOVE: usize = 50_000;
const ROUNDS: usize = 3;

#[derive(Serialize, Deserialize)]
struct SpeedCase {
    mesh: String,
    faces: usize,
    ratio: f64,
    theirs: f64,
    // Times divided by meshoptimizer's: the default on one thread, without scores on one thread, the default on two.
    quotients: [f64; 3],
    stages: Vec<(String, f64)>,
}

pub fn section(bench: &Bench) -> Result<String> {
    let mut cases = Vec::new();
    for path in bench.meshes("test")? {
        cases.extend(bench.measure_once(&format!("speed/{}", name(&path)), || measure(&path))?);
    }
    Ok(format!("{}\n{}", table_by_ratio(&cases), table_by_stage(&cases)))
}

fn measure(path: &std::path::Path) -> Result<Vec<SpeedCase>> {
    let mesh = load(path)?;
    if mesh.faces().len() <= ABOVE {
        return Ok(Vec::new());
    }
    RATIOS.iter().map(|&ratio| measure_case(&name(path), &mesh, ratio)).collect()
}

fn measure_case(name: &str, mesh: &TriMesh, ratio: f64) -> Result<SpeedCase> {
    let n_left = (ratio * mesh.faces().len() as f64).round() as usize;
    let options = Options::new(Target::Faces(n_left));
    let geometry = ClosedOptions { scores: ScoreSource::Geometry, ..ClosedOptions::default() };
    let geometry = Options::with_closed(options.target, geometry);
    let [one, two] = [thread_pool(1)?, thread_pool(2)?];
    let (mut theirs, mut quotients) = (Vec::new(), [const { Vec::new() }; 3]);
    let mut stages: Vec<Vec<(String, f64)>> = Vec::new();
    for _ in 0..ROUNDS {
        let their = measure_time(|| Ok(meshoptimizer_faces(mesh, n_left)))?.1;
        let (found, ours) = one.install(|| measure_time(|| stage_times(mesh, &options)))?;
        let even = one.install(|| measure_time(|| stage_times(mesh, &geometry)))?.1;
        let shared = two.install(|| measure_time(|| stage_times(mesh, &options)))?.1;
        theirs.push(their.thread);
        quotients[0].push(ours.thread / their.thread);
        quotients[1].push(even.thread / their.thread);
        quotients[2].push(shared.wall / their.wall);
        stages.push(found);
    }
    let middle = |values: Vec<f64>| median(values).unwrap_or_default();
    let stage = |at: usize| {
        let seconds = stages.iter().filter_map(|run| run.get(at)).map(|stage| stage.1);
        (stages[0][at].0.clone(), middle(seconds.collect()))
    };
    Ok(SpeedCase {
        mesh: name.into(),
        faces: mesh.faces().len(),
        ratio,
        theirs: middle(theirs),
        quotients: quotients.map(middle),
        stages: (0..stages[0].len()).map(stage).collect(),
    })
}

fn stage_times(mesh: &TriMesh, options: &Options) -> Result<Vec<(String, f64)>> {
    let mut entered = vec![("beginning", thread_time())];
    simplify(mesh, None, options, &mut |event| {
        entered.push((event.stage, thread_time()));
        ControlFlow::Continue(())
    })?;
    entered.push(("end", thread_time()));
    let mut stages: Vec<(String, f64)> = Vec::new();
    for pair in entered.windows(2) {
        // Any thread may report with its own processor time, so a later report can have a smaller time.
        let seconds = pair[1].1.saturating_sub(pair[0].1).as_secs_f64();
        // A stage reports repeatedly while it runs.
        match stages.iter_mut().find(|stage| stage.0 == pair[0].0) {
            Some(stage) => stage.1 += seconds,
            None => stages.push((pair[0].0.into(), seconds)),
        }
    }
    Ok(stages)
}

fn table_by_ratio(cases: &[SpeedCase]) -> String {
    let mut meshes: Vec<&str> = cases.iter().map(|case| case.mesh.as_str()).collect();
    meshes.dedup();
    let of = |ratios: &[f64], at: usize| {
        let of_ratios = cases.iter().filter(|case| ratios.contains(&case.ratio));
        format_spread(&of_ratios.map(|case| case.quotients[at]).collect::<Vec<_>>())
    };
    let line = |name: String, ratios: &[f64]| {
        [name].into_iter().chain([0, 1, 2].map(|at| of(ratios, at))).collect::<Vec<String>>()
    };
    let mut lines: Vec<Vec<String>> = RATIOS.iter().map(|&ratio| line(ratio.to_string(), &[ratio])).collect();
    lines.push(line("all".into(), &RATIOS));
    let head = ["ratio", "one thread", "one thread, `--scores geometry`", "two threads"];
    format!(
        "## Against meshoptimizer\n\nTime divided by that of meshoptimizer's single-threaded `simplify` at the same number of faces, on the {} \
         benchmark meshes above {} faces. Median (least to largest) over the meshes; each is the median of {ROUNDS} rounds.\n\n{}",
        meshes.len(),
        count(ABOVE),
        table(&head, &lines)
    )
}

fn table_by_stage(cases: &[SpeedCase]) -> String {
    let mut stages: Vec<&str> = Vec::new();
    for (stage, _) in cases.iter().flat_map(|case| &case.stages) {
        if !stages.contains(&stage.as_str()) {
            stages.push(stage);
        }
    }
    let middle = |ratio: f64, of: &dyn Fn(&SpeedCase) -> f64| {
        let of_ratio = cases.iter().filter(|case| case.ratio == ratio);
        number(median(of_ratio.map(|case| 1e9 * of(case) / case.faces as f64).collect()))
    };
    let seconds = |case: &SpeedCase, stage: &str| {
        case.stages.iter().filter(|found| found.0 == stage).map(|found| found.1).sum::<f64>()
    };
    let line = |name: &str, of: &dyn Fn(&SpeedCase) -> f64| {
        [name.to_owned()].into_iter().chain(RATIOS.map(|ratio| middle(ratio, of))).collect::<Vec<String>>()
    };
    let mut lines: Vec<Vec<String>> = stages.iter().map(|stage| line(stage, &|case| seconds(case, stage))).collect();
    lines.push(line("all", &|case| case.stages.iter().map(|stage| stage.1).sum()));
    lines.push(line("meshoptimizer's `simplify`", &|case| case.theirs));
    let mut head = vec!["stage".to_owned()];
    head.extend(RATIOS.map(|ratio| ratio.to_string()));
    format!("## By stage\n\nNanoseconds on one thread for the same meshes; medians.\n\n{}", table(&head, &lines))
}
