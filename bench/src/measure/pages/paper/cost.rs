//! Time and memory of the paper's assembly, also at the 42 thousand faces where a study of another implementation gave
//! up.

use anyhow::Result;
use neural_mesh::metrics::Surface;
use serde::{Deserialize, Serialize};

use super::{measure_result, simplify_by_paper};
use crate::evaluate::median;
use crate::measure::clock::{measure_time, peak_bytes, reset_peak};
use crate::measure::markdown::{count, number, table};
use crate::measure::meshes::bumpy_torus;
use crate::measure::pages::{RATIOS, thread_pool};
use crate::measure::workbench::Bench;

/// Numbers of faces of the torus; the first is that of a mesh in [`STUDY`].
const FACES: [usize; 4] = [42_000, 200_000, 580_000, 2_000_000];
const SAMPLES: usize = 50_000;
/// Number of input faces over all timed rounds of one mesh, which has one to nine rounds whatever its size.
const WORK: usize = 600_000;
const STUDY: &str = "https://github.com/L-Gallo/mesh-simplification-study/blob/694001820a9bc662e886e9e6034d84fa36a6b0e9/neural_methods/DEVELOPMENT_LOG.md";

#[derive(Serialize, Deserialize)]
struct Cost {
    faces: usize,
    /// Processor seconds on one thread, and elapsed seconds on two.
    seconds: [f64; 2],
    /// Megabytes in use before the simplification (with the mesh), and at most during it.
    memory: [f64; 2],
    /// Chamfer distance in 1e-6 of the squared diagonal, mean of 1 - |n.n'|, edges without two faces in percent.
    figures: [f64; 3],
}

pub fn page(bench: &Bench) -> Result<String> {
    let mut lines = Vec::new();
    for faces in FACES {
        for ratio in RATIOS {
            let cost: Cost =
                bench.measure_once(&format!("paper-cost/{faces}-{:.0}", 100.0 * ratio), || measure(faces, ratio))?;
            let [before, peak] = cost.memory.map(|megabytes| format!("{megabytes:.0}"));
            let values = cost.seconds.into_iter().chain(cost.figures).map(|value| number(Some(value)));
            let [one, two, chamfer, normals, open] = values.collect::<Vec<_>>().try_into().unwrap_or_default();
            lines.push([count(cost.faces), ratio.to_string(), one, two, before, peak, chamfer, normals, open].to_vec());
        }
    }
    let head = ["faces", "ratio", "s, one thread", "s, two threads", "MB before", "MB, peak", "CD", "NE", "WA, %"];
    Ok(format!(
        "`--assembly paper` with the weights that ship, on a bumpy torus. Seconds are of the processor on one thread and of the clock on \
         two, medians; memory is that of the whole process on two threads. CD and NE are as in \
         [paper.md](paper.md).\n\n{}\n\
         ## The case of 42 thousand faces\n\n\
         The authors of the paper published no code. The one study that tried a public re-implementation gave up on a character of \
         42,000 faces: [its log]({STUDY}) estimates 1,600 GB as published, 1,100 GB with a quarter of the widths, 850 GB with \
         sparse matrices, and no run of eight ended. The first lines of the table have as many faces. \
         `scripts/other_implementation` runs a later re-implementation next to this one.\n",
        table(&head, &lines)
    ))
}

fn measure(n_faces: usize, ratio: f64) -> Result<Cost> {
    let mesh = bumpy_torus(n_faces);
    let ours = || simplify_by_paper(&mesh, None, ratio);
    let [one, two] = [thread_pool(1)?, thread_pool(2)?];
    reset_peak()?;
    let before = peak_bytes()?;
    let lighter = two.install(ours)?;
    let memory = [before, peak_bytes()?].map(|bytes| bytes as f64 / 1e6);
    let mut seconds = [const { Vec::new() }; 2];
    for _ in 0..(WORK / mesh.faces().len()).clamp(1, 9) {
        seconds[0].push(one.install(|| measure_time(ours))?.1.thread);
        seconds[1].push(two.install(|| measure_time(ours))?.1.wall);
    }
    let original = Surface::new(&mesh, SAMPLES, 0);
    Ok(Cost {
        faces: mesh.faces().len(),
        seconds: seconds.map(|all| median(all).unwrap_or_default()),
        memory,
        figures: measure_result(&mesh, &original, &lighter)?,
    })
}
