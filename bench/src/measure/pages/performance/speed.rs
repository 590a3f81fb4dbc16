//! Simplification against meshoptimizer's `simplify` on large benchmark meshes, and where its time goes.

use std::ops::ControlFlow;

use crate::baselines::meshoptimizer_faces;
use crate::evaluate::median;
use anyhow::Result;
use neural_mesh::mesh::TriMesh;
use neural_mesh::simplify::{Options, ScoreSource, Target, simplify};
use serde::{Deserialize, Serialize};

use super::super::RATIOS;
use super::threads;
use crate::measure::clock::{spread, thread_time, timed};
use crate::measure::markdown::{count, number, table};
use crate::measure::meshes::{load, name};
use crate::measure::workbench::Bench;

/// Faces that a mesh must have more than.
const ABOVE: usize = 50_000;
/// Rounds; in each, everyone has a turn.
const ROUNDS: usize = 3;

/// One mesh at one size: medians over the rounds.
#[derive(Serialize, Deserialize)]
struct Case {
    mesh: String,
    faces: usize,
    ratio: f64,
    /// Seconds of meshoptimizer.
    theirs: f64,
    /// Quotients to meshoptimizer in the same round: the default on one thread, without a network, the default on two threads.
    quotients: [f64; 3],
    /// Seconds of each stage on one thread, in their order.
    stages: Vec<(String, f64)>,
}

pub fn section(bench: &Bench) -> Result<String> {
    let mut cases = Vec::new();
    for path in bench.meshes("test")? {
        cases.extend(bench.kept(&format!("speed/{}", name(&path)), || measured(&path))?);
    }
    Ok(format!("{}\n{}", against(&cases), by_stage(&cases)))
}

fn measured(path: &std::path::Path) -> Result<Vec<Case>> {
    let mesh = load(path)?;
    if mesh.faces().len() <= ABOVE {
        return Ok(Vec::new());
    }
    RATIOS.iter().map(|&ratio| case(&name(path), &mesh, ratio)).collect()
}

fn case(name: &str, mesh: &TriMesh, ratio: f64) -> Result<Case> {
    let n_left = (ratio * mesh.faces().len() as f64).round() as usize;
    let options = Options::new(Target::Faces(n_left));
    let mut geometry = options.clone();
    geometry.scores = ScoreSource::Geometry;
    let [one, two] = [threads(1)?, threads(2)?];
    let (mut theirs, mut quotients) = (Vec::new(), [const { Vec::new() }; 3]);
    let mut stages: Vec<Vec<(String, f64)>> = Vec::new();
    for _ in 0..ROUNDS {
        let their = timed(|| Ok(meshoptimizer_faces(mesh, n_left)))?.1;
        let (found, ours) = one.install(|| timed(|| ours(mesh, &options)))?;
        let even = one.install(|| timed(|| self::ours(mesh, &geometry)))?.1;
        let shared = two.install(|| timed(|| self::ours(mesh, &options)))?.1;
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
    Ok(Case {
        mesh: name.into(),
        faces: mesh.faces().len(),
        ratio,
        theirs: middle(theirs),
        quotients: quotients.map(middle),
        stages: (0..stages[0].len()).map(stage).collect(),
    })
}

/// Simplifies; seconds of the processor by stage, by the thread that is asked.
fn ours(mesh: &TriMesh, options: &Options) -> Result<Vec<(String, f64)>> {
    let mut entered = vec![("beginning", thread_time())];
    simplify(mesh, None, options, &mut |event| {
        entered.push((event.stage, thread_time()));
        ControlFlow::Continue(())
    })?;
    entered.push(("end", thread_time()));
    let mut stages: Vec<(String, f64)> = Vec::new();
    for pair in entered.windows(2) {
        // On several threads either may tell, each by a clock of its own.
        let seconds = pair[1].1.saturating_sub(pair[0].1).as_secs_f64();
        // A stage is heard of again and again while it goes on.
        match stages.iter_mut().find(|stage| stage.0 == pair[0].0) {
            Some(stage) => stage.1 += seconds,
            None => stages.push((pair[0].0.into(), seconds)),
        }
    }
    Ok(stages)
}

fn against(cases: &[Case]) -> String {
    let mut meshes: Vec<&str> = cases.iter().map(|case| case.mesh.as_str()).collect();
    meshes.dedup();
    let of = |ratios: &[f64], at: usize| {
        let of_ratios = cases.iter().filter(|case| ratios.contains(&case.ratio));
        spread(&of_ratios.map(|case| case.quotients[at]).collect::<Vec<_>>())
    };
    let line = |name: String, ratios: &[f64]| {
        [name].into_iter().chain([0, 1, 2].map(|at| of(ratios, at))).collect::<Vec<String>>()
    };
    let mut lines: Vec<Vec<String>> = RATIOS.iter().map(|&ratio| line(ratio.to_string(), &[ratio])).collect();
    lines.push(line("all".into(), &RATIOS));
    let head = ["ratio", "one thread", "one thread, `--scores geometry`", "two threads"];
    format!(
        "## Against meshoptimizer\n\nThe {} benchmark meshes above {} faces: time over that of meshoptimizer's `simplify`, which uses \
         one thread, at the same number of faces; median (least to largest) of medians of {ROUNDS} rounds.\n\n{}",
        meshes.len(),
        count(ABOVE),
        table(&head, &lines)
    )
}

/// Medians over the meshes.
fn by_stage(cases: &[Case]) -> String {
    let mut stages: Vec<&str> = Vec::new();
    for (stage, _) in cases.iter().flat_map(|case| &case.stages) {
        if !stages.contains(&stage.as_str()) {
            stages.push(stage);
        }
    }
    let middle = |ratio: f64, of: &dyn Fn(&Case) -> f64| {
        let of_ratio = cases.iter().filter(|case| case.ratio == ratio);
        number(median(of_ratio.map(|case| 1e9 * of(case) / case.faces as f64).collect()))
    };
    let seconds = |case: &Case, stage: &str| {
        case.stages.iter().filter(|found| found.0 == stage).map(|found| found.1).sum::<f64>()
    };
    let line = |name: &str, of: &dyn Fn(&Case) -> f64| {
        [name.to_owned()].into_iter().chain(RATIOS.map(|ratio| middle(ratio, of))).collect::<Vec<String>>()
    };
    let mut lines: Vec<Vec<String>> = stages.iter().map(|stage| line(stage, &|case| seconds(case, stage))).collect();
    lines.push(line("all", &|case| case.stages.iter().map(|stage| stage.1).sum()));
    lines.push(line("meshoptimizer's `simplify`", &|case| case.theirs));
    let mut head = vec!["stage".to_owned()];
    head.extend(RATIOS.map(|ratio| ratio.to_string()));
    format!("## By stage\n\nNanoseconds on one thread, the same meshes, medians.\n\n{}", table(&head, &lines))
}
