//! Version of the training.

/// Version of the training; it changes when equal inputs give other bits.
///
/// ```
/// assert!(neural_mesh::train::VERSION >= 1);
/// ```
pub const VERSION: u32 = 7;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::{Format, write_path};
    use crate::linalg::golden::{GoldenCheck, Hash, Results, check};
    use crate::mesh::{Frame, shapes};
    use crate::model::Weights;
    use crate::train::{Ending, TrainRequest, Wish, open, step_function, train};

    #[test]
    fn the_training_keeps_its_bits() {
        let test = concat!(module_path!(), "::the_training_keeps_its_bits").split_once("::").unwrap().1;
        check(&GoldenCheck { part: "training", version: VERSION, constant: "train::VERSION", test }, train_all);
    }

    fn train_all() -> Results {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path().join("data");
        std::fs::create_dir(&data).unwrap();
        let meshes = [("ball", shapes::wavy_sphere(4, 4.0)), ("ring", shapes::torus(36, 18, 2.0, 0.6))];
        for (name, mesh) in meshes.into_iter().chain([("held", shapes::bolt(24))]) {
            let bytes = crate::io::write(&mesh, &Frame::default(), Format::Ply).unwrap();
            write_path(&data.join(name).with_extension("ply"), &bytes, true).unwrap();
        }
        let objective = |objective: &'static str| {
            let settings = format!(
                "objective = \"{objective}\"\nepochs = 1\nvalidation = [\"held\"]\nvalidation_ratios = [0.3]\nratio_min = 0.3\n\
                 point_sampler_layers = 1\npoint_sampler_width = 8\nedge_predictor_width = 8\nattention_width = 8\n\
                 face_classifier_layers = 1\nface_classifier_width = 8\nclouds = 0.5\n"
            );
            let run = folder.path().join(objective);
            let request = TrainRequest {
                data: &data,
                folder: &run,
                settings: Some(&settings),
                objective: None,
                epochs: None,
                resume: false,
                init: None,
                network: None,
            };
            let mut training = open(&request).unwrap();
            let step = step_function(&training.settings).unwrap();
            assert_eq!(train(&mut training, &step, &mut |_| Wish::Continue).unwrap(), Ending::Finished);
            let weights = Weights::from_named(training.settings.architecture, training.tensors());
            (objective.to_owned(), Hash::new().bytes(&weights.unwrap().to_bytes()).value())
        };
        ["bending", "paper", "shape"].map(objective).into()
    }
}
