//! How long the paper's assembly takes, from parsed arrays to finished meshes, in sum over meshes and stage by stage. On
//! one thread the processor's time counts, on several that on the wall.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{RawMesh, TriMesh};
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::simplify::{Assembly, Options, Target, simplify};
use nix::time::ClockId;

use crate::load::{load, load_raw};

#[derive(clap::Args)]
pub struct Args {
    /// Mesh files.
    meshes: Vec<PathBuf>,
    /// Shares of the faces that stay.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.1,0.2,0.5")]
    ratios: Vec<f64>,
    /// Times each mesh is simplified; the fastest counts.
    #[arg(long, default_value_t = 3)]
    repeat: usize,
    /// Threads.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Surface samples per side for the distance; none is measured with 0.
    #[arg(long, default_value_t = 0)]
    samples: usize,
}

/// Seconds by stage, in the order in which they come.
type Stages = Vec<(&'static str, f64)>;

/// Prints one line per ratio.
pub fn paper_speed(args: &Args) -> Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads).build()?;
    for &ratio in &args.ratios {
        let mut sums: BTreeMap<usize, (&'static str, f64)> = BTreeMap::new();
        let (mut n_faces, mut distances) = (0, Vec::new());
        for path in &args.meshes {
            let raw = load_raw(path)?;
            let (mesh, stages) = pool.install(|| fastest(&raw, ratio, args))?;
            stages.iter().enumerate().for_each(|(i, stage)| sums.entry(i).or_insert((stage.0, 0.0)).1 += stage.1);
            n_faces += mesh.faces().len();
            if args.samples > 0 {
                distances.push(distance(&load(path)?, &mesh, args.samples));
            }
        }
        let stages: Vec<String> = sums.values().map(|(stage, seconds)| format!("{stage} {seconds:.2}")).collect();
        let seconds: f64 = sums.values().map(|stage| stage.1).sum();
        let mean = distances.iter().sum::<f64>() / distances.len().max(1) as f64;
        let distance = if distances.is_empty() { String::new() } else { format!(", mean distance {mean:.4e}") };
        println!("{ratio:.2}: {seconds:.2} s, {n_faces} faces{distance}: {}", stages.join(", "));
    }
    Ok(())
}

/// The fastest of the runs.
fn fastest(raw: &RawMesh, ratio: f64, args: &Args) -> Result<(TriMesh, Stages)> {
    let seconds = |stages: &Stages| stages.iter().map(|stage| stage.1).sum::<f64>();
    let runs = (0..args.repeat.max(1)).map(|_| run(raw.clone(), ratio, args.threads));
    let runs = runs.collect::<Result<Vec<_>>>()?;
    let fastest = runs.into_iter().min_by(|a, b| seconds(&a.1).total_cmp(&seconds(&b.1)));
    Ok(fastest.unwrap_or_default())
}

fn run(raw: RawMesh, ratio: f64, n_threads: usize) -> Result<(TriMesh, Stages)> {
    let clock = if n_threads == 1 { ClockId::CLOCK_THREAD_CPUTIME_ID } else { ClockId::CLOCK_MONOTONIC };
    let now = || clock.now().map_or(Duration::ZERO, Duration::from);
    let mut entered = vec![("cleanup", now())];
    let cleaned = clean(raw, &CleanOptions::default())?;
    let options = Options { assembly: Assembly::Paper, frame: cleaned.frame, ..Options::new(Target::Ratio(ratio)) };
    let simplified = simplify(&cleaned.mesh, None, &options, &mut |event| {
        entered.push((event.stage, now()));
        ControlFlow::Continue(())
    })?;
    entered.push(("end", now()));
    let stages = entered.windows(2).map(|pair| (pair[0].0, (pair[1].1 - pair[0].1).as_secs_f64()));
    Ok((simplified.mesh, stages.collect()))
}

/// Mean two-sided distance in units of the original's mesh.
fn distance(original: &TriMesh, simplified: &TriMesh, samples: usize) -> f64 {
    let [original, simplified] = [(original, 0), (simplified, 1)].map(|(mesh, seed)| Surface::new(mesh, samples, seed));
    surface_distance(&original, &simplified).unwrap_or_default().both.mean
}
