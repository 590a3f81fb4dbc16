//! How long it takes to read a mesh file, clean the mesh and write it again, per face and format; on one thread.

use std::path::PathBuf;

use anyhow::Result;
use neural_mesh::io::{Format, read_path, write, write_path};
use neural_mesh::mesh::cleanup::{CleanOptions, clean};

use crate::growth::bumpy_torus;
use crate::peak::{forget_peak, peak_bytes};
use crate::speed::Spread;
use crate::speed::contestant::timed;

#[derive(clap::Args)]
pub struct Args {
    /// Faces of the mesh, about.
    #[arg(long, default_value_t = 1_000_000)]
    faces: usize,
    /// Rounds.
    #[arg(long, default_value_t = 7)]
    rounds: usize,
    /// Formats.
    #[arg(long, value_delimiter = ',', default_value = "ply,stl,obj,off")]
    formats: Vec<String>,
    /// Folder for the files.
    #[arg(long, default_value = "target/files")]
    scratch: PathBuf,
}

/// Prints a row per format: nanoseconds of the processor per face, and the most memory while reading and cleaning.
pub fn files(args: &Args) -> Result<()> {
    std::fs::create_dir_all(&args.scratch)?;
    let mesh = bumpy_torus(args.faces);
    let n_faces = mesh.faces().len() as f64;
    let frame = neural_mesh::mesh::Frame::default();
    println!("{n_faces} faces; nanoseconds of the processor per face, median of {} rounds.\n", args.rounds);
    println!(
        "| format | bytes per face | read | write | cleanup | memory to read and clean, bytes per face |\n|---|---|---|---|---|---|"
    );
    for name in &args.formats {
        let Some(format) = Format::from_name(name) else { continue };
        let path = args.scratch.join("mesh").with_extension(name);
        let mut times = [const { Vec::new() }; 3];
        let mut memory = 0;
        for _ in 0..args.rounds.max(1) {
            let ((), writing) = timed(|| Ok(write_path(&path, &write(&mesh, &frame, format)?, true)?))?;
            forget_peak()?;
            let before = peak_bytes()?;
            let (raw, reading) = timed(|| Ok(read_path(&path, None)?))?;
            let (_, cleaning) = timed(|| Ok(clean(raw, &CleanOptions::default())?))?;
            memory = peak_bytes()? - before;
            for (times, time) in times.iter_mut().zip([reading, writing, cleaning]) {
                times.push(1e9 * time.thread / n_faces);
            }
        }
        let [read, write, clean] = times.map(|times| Spread::of(times).median);
        let (size, memory) = (path.metadata()?.len() as f64 / n_faces, memory as f64 / n_faces);
        println!("| {name} | {size:.0} | {read:.1} | {write:.1} | {clean:.1} | {memory:.0} |");
    }
    Ok(())
}
