//! The whole program with its defaults, from file to file, against a program of a few lines around meshoptimizer.
//!
//! Both are started as processes, in turns. The other program reads with the same reader and writes with the same writer;
//! it has no weld, no cleanup and no check.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Result, ensure};
use neural_mesh::baselines::meshoptimizer_faces;
use neural_mesh::io::{Format, read_path, write, write_path};
use neural_mesh::mesh::{Frame, RawMesh, TriMesh};
use nix::sys::resource::{UsageWho, getrusage};
use nix::sys::time::TimeValLike;

use crate::load::{load, name};
use crate::methods::compact;
use crate::speed::Spread;

#[derive(clap::Args)]
pub struct Args {
    /// The program.
    #[arg(long)]
    program: PathBuf,
    /// Mesh files.
    #[arg(long, num_args = 1.., required = true)]
    mesh: Vec<PathBuf>,
    /// Shares of the vertices that stay.
    #[arg(long, value_delimiter = ',', default_value = "0.05,0.1,0.2,0.5")]
    ratios: Vec<f64>,
    /// Rounds; in each, both have a turn.
    #[arg(long, default_value_t = 5)]
    rounds: usize,
    /// Threads of the program; all without it.
    #[arg(long)]
    threads: Option<usize>,
    /// Faces that a mesh must have more than to take part.
    #[arg(long, default_value_t = 0)]
    above: usize,
    /// Folder for the results.
    #[arg(long, default_value = "target/whole")]
    scratch: PathBuf,
}

#[derive(clap::Args)]
pub struct OtherArgs {
    input: PathBuf,
    output: PathBuf,
    faces: usize,
}

/// The other program: read, simplified, written.
pub fn other(args: &OtherArgs) -> Result<()> {
    let RawMesh { positions, faces, .. } = read_path(&args.input, None)?;
    let positions = positions.into_iter().map(|p| p.map(|x| x as f32)).collect();
    let mesh = TriMesh::new(positions, faces)?;
    let lighter = compact(&mesh, &meshoptimizer_faces(&mesh, args.faces))?;
    Ok(write_path(&args.output, &write(&lighter, &Frame::default(), Format::Ply)?, true)?)
}

/// What a process took.
struct Took {
    /// Seconds on the wall.
    wall: f64,
    /// Seconds of processors.
    cpu: f64,
}

/// Prints a row per mesh and size, and the medians of all.
pub fn whole(args: &Args) -> Result<()> {
    std::fs::create_dir_all(&args.scratch)?;
    println!(
        "Time of the whole program divided by that of the other: median (least to largest) of {} rounds.\n",
        args.rounds
    );
    println!("| mesh | faces | ratio | other, ms | on the wall | of processors |\n|---|---|---|---|---|---|");
    let (mut walls, mut cpus) = (Vec::new(), Vec::new());
    for path in &args.mesh {
        let n_faces = load(path)?.faces().len();
        if n_faces <= args.above {
            continue;
        }
        for &ratio in &args.ratios {
            let (other, wall, cpu) = case(args, path, n_faces, ratio)?;
            println!("| {} | {n_faces} | {ratio} | {:.1} | {wall} | {cpu} |", name(path), 1e3 * other.median);
            walls.push(wall.median);
            cpus.push(cpu.median);
        }
    }
    println!("| **all** | | | | **{}** | **{}** |", Spread::of(walls), Spread::of(cpus));
    Ok(())
}

/// Seconds of the other on the wall, and ours divided by them, on the wall and of processors.
fn case(args: &Args, path: &Path, n_faces: usize, ratio: f64) -> Result<(Spread, Spread, Spread)> {
    let n_left = (ratio * n_faces as f64).round() as usize;
    let out = args.scratch.join("out.ply");
    let mut ours = Command::new(&args.program);
    ours.arg("simplify").arg(path).arg("-o").arg(&out).args(["--quiet", "--force", "--ratio", &ratio.to_string()]);
    if let Some(n_threads) = args.threads {
        ours.args(["--threads", &n_threads.to_string()]);
    }
    let mut other = Command::new(std::env::current_exe()?);
    other.arg("whole-other").arg(path).arg(&out).arg(n_left.to_string());
    let (mut others, mut walls, mut cpus) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..args.rounds.max(1) {
        let (own, other) = (took(&mut ours)?, took(&mut other)?);
        walls.push(own.wall / other.wall);
        cpus.push(own.cpu / other.cpu);
        others.push(other.wall);
    }
    Ok((Spread::of(others), Spread::of(walls), Spread::of(cpus)))
}

fn took(command: &mut Command) -> Result<Took> {
    let before = cpu_of_children()?;
    let start = Instant::now();
    let status = command.stdout(Stdio::null()).status()?;
    ensure!(status.success(), "{command:?}: {status}");
    Ok(Took { wall: start.elapsed().as_secs_f64(), cpu: cpu_of_children()? - before })
}

fn cpu_of_children() -> Result<f64> {
    let usage = getrusage(UsageWho::RUSAGE_CHILDREN)?;
    Ok(1e-6 * (usage.user_time().num_microseconds() + usage.system_time().num_microseconds()) as f64)
}
