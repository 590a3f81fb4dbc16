//! The smallest meshes proved to be within a distance.

use std::ops::ControlFlow;
use std::path::Path;

use crate::baselines::{Baseline, Size, simplify_by};
use crate::evaluate::median;
use anyhow::{Context, Result};
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::{DistanceTolerance, Surface, certified_distance, surface_distance};
use neural_mesh::search::simplify_to_error;
use neural_mesh::simplify::{ClosedOptions, Input};
use serde::{Deserialize, Serialize};

use super::super::write_csv;
use crate::measure::clock::measure_time;
use crate::measure::markdown::{count, number};
use crate::measure::meshes::load;
use crate::measure::workbench::Bench;

const MESHES: [(&str, &str); 10] = [
    ("train", "celtic_skull"),
    ("train", "csg_bracket"),
    ("train", "dog_pose0"),
    ("train", "human_skull"),
    ("train", "koala"),
    ("train", "penguin"),
    ("train", "so101_wrist_roll_pitch_v2"),
    ("train", "statue_ugolino"),
    ("test", "nefertiti"),
    ("test", "spot"),
];
// Bounds of the largest distance in percent of the diagonal.
const ERRORS: [f64; 2] = [1.0, 0.25];
const SAMPLES: usize = 200_000;

#[derive(Serialize, Deserialize)]
struct CertainCase {
    mesh: String,
    asked: f64,
    proved: f64,
    sampled: f64,
    ours: usize,
    theirs: usize,
    seconds: f64,
}

impl CertainCase {
    fn quotient(&self) -> f64 {
        self.ours as f64 / self.theirs as f64
    }
}

const HEAD: [&str; 8] = [
    "mesh",
    "limit, %",
    "proved, %",
    "sampled, %",
    "faces, ours",
    "faces, meshoptimizer",
    "ours / meshoptimizer",
    "seconds",
];

pub fn section(bench: &Bench) -> Result<String> {
    let mut rows: Vec<CertainCase> = Vec::new();
    for (set, mesh) in MESHES {
        let path = bench.set_folder(set).join(mesh).with_extension("ply");
        for asked in ERRORS {
            rows.push(bench.measure_once(&format!("certain/{mesh}-{asked}%"), || measure(mesh, &path, asked))?);
        }
    }
    let n_over = rows.iter().filter(|row| row.sampled > row.asked).count();
    let line = |row: &CertainCase| {
        vec![
            row.mesh.clone(),
            row.asked.to_string(),
            format!("{:.3}", row.proved),
            format!("{:.3}", row.sampled),
            row.ours.to_string(),
            row.theirs.to_string(),
            number(Some(row.quotient())),
            format!("{:.1}", row.seconds),
        ]
    };
    let link = write_csv("assets-certain-distances", &HEAD, &rows.iter().map(line).collect::<Vec<_>>())?;
    let quotients: Vec<f64> = rows.iter().map(CertainCase::quotient).collect();
    let (least, most) = quotients
        .iter()
        .fold((f64::INFINITY, 0.0), |(least, most): (f64, f64), &quotient| (least.min(quotient), most.max(quotient)));
    Ok(format!(
        "## Proved distances\n\n`--error` finds the smallest mesh whose largest distance from the original is proved to be within a \
         limit. For {} meshes and the limits 1 % and 0.25 % of the diagonal, the largest of {} samples on each surface exceeds the limit \
         in {n_over} of {} results. meshoptimizer's smallest mesh with such a proof is found by bisection over its `simplify`. Faces \
         over its faces: {}, from {} to {} (median, least, largest). Each result: {link}.\n",
        MESHES.len(),
        count(SAMPLES),
        rows.len(),
        number(median(quotients.clone())),
        number(Some(least)),
        number(Some(most))
    ))
}

fn measure(name: &str, path: &Path, asked: f64) -> Result<CertainCase> {
    let mesh = load(path)?;
    let (input, options, diagonal) = (Input::bare(&mesh), ClosedOptions::default(), mesh.diagonal());
    let error = 0.01 * asked * diagonal;
    let (ours, time) =
        measure_time(|| Ok(simplify_to_error(&input, None, &options, error, &mut |_| ControlFlow::Continue(()))?))?;
    let lighter = &ours.simplified.mesh;
    let found = surface_distance(&Surface::new(&mesh, SAMPLES, 5), &Surface::new(lighter, SAMPLES, 6));
    Ok(CertainCase {
        mesh: name.into(),
        asked,
        proved: 100.0 * ours.distance.upper / diagonal,
        sampled: 100.0 * found.context("no faces")?.both.max / diagonal,
        ours: lighter.faces().len(),
        theirs: fewest_faces(&mesh, error)?,
        seconds: time.wall,
    })
}

fn fewest_faces(mesh: &TriMesh, error: f64) -> Result<usize> {
    let asked = DistanceTolerance { enough: error, too_much: error, gap: 0.0 };
    let (mut too_few, mut enough) = (0usize, mesh.faces().len());
    let mut fewest = enough;
    while enough as f64 > (too_few as f64 * 1.02).max(too_few as f64 + 2.0) {
        let middle = if too_few == 0 { enough / 4 } else { too_few.midpoint(enough) };
        let result = simplify_by(Baseline::Meshoptimizer, mesh, Size { vertices: middle, faces: middle }, 0)?;
        let holds = certified_distance(mesh, &result, &asked).is_some_and(|distance| distance.upper <= error);
        if holds {
            (enough, fewest) = (middle, fewest.min(result.faces().len()));
        } else {
            too_few = middle;
        }
        if holds && result.faces().len() > middle {
            break;
        }
    }
    Ok(fewest)
}
