//! Accuracy of the distance that the program prints.

use std::ops::ControlFlow;

use crate::evaluate::median;
use anyhow::{Context, Result};
use neural_mesh::metrics::{Surface, quick_distance, surface_distance};
use neural_mesh::simplify::{Options, Target, simplify};

use crate::measure::clock::measure_time;
use crate::measure::hausdorff::hausdorff_distance;
use crate::measure::markdown::{count, table};
use crate::measure::meshes::{load, name};
use crate::measure::pages::thread_pool;
use crate::measure::workbench::Bench;

const RATIOS: [f64; 2] = [0.1, 0.5];
const SAMPLES: usize = 8_000;
// Samples per surface of the reference measurement.
const MANY: usize = 300_000;
// A result whose mean distance is below this fraction of the diagonal is skipped as noise.
const NOISE: f64 = 1e-6;

// A printed largest distance of at least this fraction of the certified one counts as correct.
const RIGHT: f64 = 0.97;

// Ratio, deviation of the mean in percent, largest distance over the certified one, nanoseconds per input face.
type CheckCase = (f64, f64, f64, f64);

pub fn section(bench: &Bench) -> Result<String> {
    let mut cases: Vec<CheckCase> = Vec::new();
    for path in bench.meshes("test")? {
        cases.extend(bench.measure_once::<Vec<CheckCase>>(&format!("check/{}", name(&path)), || measure(&path))?);
    }
    let lines: Vec<Vec<String>> = RATIOS.iter().map(|&ratio| line(&cases, ratio)).collect();
    let head = [
        "ratio",
        "meshes",
        "mean: median deviation",
        "worst",
        "largest / certified: median",
        "least",
        "within 3 %",
        "time, ns per face",
    ];
    Ok(format!(
        "## Accuracy of printed distances\n\nThe distance that `simplify` prints comes from {} samples on each surface (`metrics::quick_distance`). It is \
         compared with {} samples on the benchmark meshes, on one thread:\n\n{}",
        count(SAMPLES),
        count(MANY),
        table(&head, &lines)
    ))
}

fn measure(path: &std::path::Path) -> Result<Vec<CheckCase>> {
    let mesh = load(path)?;
    let original = Surface::new(&mesh, MANY, 77);
    let mut cases = Vec::new();
    for ratio in RATIOS {
        let result =
            simplify(&mesh, None, &Options::new(Target::Ratio(ratio)), &mut |_| ControlFlow::Continue(()))?.mesh;
        let many = surface_distance(&original, &Surface::new(&result, MANY, 78)).context("nothing to measure")?;
        let (quick, time) =
            thread_pool(1)?.install(|| measure_time(|| Ok(quick_distance(&mesh, &result, SAMPLES, 0))))?;
        let quick = quick.context("nothing to measure")?;
        if many.both.mean > NOISE * many.diagonal {
            let off = 100.0 * (quick.mean / many.both.mean - 1.0).abs();
            cases.push((
                ratio,
                off,
                quick.max / hausdorff_distance(&mesh, &result)?,
                1e9 * time.thread / mesh.faces().len() as f64,
            ));
        }
    }
    Ok(cases)
}

fn line(cases: &[CheckCase], ratio: f64) -> Vec<String> {
    let of =
        |value: fn(&CheckCase) -> f64| cases.iter().filter(|case| case.0 == ratio).map(value).collect::<Vec<f64>>();
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
