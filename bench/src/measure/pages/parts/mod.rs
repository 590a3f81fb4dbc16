//! Effects of scores and stages of the closed assembly.

mod shuffled;

use std::path::Path;

use crate::evaluate::{ResultRow, Table};
use anyhow::{Context, Result};
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::model::Weights;
use neural_mesh::simplify::{Importance, Refinements, simplify_with_importance};
use serde::{Deserialize, Serialize};

use super::{RATIOS, write_csv};
use crate::measure::clock::measure_time;
use crate::measure::hausdorff::hausdorff_distance;
use crate::measure::markdown::{number, table};
use crate::measure::meshes::{load, name};
use crate::measure::pages::thread_pool;
use crate::measure::quotients::{Figure, Quotients};
use crate::measure::workbench::Bench;

// Name of the full assembly; figures of the others are divided by its figures.
const WHOLE: &str = "whole";
const SAMPLES: usize = 50_000;
const FIGURES: [&str; 3] = ["distance_mean", "distance_max", "normal_error_signed"];

const SCORES: [(&str, &str); 3] =
    [("even", "no scores"), ("network", "network scores"), ("shuffled", "shuffled weights")];
const LEFT_OUT: [(&str, &str); 2] = [("flips", "without flips"), ("fit", "without fit")];

#[derive(Serialize, Deserialize)]
struct AblationResult {
    method: String,
    ratio: f64,
    seconds: f64,
    figures: [f64; 3],
}

pub fn sections(bench: &Bench) -> Result<String> {
    let mut rows = Vec::new();
    for path in bench.meshes("test")? {
        let measured = bench.measure_once(&format!("parts/{}", name(&path)), || measure(&path))?;
        rows.extend(measured.into_iter().map(|measured| row(&name(&path), measured)));
    }
    let n_meshes = rows.iter().filter(|row| row.method == WHOLE).count() / RATIOS.len();
    let rows = Table { figures: FIGURES.map(String::from).into(), rows };
    let quotients = Quotients { table: &rows, over: WHOLE };
    let link = write_csv("weights-scores", &csv_head(), &csv_rows(&quotients))?;
    Ok(format!(
        "{n_meshes} benchmark meshes at every ratio, one seed. Cells are medians of quotients over the full assembly; above 1 is \
         worse. Figures are those of [the benchmark](benchmark.md); time is processor time on one thread. Each ratio: {link}.\n\n\
         ## Scores\n\n\
         By default a formula determines the importance of each vertex. Here uniform importance (`--scores \
         geometry`), the shipped network (`--scores network`) and the same network with shuffled weights replace \
         the formula.\n\n{}\n\
         ## Stages left out\n\n*Flips* replace edges by the other diagonal if that is closer to the original. *Fit* moves \
         vertices toward the surface.\n\n{}",
        format_table(&quotients, &SCORES),
        format_table(&quotients, &LEFT_OUT)
    ))
}

fn row(mesh: &str, AblationResult { method, ratio, seconds, figures }: AblationResult) -> ResultRow {
    let figures = figures.map(Some).into();
    ResultRow { mesh: mesh.into(), ratio, method, seconds: Some(seconds), figures, ..ResultRow::default() }
}

fn measure(path: &Path) -> Result<Vec<AblationResult>> {
    let mesh = load(path)?;
    let weights = Weights::shipped_default();
    let shuffled = shuffled::shuffle_weights(weights, 0)?;
    let all = Refinements::default();
    let [mut unflipped, mut unfitted] = [all; 2];
    (unflipped.flips, unfitted.fit) = (false, false);
    let cases = [
        (WHOLE, Importance::Bending, all),
        ("even", Importance::Even, all),
        ("network", Importance::Network(weights), all),
        ("shuffled", Importance::Network(&shuffled), all),
        ("flips", Importance::Bending, unflipped),
        ("fit", Importance::Bending, unfitted),
    ];
    let original = Surface::new(&mesh, SAMPLES, 0);
    let one = thread_pool(1)?;
    let mut measured = Vec::new();
    for ratio in RATIOS {
        let n = ((mesh.positions().len() as f64 * ratio) as usize).max(1);
        for (method, importance, parts) in cases {
            let simplify = || Ok(simplify_with_importance(&mesh, n, importance, &parts)?.mesh);
            let (simplified, time) =
                one.install(|| measure_time(simplify)).with_context(|| format!("{method} at {ratio}"))?;
            let distance = surface_distance(&original, &Surface::new(&simplified, SAMPLES, 1)).context("no faces")?;
            let (both, share) = (distance.both, 100.0 / distance.diagonal);
            let figures = [both.mean * share, hausdorff_distance(&mesh, &simplified)? * share, both.normal_error];
            measured.push(AblationResult { method: method.into(), ratio, seconds: time.thread, figures });
        }
    }
    Ok(measured)
}

fn format_table(quotients: &Quotients, cases: &[(&str, &str)]) -> String {
    let mut head = vec!["over the full assembly".to_owned()];
    Figure::ALL.iter().for_each(|figure| head.extend([figure.title().to_owned(), "worst mesh".into()]));
    let line = |&(method, about): &(&str, &str)| {
        let cells = Figure::ALL.iter().flat_map(|&figure| {
            let [mesh, worst] = worst_mesh(quotients, method, figure);
            [number(quotients.median(method, figure, &RATIOS)), format!("{mesh} {worst}")]
        });
        [about.to_owned()].into_iter().chain(cells).collect()
    };
    table(&head, &cases.iter().map(line).collect::<Vec<_>>())
}

fn worst_mesh(quotients: &Quotients, method: &str, figure: Figure) -> [String; 2] {
    let worst = quotients.worst(method, figure, &RATIOS);
    worst.map_or(["-".into(), "-".into()], |worst| [worst.mesh, number(Some(worst.quotient))])
}

fn csv_head() -> Vec<String> {
    let mut head: Vec<String> = ["over the full assembly", "figure"].map(String::from).into();
    head.extend(RATIOS.map(|ratio| ratio.to_string()));
    head.extend(["all", "worst mesh", "worst"].map(String::from));
    head
}

fn csv_rows(quotients: &Quotients) -> Vec<Vec<String>> {
    let line = |&(method, about): &(&str, &str), figure: Figure| {
        let of = |ratios: &[f64]| number(quotients.median(method, figure, ratios));
        let mut cells = vec![about.to_owned(), figure.title().to_owned()];
        cells.extend(RATIOS.map(|ratio| of(&[ratio])));
        cells.push(of(&RATIOS));
        cells.extend(worst_mesh(quotients, method, figure));
        cells
    };
    SCORES.iter().chain(&LEFT_OUT).flat_map(|case| Figure::ALL.map(|figure| line(case, figure))).collect()
}
