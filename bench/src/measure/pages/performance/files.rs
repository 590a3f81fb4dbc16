//! Times of reading, cleaning and writing mesh files.

use crate::evaluate::median;
use anyhow::{Context, Result};
use neural_mesh::io::{Format, read_path, write, write_path};
use neural_mesh::mesh::Frame;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use serde::{Deserialize, Serialize};

use crate::measure::clock::measure_time;
use crate::measure::markdown::{count, table};
use crate::measure::meshes::bumpy_torus;
use crate::measure::pages::thread_pool;
use crate::measure::workbench::Bench;

const FACES: usize = 1_000_000;
const FORMATS: [&str; 4] = ["ply", "stl", "obj", "off"];
const ROUNDS: usize = 5;

#[derive(Serialize, Deserialize)]
struct FormatTimes {
    format: String,
    size: f64,
    // Nanoseconds per face: reading, cleaning, writing.
    times: [f64; 3],
}

pub fn section(bench: &Bench) -> Result<String> {
    let rows: Vec<FormatTimes> = bench.measure_once("files", || {
        let folder = bench.scratch("files")?;
        let mesh = bumpy_torus(FACES);
        FORMATS.iter().map(|format| thread_pool(1)?.install(|| measure_format(format, &mesh, &folder))).collect()
    })?;
    let line = |row: &FormatTimes| {
        let times = row.times.map(|time| format!("{time:.1}"));
        [row.format.clone(), format!("{:.0}", row.size)].into_iter().chain(times).collect()
    };
    let head = ["format", "bytes per face", "read", "clean", "write"];
    Ok(format!(
        "## Files\n\nNanoseconds on one thread for a mesh of about {} faces, PLY and STL binary; medians of {ROUNDS} rounds.\n\n{}",
        count(FACES),
        table(&head, &rows.iter().map(line).collect::<Vec<_>>())
    ))
}

fn measure_format(name: &str, mesh: &neural_mesh::mesh::TriMesh, folder: &std::path::Path) -> Result<FormatTimes> {
    let format = Format::from_name(name).context("no such format")?;
    let path = folder.join("mesh").with_extension(name);
    let n_faces = mesh.faces().len() as f64;
    let mut times = [const { Vec::new() }; 3];
    for _ in 0..ROUNDS {
        let writing = measure_time(|| Ok(write_path(&path, &write(mesh, &Frame::default(), format)?, true)?))?.1;
        let (raw, reading) = measure_time(|| Ok(read_path(&path, None)?))?;
        let cleaning = measure_time(|| Ok(clean(raw, &CleanOptions::default())?))?.1;
        times.iter_mut().zip([reading, cleaning, writing]).for_each(|(all, time)| all.push(time.thread));
    }
    let size = path.metadata()?.len() as f64 / n_faces;
    std::fs::remove_file(path)?;
    let per_face = |seconds: Vec<f64>| 1e9 * median(seconds).unwrap_or_default() / n_faces;
    Ok(FormatTimes { format: name.into(), size, times: times.map(per_face) })
}
