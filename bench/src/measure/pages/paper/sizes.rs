//! Widths, layers and neighbours of the paper's network, each trained again and judged on families held out.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use neural_mesh::metrics::Surface;
use neural_mesh::model::{Architecture, Weights};
use neural_mesh::train::{Settings, TrainRequest, Wish, open, step_function, train};
use serde::{Deserialize, Serialize};

use super::{measure_result, simplify_by_paper};
use crate::measure::clock::measure_time;
use crate::measure::markdown::{number, table};
use crate::measure::meshes::{load, name};
use crate::measure::pages::{RATIOS, thread_pool};
use crate::measure::root;
use crate::measure::workbench::Bench;

/// Settings of all trainings, except for the sizes.
const SETTINGS: &str = "weights/paper-open.toml";
/// Width of all layers, number of TriConv layers, number of nearest triangles joined with each; 0 joins edge
/// neighbours.
const SIZES: [[usize; 3]; 7] = [[16, 3, 0], [32, 3, 0], [64, 3, 0], [32, 2, 0], [32, 1, 0], [32, 3, 8], [32, 3, 20]];
const SAMPLES: usize = 20_000;

/// Means over the held-out meshes at one ratio.
#[derive(Clone, Copy, Default, Serialize, Deserialize)]
struct Figures {
    /// Chamfer distance in 1e-6 of the squared diagonal.
    chamfer: f64,
    /// Mean of 1 - |n.n'|.
    normals: f64,
    /// Share of edges without two faces, in percent.
    open: f64,
    /// Processor time on one thread.
    seconds: f64,
}

pub fn page(bench: &Bench) -> Result<String> {
    let mut lines = Vec::new();
    for sizes in SIZES {
        let key = format!("paper-sizes/{}", sizes.map(|size| size.to_string()).join("-"));
        let sizes_of = architecture(sizes);
        let figures: Vec<Figures> = bench.measure_once(&key, || judge(bench, &train_sizes(bench, &key, sizes_of)?))?;
        let [width, layers, neighbours] = sizes;
        let neighbours = if neighbours == 0 { "across edges".to_owned() } else { format!("{neighbours} nearest") };
        let head = [width.to_string(), neighbours, layers.to_string(), sizes_of.n_parameters().to_string()];
        let all =
            |of: fn(&Figures) -> f64| figures.iter().map(|at| number(Some(of(at)))).collect::<Vec<_>>().join(" / ");
        let cells = [all(|at| at.chamfer), all(|at| at.normals), all(|at| at.open), all(|at| 1e3 * at.seconds)];
        lines.push(head.into_iter().chain(cells).collect());
    }
    let head = ["width", "neighbours", "layers", "parameters", "CD", "NE", "WA, %", "ms"];
    Ok(format!(
        "The paper states three TriConv layers, 20 nearest triangles, and no widths. Each line is a training by \
         `{SETTINGS}` with these sizes alone changed, judged on the families of `train` that it holds out: means at {}. \
         The network that ships has the second line's sizes. CD and NE are as in \
         [paper.md](paper.md); ms: processor time per mesh, one thread.\n\n{}",
        RATIOS.map(|ratio| ratio.to_string()).join(" / "),
        table(&head, &lines)
    ))
}

fn architecture([width, layers, neighbours]: [usize; 3]) -> Architecture {
    Architecture {
        point_sampler_width: width,
        edge_predictor_width: width,
        attention_width: width,
        face_classifier_width: width,
        face_classifier_layers: layers,
        face_knn: neighbours,
        ..Architecture::default()
    }
}

/// Trains a network of these sizes, resuming an earlier run; returns its last weights.
fn train_sizes(bench: &Bench, key: &str, sizes: Architecture) -> Result<PathBuf> {
    let settings = std::fs::read_to_string(root().join(SETTINGS))?;
    let settings = Settings::from_toml(&settings)?.with_architecture(&sizes)?.to_toml();
    let (data, folder) = (bench.set_folder("train"), bench.scratch(key)?);
    let mut request = TrainRequest::new(&data, &folder);
    request.settings = Some(&settings);
    request.resume = folder.join("checkpoint.safetensors").exists();
    let mut run = open(&request)?;
    let step = step_function(&run.settings)?;
    train(&mut run, &step, &mut |_| Wish::Continue)?;
    Ok(folder.join("last.safetensors"))
}

/// Simplifies all held-out meshes with these weights, at each ratio.
fn judge(bench: &Bench, weights: &Path) -> Result<Vec<Figures>> {
    let weights = Weights::from_bytes(&std::fs::read(weights).with_context(|| weights.display().to_string())?)?;
    let families = Settings::from_toml("")?.validation;
    let is_held_out = |path: &Path| families.iter().any(|family| name(path).starts_with(family));
    let paths: Vec<PathBuf> = bench.meshes("train")?.into_iter().filter(|path| is_held_out(path)).collect();
    let one = thread_pool(1)?;
    let mut means = vec![Figures::default(); RATIOS.len()];
    for path in &paths {
        let mesh = load(path)?;
        let original = Surface::new(&mesh, SAMPLES, 0);
        for (mean, ratio) in means.iter_mut().zip(RATIOS) {
            let (lighter, seconds) =
                one.install(|| measure_time(|| simplify_by_paper(&mesh, Some(&weights), ratio)))?;
            let [chamfer, normals, open] = measure_result(&mesh, &original, &lighter)?;
            let n = paths.len() as f64;
            mean.chamfer += chamfer / n;
            mean.normals += normals / n;
            mean.open += open / n;
            mean.seconds += seconds.thread / n;
        }
    }
    Ok(means)
}
