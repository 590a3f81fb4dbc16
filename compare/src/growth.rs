//! How time and memory grow with the mesh: a bumpy torus from ten thousand to ten million faces.

use anyhow::Result;
use neural_mesh::mesh::{RawMesh, TriMesh, shapes};

use crate::peak::{forget_peak, peak_bytes};
use crate::speed::Spread;
use crate::speed::contestant::{Contestant, Input, Who};

#[derive(clap::Args)]
pub struct Args {
    /// Faces of the meshes, about.
    #[arg(long, value_delimiter = ',', default_value = "10000,30000,100000,300000,1000000,3000000,10000000")]
    faces: Vec<usize>,
    /// Share of the faces that stay.
    #[arg(long, default_value_t = 0.1)]
    ratio: f64,
    /// Numbers of threads that ours runs on; 0 for all. meshoptimizer has one.
    #[arg(long, value_delimiter = ',', default_value = "1,0")]
    threads: Vec<usize>,
    /// Faces to simplify in all rounds on a mesh, that small meshes have more of them; there are three to fifteen.
    #[arg(long, default_value_t = 3_000_000)]
    work: usize,
}

/// Prints a row per mesh: nanoseconds per face of meshoptimizer's `simplify` and of ours, and the memory that ours takes.
pub fn growth(args: &Args) -> Result<()> {
    let mut contestants = vec![Contestant::new(Who::Plain, 1)?];
    for &n_threads in &args.threads {
        contestants.push(Contestant::new(Who::Ours, n_threads)?);
    }
    let names: String = contestants.iter().map(|contestant| format!(" {} |", contestant.name)).collect();
    println!(
        "Nanoseconds per input face at ratio {}; most memory of ours in bytes per input face, mesh included.\n",
        args.ratio
    );
    println!("| faces |{names} memory |\n|---|{}---|", "---|".repeat(contestants.len()));
    for &n_faces in &args.faces {
        println!("{}", row(args, &contestants, bumpy_torus(n_faces))?);
    }
    Ok(())
}

fn row(args: &Args, contestants: &[Contestant], mesh: TriMesh) -> Result<String> {
    let n_faces = mesh.faces().len();
    let input = Input { raw: RawMesh::default(), mesh };
    let target = (args.ratio * n_faces as f64).round() as usize;
    let memory = memory(&contestants[contestants.len() - 1], &input, target)?;
    let mut seconds = vec![Vec::new(); contestants.len()];
    for _ in 0..(args.work / n_faces.max(1)).clamp(3, 15) {
        for (contestant, seconds) in contestants.iter().zip(&mut seconds) {
            seconds.push(contestant.seconds(contestant.turn(&input, target)?.time));
        }
    }
    let per_face = |seconds: Vec<f64>| format!(" {:.0} |", 1e9 * Spread::of(seconds).median / n_faces as f64);
    let cells: String = seconds.into_iter().map(per_face).collect();
    Ok(format!("| {n_faces} |{cells} {:.0} |", memory as f64 / n_faces as f64))
}

/// Most bytes of this process during a turn.
fn memory(contestant: &Contestant, input: &Input, target: usize) -> Result<u64> {
    forget_peak()?;
    contestant.turn(input, target)?;
    peak_bytes()
}

/// A torus with bumps all over, of about so many faces of about equal edges.
pub fn bumpy_torus(n_faces: usize) -> TriMesh {
    // Three times as far around as through the tube.
    let n_tube = (n_faces as f64 / 6.0).sqrt().round().max(3.0);
    let torus = shapes::torus((3.0 * n_tube) as u32, n_tube as u32, 1.0, 1.0 / 3.0);
    let (positions, faces) = torus.into_parts();
    TriMesh::new(positions.into_iter().map(bumped).collect(), faces).unwrap_or_default()
}

/// Moves a point of the torus away from its middle circle or toward it, by bumps of several sizes.
fn bumped([x, y, z]: [f32; 3]) -> [f32; 3] {
    let [x, y, z] = [x, y, z].map(f64::from);
    let around = y.atan2(x);
    let outward = x.hypot(y) - 1.0;
    let through = z.atan2(outward);
    let wave = |n: f64, m: f64| (n * around).sin() * (m * through).cos();
    let tube = outward.hypot(z) * (1.0 + 0.1 * wave(9.0, 3.0) + 0.03 * wave(31.0, 11.0) + 0.01 * wave(97.0, 29.0));
    let (radius, z) = (1.0 + tube * through.cos(), tube * through.sin());
    [radius * around.cos(), radius * around.sin(), z].map(|x| x as f32)
}
