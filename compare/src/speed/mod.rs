//! How long simplification takes: ours and meshoptimizer's three, taking turns in one process on the same mesh and size.
//!
//! What is printed are ratios to meshoptimizer's `simplify` in the same round, so that what slows the machine down for a
//! while slows both sides of a ratio. On one thread the time is the processor's, on several that on the wall.

pub mod contestant;
mod page;
mod spread;

use std::path::PathBuf;

use anyhow::Result;
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{Surface, surface_distance};

use crate::load::{load_raw, name};
use contestant::{Contestant, Input, Time, Who};
use page::Page;
pub use spread::Spread;

/// Samples on each surface, where distances are asked for.
const SAMPLES: usize = 100_000;

#[derive(clap::Args)]
pub struct Args {
    /// Mesh files.
    #[arg(long, num_args = 1.., required = true)]
    mesh: Vec<PathBuf>,
    /// Shares of the faces that stay.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.1,0.2,0.5")]
    ratios: Vec<f64>,
    /// Rounds; in each, everyone has a turn.
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Numbers of threads that ours runs on; 0 for all. meshoptimizer has one.
    #[arg(long, value_delimiter = ',', default_value = "1,0")]
    threads: Vec<usize>,
    /// Faces that a mesh must have more than to take part.
    #[arg(long, default_value_t = 0)]
    above: usize,
    /// Contestants; all of them without it. `plain` always takes part.
    #[arg(long, value_enum, value_delimiter = ',')]
    only: Vec<Who>,
    /// Measure the mean distance from the original too.
    #[arg(long)]
    distance: bool,
}

/// One contestant in one case.
pub struct Measured {
    pub seconds: Spread,
    /// Its seconds divided by those of `plain` in the same round, both by the same clock.
    pub relative: Spread,
    /// Mean two-sided distance from the original, in units of the mesh.
    pub distance: Option<f64>,
}

/// One mesh at one size.
pub struct Case {
    pub mesh: String,
    pub n_faces: usize,
    pub ratio: f64,
    pub measured: Vec<Measured>,
}

/// Runs every case, prints its ratios as they come, and their medians over all cases in the end.
pub fn speed(args: &Args) -> Result<()> {
    let contestants = contestant::lined_up(&args.threads, &args.only)?;
    let mut page = Page::new(&contestants, args.distance);
    for path in &args.mesh {
        let input = Input::new(load_raw(path)?)?;
        if input.mesh.faces().len() <= args.above {
            continue;
        }
        for &ratio in &args.ratios {
            page.tell(case(args, &contestants, &name(path), &input, ratio)?);
        }
    }
    page.tell_medians();
    Ok(())
}

fn case(args: &Args, contestants: &[Contestant], mesh: &str, input: &Input, ratio: f64) -> Result<Case> {
    let n_faces = (ratio * input.mesh.faces().len() as f64).round() as usize;
    let rounds: Vec<Vec<Time>> =
        (0..args.rounds.max(1)).map(|_| round(contestants, input, n_faces)).collect::<Result<_>>()?;
    let distances = distances(args, contestants, input, n_faces)?;
    let measured = contestants.iter().zip(distances).enumerate().map(|(place, (contestant, distance))| {
        let seconds = |round: &Vec<Time>| contestant.seconds(round[place]);
        let relative = |round: &Vec<Time>| seconds(round) / contestant.seconds(round[0]);
        Measured {
            seconds: Spread::of(rounds.iter().map(seconds).collect()),
            relative: Spread::of(rounds.iter().map(relative).collect()),
            distance,
        }
    });
    Ok(Case { mesh: mesh.to_owned(), n_faces: input.mesh.faces().len(), ratio, measured: measured.collect() })
}

/// A turn of everyone.
fn round(contestants: &[Contestant], input: &Input, n_faces: usize) -> Result<Vec<Time>> {
    contestants.iter().map(|contestant| Ok(contestant.turn(input, n_faces)?.time)).collect()
}

/// The distance of each contestant's result, where it is asked for: of a turn that is not timed.
fn distances(args: &Args, contestants: &[Contestant], input: &Input, n_faces: usize) -> Result<Vec<Option<f64>>> {
    if !args.distance {
        return Ok(vec![None; contestants.len()]);
    }
    let original = Surface::new(&input.mesh, SAMPLES, 0);
    let distance = |mesh: &TriMesh| surface_distance(&original, &Surface::new(mesh, SAMPLES, 1)).map(|d| d.both.mean);
    contestants.iter().map(|contestant| Ok(distance(&contestant.turn(input, n_faces)?.mesh(input)?))).collect()
}
