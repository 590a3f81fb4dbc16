//! How right the distance is that the program prints.

use std::ops::ControlFlow;

use crate::evaluate::median;
use anyhow::{Context, Result};
use neural_mesh::metrics::{Surface, quick_distance, surface_distance};
use neural_mesh::simplify::{Options, Target, simplify};

use super::threads;
use crate::measure::clock::timed;
use crate::measure::largest::largest;
use crate::measure::markdown::{count, table};
use crate::measure::meshes::{load, name};
use crate::measure::workbench::Bench;

const RATIOS: [f64; 2] = [0.1, 0.5];
/// Samples that the program takes on each surface, and those that it is held against.
const SAMPLES: usize = 8_000;
const MANY: usize = 300_000;
/// A mean below this share of the diagonal is noise.
const NOISE: f64 = 1e-6;

/// A largest distance is right that is at most this share below the certified one.
const RIGHT: f64 = 0.97;

/// Ratio, deviation of the mean in percent, largest distance over the certified one, nanoseconds per face of the original.
type Case = (f64, f64, f64, f64);

pub fn section(bench: &Bench) -> Result<String> {
    let mut cases: Vec<Case> = Vec::new();
    for path in bench.meshes("test")? {
        cases.extend(bench.kept::<Vec<Case>>(&format!("check/{}", name(&path)), || measured(&path))?);
    }
    let lines: Vec<Vec<String>> = RATIOS.iter().map(|&ratio| line(&cases, ratio)).collect();
    let head = [
        "ratio",
        "meshes",
        "mean: deviation, median",
        "worst",
        "largest over the certified: median",
        "least",
        "within 3 %",
        "time, ns per face",
    ];
    Ok(format!(
        "## The check\n\nThe distance that `simplify` prints comes from {} samples on each surface (`metrics::quick_distance`). Against \
         {} samples, the benchmark meshes, one thread:\n\n{}",
        count(SAMPLES),
        count(MANY),
        table(&head, &lines)
    ))
}

fn measured(path: &std::path::Path) -> Result<Vec<Case>> {
    let mesh = load(path)?;
    let original = Surface::new(&mesh, MANY, 77);
    let mut cases = Vec::new();
    for ratio in RATIOS {
        let result =
            simplify(&mesh, None, &Options::new(Target::Ratio(ratio)), &mut |_| ControlFlow::Continue(()))?.mesh;
        let many = surface_distance(&original, &Surface::new(&result, MANY, 78)).context("nothing to measure")?;
        let (quick, time) = threads(1)?.install(|| timed(|| Ok(quick_distance(&mesh, &result, SAMPLES, 0))))?;
        let quick = quick.context("nothing to measure")?;
        if many.both.mean > NOISE * many.diagonal {
            let off = 100.0 * (quick.mean / many.both.mean - 1.0).abs();
            cases.push((
                ratio,
                off,
                quick.max / largest(&mesh, &result)?,
                1e9 * time.thread / mesh.faces().len() as f64,
            ));
        }
    }
    Ok(cases)
}

fn line(cases: &[Case], ratio: f64) -> Vec<String> {
    let of = |value: fn(&Case) -> f64| cases.iter().filter(|case| case.0 == ratio).map(value).collect::<Vec<f64>>();
    let (mean, shares, time) = (of(|case| case.1), of(|case| case.2), of(|case| case.3));
    let middle = |values: &[f64]| median(values.to_vec()).unwrap_or_default();
    vec![
        ratio.to_string(),
        mean.len().to_string(),
        format!("{:.2} %", middle(&mean)),
        format!("{:.1} %", mean.iter().copied().fold(0.0, f64::max)),
        format!("{:.2}", middle(&shares)),
        format!("{:.2}", shares.iter().copied().fold(f64::INFINITY, f64::min)),
        format!("{} of {}", shares.iter().filter(|&&share| share >= RIGHT).count(), shares.len()),
        format!("{:.0}", middle(&time)),
    ]
}
