//! Learns scores from pictures: each face of a mesh answers for the FLIP error of the pixels that show it.
//!
//! `cargo run --release -p neural-mesh-bench --example learned_looks -- MESHES RUN SETTINGS.toml [WEIGHTS]`

use neural_mesh::autodiff::Tensors;
use neural_mesh::linalg::Matrix;
use neural_mesh::mesh::TriMesh;
use neural_mesh::metrics::flip;
use neural_mesh::picture::view;
use neural_mesh::simplify::WeightedResult;
use neural_mesh::train::{
    CustomObjective, Errors, OWN_OBJECTIVE, Settings, TrainEvent, TrainRequest, TrainingItem, Wish, open,
    step_from_objective, train,
};
use std::sync::Arc;

/// Azimuth and elevation of the pictures in degrees.
const VIEWS: [[f32; 2]; 6] = [[0.0, 0.0], [90.0, 10.0], [180.0, -10.0], [270.0, 20.0], [45.0, 80.0], [225.0, -80.0]];
const HEIGHT: usize = 128;

fn main() -> anyhow::Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [meshes, folder, settings, weights @ ..] = arguments.as_slice() else {
        anyhow::bail!("give a folder of meshes, one for the run, a file of settings, and weights to start from");
    };
    let settings = std::fs::read_to_string(settings)?;
    let weights = weights.first().map(std::fs::read).transpose()?;
    let mut request = TrainRequest::new(meshes.as_ref(), folder.as_ref());
    (request.settings, request.objective, request.init) =
        (Some(settings.as_str()), Some(OWN_OBJECTIVE), weights.as_deref());
    request.resume = true;
    let mut run = open(&request)?;
    let objective = CustomObjective(visible_errors);
    let step = |tensors: &Tensors<Arc<Matrix>>, item: &TrainingItem, settings: &Settings, random: &mut _| {
        step_from_objective(&objective)(tensors, item, settings, random)
    };
    train(&mut run, &step, &mut |event| {
        if let TrainEvent::Epoch { n_done, training, validation, .. } = event {
            println!("epoch {n_done}: training {training:.4}, validation {validation:?}");
        }
        Wish::Continue
    })?;
    Ok(())
}

/// Returns the FLIP error of the pixels that show each face of the original.
fn visible_errors(original: &TriMesh, result: &WeightedResult) -> Result<Errors, String> {
    let mut errors = vec![0.0; original.faces().len()];
    for direction in VIEWS {
        let views = view(&[original, &result.mesh], direction, HEIGHT);
        let [a, b] = [0, 1].map(|mesh| views[mesh].shaded.colours());
        let of_pixels = flip(views[0].shaded.width, &a, &b).ok_or("the pictures differ in size")?;
        for (face, error) in views[0].faces.iter().zip(of_pixels) {
            if let Some(face) = face {
                errors[*face as usize] += error;
            }
        }
    }
    Ok(Errors::Faces(errors))
}
