//! Loss of quality by learning: Delaunay surface elements from learned maps against exact ones.

use std::path::Path;

use crate::learned_baselines::dse::{Maps, remesh};
use crate::learned_baselines::{LearnedBaseline, LearnedWeights};
use anyhow::{Context, Result};
use neural_mesh::metrics::{open_edges, quick_distance};
use serde::{Deserialize, Serialize};

use super::{CLASSES, RATIOS};
use crate::measure::clock::measure_time;
use crate::measure::markdown::{number, table};
use crate::measure::meshes::{load, name};
use crate::measure::pages::thread_pool;
use crate::measure::workbench::Bench;

// Samples per surface for the distances.
const SAMPLES: usize = 20_000;
// Stride: one mesh in three of the classes is measured.
const MESH_STEP: usize = 3;

// A mesh at a ratio; in arrays the learned maps come first, then the exact ones.
#[derive(Serialize, Deserialize)]
struct MapFigures {
    // Mean distances in percent of the diagonal.
    distances: [f64; 2],
    // Edges without two faces in percent.
    edges: [f64; 2],
    seconds: [f64; 2],
}

pub fn section(bench: &Bench) -> Result<String> {
    let meshes = bench.meshes("tosca")?;
    let of_class = |path: &&std::path::PathBuf| CLASSES.iter().any(|class| name(path).starts_with(class));
    let chosen: Vec<_> = meshes.iter().filter(of_class).step_by(MESH_STEP).collect();
    let at = |ratio: f64| {
        let key = |path: &Path| format!("dse/{}-{:.0}", name(path), 100.0 * ratio);
        chosen
            .iter()
            .map(|path| bench.measure_once(&key(path), || measure_maps(path, ratio)))
            .collect::<Result<Vec<_>>>()
    };
    let rows = RATIOS.into_iter().map(|ratio| Ok(row(ratio, &at(ratio)?))).collect::<Result<Vec<_>>>()?;
    let head = ["ratio", "distance, %", "WA, %", "s"].map(String::from);
    Ok(format!(
        "`dse` unfolds each neighbourhood by a learned map. An exact map, computed from the mesh, shows the cost of learning. Cells are \
         means over {} of the meshes of TOSCA, *learned / exact*.\n\n{}",
        chosen.len(),
        table(&head, &rows)
    ))
}

fn measure_maps(path: &Path, ratio: f64) -> Result<MapFigures> {
    let mesh = load(path)?;
    let n = (mesh.positions().len() as f64 * ratio) as usize;
    let one = thread_pool(1)?;
    let weights = LearnedWeights::load_shipped(LearnedBaseline::Dse);
    let remesh_with = |maps| -> Result<(f64, f64, f64)> {
        let (result, time) = one.install(|| measure_time(|| Ok(remesh(&mesh, n, 0, maps)?)))?;
        let distance = quick_distance(&mesh, &result, SAMPLES, 0).context("no faces")?;
        Ok((100.0 * distance.mean / mesh.diagonal(), open_edges(&mesh, &result).wa_percent(), time.thread))
    };
    let [learned, exact] = [remesh_with(Maps::Learned(weights.tensors()))?, remesh_with(Maps::Exact)?];
    Ok(MapFigures { distances: [learned.0, exact.0], edges: [learned.1, exact.1], seconds: [learned.2, exact.2] })
}

fn row(ratio: f64, figures: &[MapFigures]) -> Vec<String> {
    let mean = |value: &dyn Fn(&MapFigures) -> f64| figures.iter().map(value).sum::<f64>() / figures.len() as f64;
    let both = |values: &dyn Fn(&MapFigures) -> [f64; 2]| {
        let [learned, exact] = [0, 1].map(|which| number(Some(mean(&|it| values(it)[which]))));
        format!("{learned} / {exact}")
    };
    vec![ratio.to_string(), both(&|it| it.distances), both(&|it| it.edges), both(&|it| it.seconds)]
}
