//! Growth of time and memory with the mesh.

use std::ops::ControlFlow;

use crate::baselines::meshoptimizer_faces;
use crate::evaluate::median;
use anyhow::Result;
use neural_mesh::mesh::TriMesh;
use neural_mesh::simplify::{Options, Target, simplify};
use serde::{Deserialize, Serialize};

use crate::measure::clock::{measure_time, peak_bytes, reset_peak};
use crate::measure::markdown::{count, table};
use crate::measure::meshes::bumpy_torus;
use crate::measure::pages::thread_pool;
use crate::measure::workbench::Bench;

const FACES: [usize; 7] = [10_000, 30_000, 100_000, 300_000, 1_000_000, 3_000_000, 10_000_000];
const RATIO: f64 = 0.1;
// Number of input faces over all timed rounds of one mesh, which has one to nine rounds whatever its size.
const WORK: usize = 10_000_000;

#[derive(Serialize, Deserialize)]
struct GrowthPoint {
    faces: usize,
    // Nanoseconds per face: of meshoptimizer, and of neural-mesh on one and on two threads.
    times: [f64; 3],
    // Peak memory in bytes per face, including the mesh.
    memory: f64,
}

pub fn section(bench: &Bench) -> Result<String> {
    let grown = |&faces: &usize| bench.measure_once(&format!("growth/{faces}"), || measure(faces));
    let grown: Vec<GrowthPoint> = FACES.iter().map(grown).collect::<Result<_>>()?;
    let line = |grown: &GrowthPoint| {
        let times = grown.times.map(|time| format!("{time:.0}"));
        [count(grown.faces)].into_iter().chain(times).chain([format!("{:.0}", grown.memory)]).collect()
    };
    let head = ["faces", "meshoptimizer", "one thread", "two threads", "memory, bytes per face"];
    Ok(format!(
        "## Growth\n\nA bumpy torus simplified to {RATIO}: nanoseconds, and the peak of memory on two threads including the \
         mesh.\n\n{}",
        table(&head, &grown.iter().map(line).collect::<Vec<_>>())
    ))
}

fn measure(n_faces: usize) -> Result<GrowthPoint> {
    let mesh = bumpy_torus(n_faces);
    let n_faces = mesh.faces().len();
    let options = Options::new(Target::Faces((RATIO * n_faces as f64).round() as usize));
    let [one, two] = [thread_pool(1)?, thread_pool(2)?];
    let ours = |mesh: &TriMesh| Ok(simplify(mesh, None, &options, &mut |_| ControlFlow::Continue(()))?);
    reset_peak()?;
    two.install(|| ours(&mesh))?;
    let memory = peak_bytes()? as f64 / n_faces as f64;
    let mut times = [const { Vec::new() }; 3];
    for _ in 0..(WORK / n_faces).clamp(1, 9) {
        let Target::Faces(n_left) = options.target else { continue };
        times[0].push(measure_time(|| Ok(meshoptimizer_faces(&mesh, n_left)))?.1.thread);
        times[1].push(one.install(|| measure_time(|| ours(&mesh)))?.1.thread);
        times[2].push(two.install(|| measure_time(|| ours(&mesh)))?.1.wall);
    }
    let per_face = |seconds: Vec<f64>| 1e9 * median(seconds).unwrap_or_default() / n_faces as f64;
    Ok(GrowthPoint { faces: n_faces, times: times.map(per_face), memory })
}
