//! How far the distance that the program says is from that of many samples, and how long it takes; on one thread.

use std::ops::ControlFlow;
use std::path::PathBuf;

use anyhow::{Context, Result};
use neural_mesh::metrics::{Surface, quick_distance, surface_distance};
use neural_mesh::simplify::{Options, Target, simplify};

use crate::load::{load, name};
use crate::speed::contestant::timed;

/// A mean below this share of the diagonal is rounding: what is flat stays where it was.
const NOTHING: f64 = 1e-6;

#[derive(clap::Args)]
pub struct Args {
    /// Mesh files.
    #[arg(required = true)]
    meshes: Vec<PathBuf>,
    /// Shares of the vertices that stay.
    #[arg(long, value_delimiter = ',', default_value = "0.1,0.5")]
    ratios: Vec<f64>,
    /// Samples of the check on each surface.
    #[arg(long, default_value_t = 8000)]
    samples: usize,
    /// Samples on each surface that it is held against.
    #[arg(long, default_value_t = 300_000)]
    many: usize,
    /// Prints a row per mesh, too.
    #[arg(long)]
    rows: bool,
}

/// One result.
struct Case {
    mesh: String,
    /// Deviation of the mean, in percent.
    mean: f64,
    /// The largest distance over that of many samples.
    largest: f64,
    /// Nanoseconds per face of the original.
    time: f64,
}

/// Prints a row per ratio.
pub fn check(args: &Args) -> Result<()> {
    println!("{} samples on each surface against {}.\n", args.samples, args.many);
    println!(
        "| ratio | meshes | mean, root of mean square, % | median | nine tenths | worst | above 1 % | largest, least | median | below 0.97 | ns per face |\n|---|---|---|---|---|---|---|---|---|---|---|"
    );
    for &ratio in &args.ratios {
        let mut cases = Vec::new();
        for path in &args.meshes {
            cases.extend(case(args, path, ratio).with_context(|| path.display().to_string())?);
        }
        if args.rows {
            cases.iter().for_each(|case| {
                println!(
                    "| {ratio} | {} | {:.3} | | | | | {:.3} | | | {:.0} |",
                    case.mesh, case.mean, case.largest, case.time
                );
            });
        }
        if !cases.is_empty() {
            println!("{}", row(ratio, &cases));
        }
    }
    Ok(())
}

fn case(args: &Args, path: &std::path::Path, ratio: f64) -> Result<Option<Case>> {
    let mesh = load(path)?;
    let result = simplify(&mesh, None, &Options::new(Target::Ratio(ratio)), &mut |_| ControlFlow::Continue(()))?.mesh;
    let many = surface_distance(&Surface::new(&mesh, args.many, 77), &Surface::new(&result, args.many, 78));
    let many = many.context("nothing to measure")?;
    if many.both.mean < NOTHING * many.diagonal {
        return Ok(None);
    }
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let (quick, time) = one.install(|| timed(|| Ok(quick_distance(&mesh, &result, args.samples, 0))))?;
    let quick = quick.context("nothing to measure")?;
    Ok(Some(Case {
        mesh: name(path),
        mean: 100.0 * (quick.mean / many.both.mean - 1.0).abs(),
        largest: quick.max / many.both.max,
        time: 1e9 * time.thread / mesh.faces().len() as f64,
    }))
}

fn row(ratio: f64, cases: &[Case]) -> String {
    let sorted = |value: fn(&Case) -> f64| {
        let mut values: Vec<f64> = cases.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let (mean, largest, time) = (sorted(|case| case.mean), sorted(|case| case.largest), sorted(|case| case.time));
    let n = cases.len();
    let square = (mean.iter().map(|x| x * x).sum::<f64>() / n as f64).sqrt();
    format!(
        "| {ratio} | {n} | {square:.2} | {:.2} | {:.2} | {:.1} | {} | {:.2} | {:.3} | {} | {:.0} |",
        mean[n / 2],
        mean[n * 9 / 10],
        mean[n - 1],
        mean.iter().filter(|x| **x > 1.0).count(),
        largest[0],
        largest[n / 2],
        largest.iter().filter(|x| **x < 0.97).count(),
        time[n / 2]
    )
}
