//! What the scores and the parts of the closed assembly are worth: others in their place, one left out at a time.

mod shuffled;

use std::path::Path;

use crate::evaluate::{Row, Table};
use anyhow::{Context, Result};
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::model::Weights;
use neural_mesh::simplify::{Importance, Parts, simplify_weighed};
use serde::{Deserialize, Serialize};

use super::RATIOS;
use crate::measure::clock::timed;
use crate::measure::largest::largest;
use crate::measure::markdown::{number, table};
use crate::measure::meshes::{load, name};
use crate::measure::quotients::{Figure, Quotients};
use crate::measure::workbench::Bench;

/// The row that the others stand over.
const WHOLE: &str = "whole";
/// Samples on each surface.
const SAMPLES: usize = 50_000;
/// The figures, as `evaluate` names them.
const FIGURES: [&str; 3] = ["distance_mean", "distance_max", "normal_error_signed"];

const SCORES: [(&str, &str); 3] =
    [("even", "no scores"), ("network", "scores of the network"), ("shuffled", "shuffled weights")];
const LEFT_OUT: [(&str, &str); 2] = [("flips", "without flips"), ("fit", "without fit")];

/// One result.
#[derive(Serialize, Deserialize)]
struct Measured {
    method: String,
    ratio: f64,
    seconds: f64,
    figures: [f64; 3],
}

pub fn page(bench: &Bench) -> Result<String> {
    let mut rows = Vec::new();
    for path in bench.meshes("test")? {
        let measured = bench.kept(&format!("parts/{}", name(&path)), || of_mesh(&path))?;
        rows.extend(measured.into_iter().map(|measured| row(&name(&path), measured)));
    }
    let n_meshes = rows.iter().filter(|row| row.method == WHOLE).count() / RATIOS.len();
    let rows = Table { figures: FIGURES.map(String::from).into(), rows };
    let quotients = Quotients { table: &rows, over: WHOLE };
    Ok(format!(
        "{n_meshes} benchmark meshes, each ratio, one seed. Cells are medians over the meshes of quotients to the whole assembly: \
         above 1 is worse. Figures as on [the benchmark's page](benchmark.md), from 50,000 samples; time is the \
         processor's on one thread.\n\n## Scores\n\n\
         A formula says how much each vertex counts. In its place: nothing (`--scores geometry`), the network that ships \
         (`--scores network`), and its own weights in random order, which look alike and know nothing.\n\n{}\n\
         ## Parts\n\n*Flips* turn edges whose other diagonal lies nearer. *Fit* moves vertices toward the surface.\n\n{}",
        tables(&quotients, &SCORES),
        tables(&quotients, &LEFT_OUT)
    ))
}

fn row(mesh: &str, Measured { method, ratio, seconds, figures }: Measured) -> Row {
    let figures = figures.map(Some).into();
    Row { mesh: mesh.into(), ratio, method, seconds: Some(seconds), figures, ..Row::default() }
}

fn of_mesh(path: &Path) -> Result<Vec<Measured>> {
    let mesh = load(path)?;
    let weights = Weights::shipped_default();
    let shuffled = shuffled::shuffled(weights, 0)?;
    let all = Parts::default();
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
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let mut measured = Vec::new();
    for ratio in RATIOS {
        let n = ((mesh.positions().len() as f64 * ratio) as usize).max(1);
        for (method, importance, parts) in cases {
            let simplify = || Ok(simplify_weighed(&mesh, n, importance, &parts)?.mesh);
            let (lighter, time) = one.install(|| timed(simplify)).with_context(|| format!("{method} at {ratio}"))?;
            let distance = surface_distance(&original, &Surface::new(&lighter, SAMPLES, 1)).context("no faces")?;
            let (both, share) = (distance.both, 100.0 / distance.diagonal);
            let figures = [both.mean * share, largest(&mesh, &lighter)? * share, both.normal_error];
            measured.push(Measured { method: method.into(), ratio, seconds: time.thread, figures });
        }
    }
    Ok(measured)
}

/// A row per case and figure, a column per ratio.
fn tables(quotients: &Quotients, cases: &[(&str, &str)]) -> String {
    let mut head: Vec<String> = ["over the whole", "figure"].map(String::from).into();
    head.extend(RATIOS.map(|ratio| ratio.to_string()));
    head.extend(["all", "worst mesh"].map(String::from));
    let line = |&(method, about): &(&str, &str), figure: Figure| {
        let of = |ratios: &[f64]| number(quotients.median(method, figure, ratios));
        let worst = quotients.worst(method, figure, &RATIOS);
        let worst = worst.map_or("-".into(), |worst| format!("{} {}", worst.mesh, number(Some(worst.quotient))));
        let mut cells = vec![about.to_owned(), figure.title().to_owned()];
        cells.extend(RATIOS.map(|ratio| of(&[ratio])));
        cells.extend([of(&RATIOS), worst]);
        cells
    };
    let lines: Vec<_> = cases.iter().flat_map(|case| Figure::ALL.map(|figure| line(case, figure))).collect();
    table(&head, &lines)
}
