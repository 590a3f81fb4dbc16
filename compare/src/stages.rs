//! The budget of a simplification: nanoseconds per input face by stage, beside meshoptimizer's. On one thread the
//! processor's time counts, on several that on the wall.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{Surface, surface_distance};
use neural_mesh::simplify::{Options, Target, simplify};
use nix::time::ClockId;

use crate::load::{load, name};
use crate::methods::{Scores, meshoptimizer};

#[derive(clap::Args)]
pub struct Args {
    /// Mesh files.
    meshes: Vec<PathBuf>,
    /// Shares of the vertices that stay.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.1,0.2,0.5")]
    ratios: Vec<f64>,
    /// Times each simplification is run; the fastest counts.
    #[arg(long, default_value_t = 3)]
    repeat: usize,
    /// Threads.
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// Where the scores come from.
    #[arg(long, value_enum, default_value_t)]
    scores: Scores,
    /// Surface samples per side for distance and normal error; none are measured with 0.
    #[arg(long, default_value_t = 0)]
    samples: usize,
}

/// Prints one line per mesh and ratio.
pub fn stages(args: &Args) -> Result<()> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads).build()?;
    let mut quotients: Vec<(f64, [f64; 4])> = Vec::new();
    for path in &args.meshes {
        let mesh = load(path)?;
        let original = (args.samples > 0).then(|| Surface::new(&mesh, args.samples, 0));
        for &ratio in &args.ratios {
            let case = pool.install(|| run(&mesh, ratio, args))?;
            println!("{:20} {ratio:.2} {}", name(path), case.line(mesh.faces().len()));
            let errors = original.as_ref().map_or([f64::NAN; 3], |original| errors(original, &case, args.samples));
            let [distance, normals, largest] = errors;
            quotients.push((ratio, [case.total() / case.meshoptimizer, distance, normals, largest]));
        }
    }
    for &ratio in &args.ratios {
        let of_ratio: Vec<[f64; 4]> = quotients.iter().filter(|(r, _)| *r == ratio).map(|(_, q)| *q).collect();
        println!("over meshoptimizer at {ratio:.2}: {}", summary(&of_ratio));
    }
    let all: Vec<[f64; 4]> = quotients.into_iter().map(|(_, q)| q).collect();
    println!("over meshoptimizer: {}", summary(&all));
    Ok(())
}

/// Medians and geometric means of time and errors.
fn summary(quotients: &[[f64; 4]]) -> String {
    let name = ["time", "distance", "normals", "largest"];
    let figure = |i: usize| {
        let mut values: Vec<f64> = quotients.iter().map(|q| q[i]).collect();
        values.sort_by(f64::total_cmp);
        let mean = (values.iter().map(|x| x.ln()).sum::<f64>() / values.len() as f64).exp();
        format!("{} {:.4} (mean {mean:.4})", name[i], values[values.len() / 2])
    };
    [0, 1, 2, 3].map(figure).join(", ")
}

/// The fastest of the runs, stage by stage.
struct Case {
    /// Seconds by stage, in the order in which they come.
    seconds: Vec<(&'static str, f64)>,
    meshoptimizer: f64,
    ours: TriMesh,
    theirs: TriMesh,
}

impl Case {
    fn total(&self) -> f64 {
        self.seconds.iter().map(|stage| stage.1).sum()
    }

    fn line(&self, n_faces: usize) -> String {
        let per_face = |seconds: f64| seconds * 1e9 / n_faces as f64;
        let stages: Vec<String> =
            self.seconds.iter().map(|(stage, seconds)| format!("{} {:.1}", stage, per_face(*seconds))).collect();
        format!(
            "{:.2} of meshoptimizer; {:.0} against {:.0} ns per face: {}",
            self.total() / self.meshoptimizer,
            per_face(self.total()),
            per_face(self.meshoptimizer),
            stages.join(", ")
        )
    }
}

fn run(mesh: &TriMesh, ratio: f64, args: &Args) -> Result<Case> {
    let options = Options { scores: args.scores.into(), ..Options::new(Target::Ratio(ratio)) };
    let clock = if args.threads == 1 { ClockId::CLOCK_THREAD_CPUTIME_ID } else { ClockId::CLOCK_MONOTONIC };
    let now = || clock.now().map_or(Duration::ZERO, Duration::from);
    let mut fastest: BTreeMap<usize, (&'static str, f64)> = BTreeMap::new();
    let (mut ours, mut theirs) = (TriMesh::default(), TriMesh::default());
    let mut meshoptimizer_seconds = f64::INFINITY;
    for _ in 0..args.repeat.max(1) {
        let mut entered = vec![("begin", now())];
        let simplified = simplify(mesh, None, &options, &mut |event| {
            entered.push((event.stage, now()));
            ControlFlow::Continue(())
        })?;
        entered.push(("end", now()));
        for (i, pair) in entered.windows(2).enumerate() {
            let seconds = (pair[1].1 - pair[0].1).as_secs_f64();
            let stage = fastest.entry(i).or_insert((pair[0].0, f64::INFINITY));
            stage.1 = stage.1.min(seconds);
        }
        ours = simplified.mesh;
        let before = now();
        let done = meshoptimizer(mesh, ours.faces().len())?;
        meshoptimizer_seconds = meshoptimizer_seconds.min((now() - before).as_secs_f64());
        theirs = done.mesh;
    }
    Ok(Case { seconds: fastest.into_values().collect(), meshoptimizer: meshoptimizer_seconds, ours, theirs })
}

/// Mean distance, normal error and largest distance over meshoptimizer's.
fn errors(original: &Surface, case: &Case, samples: usize) -> [f64; 3] {
    let [ours, theirs] = [&case.ours, &case.theirs]
        .map(|mesh| surface_distance(original, &Surface::new(mesh, samples, 1)).unwrap_or_default().both);
    [ours.mean / theirs.mean, ours.normal_error / theirs.normal_error, ours.max / theirs.max]
}
