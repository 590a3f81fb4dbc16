//! The training loop with a small step: interrupted, resumed, rejected.

use crate::common::with_changes;
use std::path::Path;
use std::sync::Arc;

use neural_mesh::autodiff::{Tape, Tensors, Value};
use neural_mesh::io::{Format, write};
use neural_mesh::linalg::Matrix;
use neural_mesh::mesh::{Frame, TriMesh, shapes};
use neural_mesh::model::{Architecture, Vertices, Weights, point_sampler};
use neural_mesh::simplify::edge_graph;
use neural_mesh::train::{
    Ending, Settings, StepResult, TrainError, TrainEvent, TrainRequest, TrainingItem, TrainingRun, Wish,
    network_gradients, open, step_from_network, train,
};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::Rng;
use tempfile::TempDir;

// A small network, three epochs, with all augmentations.
const SETTINGS: &str = "epochs = 3\nvalidation = [\"held_\"]\nnoise = 0.1\nlearning_rate = 0.01\nseed = 5\n\
    point_sampler_layers = 2\npoint_sampler_width = 6\nedge_predictor_width = 4\nattention_width = 3\n\
    face_classifier_layers = 1\nface_classifier_width = 4\n";

// Creates five meshes for training, two for validation, and a broken one.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("data")).unwrap();
    let meshes = [
        ("ball.ply", shapes::icosphere(1)),
        ("box.obj", shapes::cuboid([1.0, 2.0, 3.0], 2)),
        ("held_ball.ply", shapes::icosphere(2)),
        ("held_box.off", shapes::cuboid([1.0; 3], 3)),
        ("ring.ply", shapes::torus(10, 6, 2.0, 0.5)),
        ("sheet.ply", shapes::grid(4, 5)),
        ("tetrahedron.stl", shapes::tetrahedron()),
    ];
    meshes.iter().for_each(|(name, mesh)| put(folder.path(), name, mesh));
    std::fs::write(folder.path().join("data/broken.obj"), "v 0 0\n").unwrap();
    folder
}

fn put(folder: &Path, name: &str, mesh: &TriMesh) {
    let path = folder.join("data").join(name);
    std::fs::write(&path, write(mesh, &Frame::default(), Format::from_path(&path).unwrap()).unwrap()).unwrap();
}

fn open_run(folder: &Path, name: &str, settings: Option<&str>, resume: bool) -> Result<TrainingRun, TrainError> {
    let (data, run) = (folder.join("data"), folder.join(name));
    open(&with_changes(TrainRequest::new(&data, &run), |request| {
        (request.settings, request.resume) = (settings, resume)
    }))
}

// Computes the mean of the squared scores, and half the squared difference of the mean and a random number.
fn step(
    tensors: &Tensors<Arc<Matrix>>,
    item: &TrainingItem,
    settings: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<StepResult, String> {
    step_from_network(network_step)(tensors, item, settings, random)
}

fn network_step(
    weights: &Weights,
    item: &TrainingItem,
    _: &Settings,
    random: &mut Xoshiro256PlusPlus,
) -> Result<StepResult, String> {
    let mut tape = Tape::default();
    let parameters = weights.parameters(&mut tape);
    let points = Value::constant(Matrix::from_points(item.mesh.positions()));
    let vertices = Vertices { points: &points, normals: None };
    let rings = Arc::new(edge_graph(&item.mesh));
    let scores = point_sampler(&mut tape, &parameters.point_sampler, vertices, &rings);
    let (values, n) = (scores.matrix().data(), scores.matrix().n_rows() as f64);
    let wanted = (random.next_u64() >> 40) as f64 / (1u64 << 24) as f64 * item.ratio;
    let square = values.iter().map(|&s| f64::from(s).powi(2)).sum::<f64>() / n;
    let mean = values.iter().map(|&s| f64::from(s)).sum::<f64>() / n;
    let gradient = values.iter().map(|&s| ((2.0 * f64::from(s) + mean - wanted) / n) as f32).collect();
    let gradient = Matrix::new(values.len(), 1, gradient);
    let gradients = network_gradients(&parameters, &tape.backward(&[(&scores, gradient)]));
    Ok(StepResult { terms: vec![("square", square), ("mean", 0.5 * (mean - wanted).powi(2))], gradients })
}

#[test]
fn what_is_abandoned_is_done_again() {
    let folder = folder();
    let run = |name: &str, settings, resume, progress: &mut dyn FnMut(TrainEvent) -> Wish| {
        train(&mut open_run(folder.path(), name, settings, resume).unwrap(), &step, progress).unwrap()
    };
    assert_eq!(run("whole", Some(SETTINGS), false, &mut go_on), Ending::Finished);
    let mut n_heard = 0;
    let abandoned = &mut |_: TrainEvent| {
        n_heard += 1;
        if n_heard == 3 { Wish::Abandon } else { Wish::Checkpoint }
    };
    assert_eq!(run("twice", Some(SETTINGS), false, abandoned), Ending::Stopped);
    assert_eq!(open_run(folder.path(), "twice", None, true).unwrap().position(), (0, 2));
    assert_eq!(run("twice", None, true, &mut go_on), Ending::Finished);
    assert!(read_run_files(folder.path(), "twice") == read_run_files(folder.path(), "whole"));
}

fn go_on(_: TrainEvent) -> Wish {
    Wish::Continue
}

// Reads the files of a training that must not depend on interruptions.
fn read_run_files(folder: &Path, name: &str) -> Vec<Vec<u8>> {
    let files = ["last.safetensors", "best.safetensors", "steps.csv", "epochs.csv", "config.toml", "data.csv"];
    files.map(|file| std::fs::read(folder.join(name).join(file)).unwrap()).into()
}

fn table(folder: &Path, name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    text.lines().map(|line| line.split(',').map(String::from).collect()).collect()
}

#[test]
fn it_learns_and_writes_down_how() {
    let folder = folder();
    let mut run = open_run(folder.path(), "run", Some(&format!("{SETTINGS}\nlearning_rate_decay = 0.5")), false);
    let run = run.as_mut().unwrap();
    assert_eq!(run.data.left_out[0].0, "broken.obj");
    assert_eq!(train(run, &step, &mut go_on), Ok(Ending::Finished));
    let steps = table(folder.path(), "run/steps.csv");
    let columns = ["epoch", "step", "mesh", "ratio", "square", "mean", "total", "gradient_norm", "learning_rate"];
    assert_eq!(steps[0], columns);
    assert_eq!(steps.len(), 1 + 3 * 5);
    assert_eq!((steps[1][8].as_str(), steps[6][8].as_str(), steps[15][8].as_str()), ("0.01", "0.005", "0.0025"));
    let meshes =
        |epoch: usize| steps[1 + 5 * epoch..6 + 5 * epoch].iter().map(|row| row[2].clone()).collect::<Vec<_>>();
    let (mut first, second) = (meshes(0), meshes(1));
    assert_ne!(first, second);
    first.sort();
    assert_eq!(first, ["ball.ply", "box.obj", "ring.ply", "sheet.ply", "tetrahedron.stl"]);
    let epochs = table(folder.path(), "run/epochs.csv");
    let validation = epochs[0].iter().position(|name| name == "validation_total").unwrap();
    let totals: Vec<f64> = epochs[1..].iter().map(|row| row[validation].parse().unwrap()).collect();
    assert!(totals.len() == 3 && totals[2] < totals[0], "{totals:?}");
    let best = Weights::from_bytes(&std::fs::read(folder.path().join("run/best.safetensors")).unwrap()).unwrap();
    assert_eq!(*best.architecture(), run.settings.architecture);
}

#[test]
fn stopped_anywhere_it_ends_in_the_same_bits() {
    let folder = folder();
    let mut whole = open_run(folder.path(), "whole", Some(SETTINGS), false).unwrap();
    let mut n_events = 0;
    let mut count = |_: TrainEvent| {
        n_events += 1;
        Wish::Continue
    };
    train(&mut whole, &step, &mut count).unwrap();
    assert_eq!(n_events, 3 * (5 + 2 + 1));
    for stop_at in [1, 4, 5, 6, 7, 8, 9, 13] {
        let name = format!("stopped_{stop_at}");
        let mut run = open_run(folder.path(), &name, Some(SETTINGS), false).unwrap();
        let mut n_heard = 0;
        let mut stop = |_: TrainEvent| {
            n_heard += 1;
            if n_heard == stop_at { Wish::Stop } else { Wish::Continue }
        };
        assert_eq!(train(&mut run, &step, &mut stop), Ok(Ending::Stopped));
        drop(run);
        let mut run = open_run(folder.path(), &name, None, true).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(pool.install(|| train(&mut run, &step, &mut go_on)), Ok(Ending::Finished));
        assert!(read_run_files(folder.path(), &name) == read_run_files(folder.path(), "whole"), "stopped at {stop_at}");
    }
}

#[test]
fn what_came_after_the_checkpoint_is_done_again() {
    let folder = folder();
    train(&mut open_run(folder.path(), "whole", Some(SETTINGS), false).unwrap(), &step, &mut go_on).unwrap();
    let mut run = open_run(folder.path(), "broken", Some(SETTINGS), false).unwrap();
    let mut n_heard = 0;
    let mut checkpoint = |_: TrainEvent| {
        n_heard += 1;
        if n_heard == 3 { Wish::Checkpoint } else { Wish::Continue }
    };
    // The step fails like a killed program: after steps that the checkpoint does not include.
    let n_made = std::cell::Cell::new(0);
    let failing =
        |tensors: &Tensors<Arc<Matrix>>, item: &TrainingItem, settings: &Settings, random: &mut Xoshiro256PlusPlus| {
            n_made.set(n_made.get() + 1);
            let mut made = step(tensors, item, settings, random)?;
            made.terms[0].1 = if n_made.get() == 5 { f64::NAN } else { made.terms[0].1 };
            Ok(made)
        };
    assert!(train(&mut run, &failing, &mut checkpoint).is_err());
    drop(run);
    assert_eq!(table(folder.path(), "broken/steps.csv").len(), 1 + 4);
    let mut run = open_run(folder.path(), "broken", Some(SETTINGS), true).unwrap();
    assert_eq!(run.position(), (0, 3));
    train(&mut run, &step, &mut go_on).unwrap();
    assert!(read_run_files(folder.path(), "broken") == read_run_files(folder.path(), "whole"));
}

#[test]
fn more_epochs_are_the_longer_training() {
    let folder = folder();
    train(&mut open_run(folder.path(), "short", Some(SETTINGS), false).unwrap(), &step, &mut go_on).unwrap();
    let longer = SETTINGS.replace("epochs = 3", "epochs = 5");
    train(&mut open_run(folder.path(), "long", Some(&longer), false).unwrap(), &step, &mut go_on).unwrap();
    train(&mut open_run(folder.path(), "short", Some(&longer), true).unwrap(), &step, &mut go_on).unwrap();
    assert!(read_run_files(folder.path(), "short") == read_run_files(folder.path(), "long"));
    let fewer = open_run(folder.path(), "short", Some(SETTINGS), true).unwrap_err();
    assert!(fewer.to_string().contains("5 are done"), "{fewer}");
}

#[test]
fn what_has_changed_is_named() {
    let folder = folder();
    train(&mut open_run(folder.path(), "run", Some(SETTINGS), false).unwrap(), &step, &mut go_on).unwrap();
    let refused = |settings, resume| open_run(folder.path(), "run", settings, resume).unwrap_err().to_string();
    assert!(refused(Some(SETTINGS), false).contains("already contains a training"));
    let noisier = SETTINGS.replace("noise = 0.1", "noise = 0.2");
    assert!(refused(Some(&noisier), true).contains("`noise` was 0.1 and is 0.2 now"));
    put(folder.path(), "ball.ply", &shapes::icosphere(2));
    assert!(refused(None, true).contains("ball.ply has changed"));
    put(folder.path(), "ball.ply", &shapes::icosphere(1));
    put(folder.path(), "new.ply", &shapes::icosphere(1));
    assert!(refused(None, true).contains("new.ply is new"));
    std::fs::remove_file(folder.path().join("data/new.ply")).unwrap();
    assert!(open_run(folder.path(), "run", None, true).is_ok());
    assert!(
        open_run(folder.path(), "data", Some(SETTINGS), false)
            .unwrap_err()
            .to_string()
            .contains("no training to resume")
    );
}

#[test]
fn a_loss_that_goes_astray_names_step_mesh_and_term() {
    let folder = folder();
    let led_astray = |name: &str, spoil: &dyn Fn(&mut StepResult)| {
        let n_made = std::cell::Cell::new(0);
        let astray = |tensors: &Tensors<Arc<Matrix>>,
                      item: &TrainingItem,
                      settings: &Settings,
                      random: &mut Xoshiro256PlusPlus| {
            n_made.set(n_made.get() + 1);
            let mut made = step(tensors, item, settings, random)?;
            if n_made.get() == 24 + 5 {
                spoil(&mut made);
            }
            Ok(made)
        };
        let settings = SETTINGS.replace("epochs = 3", "epochs = 20").replace("held_", "none");
        let mut run = open_run(folder.path(), name, Some(&settings), false).unwrap();
        train(&mut run, &astray, &mut go_on).unwrap_err()
    };
    let error = led_astray("nan", &|made| made.terms[1].1 = f64::NAN);
    let TrainError::Diverged { step, mesh, what } = &error else { panic!("{error}") };
    assert!(*step == 29 && mesh.contains('.') && what.contains("`mean` is NaN"), "{error}");
    let error = led_astray("explosion", &|made| made.terms[0].1 = 1e9);
    assert!(error.to_string().contains("times its running mean") && error.to_string().contains("`square`"), "{error}");
    let infinite = |made: &mut StepResult| {
        *made.gradients.get_mut("face_classifier.output.bias").unwrap() = Matrix::new(1, 1, vec![f32::INFINITY])
    };
    assert!(led_astray("infinite", &infinite).to_string().contains("`face_classifier.output.bias`"));
}

#[test]
fn meshes_that_a_step_cannot_use_are_named_and_passed_over() {
    let folder = folder();
    let choosy =
        |tensors: &Tensors<Arc<Matrix>>, item: &TrainingItem, settings: &Settings, random: &mut Xoshiro256PlusPlus| {
            let made = step(tensors, item, settings, random);
            if item.name == "sheet.ply" { Err("it is open".to_string()) } else { made }
        };
    let mut named = Vec::new();
    let mut hear = |event: TrainEvent| {
        if let TrainEvent::Skipped { mesh, why } = event {
            named.push(format!("{mesh}: {why}"));
        }
        Wish::Continue
    };
    train(&mut open_run(folder.path(), "run", Some(SETTINGS), false).unwrap(), &choosy, &mut hear).unwrap();
    assert_eq!(named, ["sheet.ply: it is open"; 3]);
    assert_eq!(table(folder.path(), "run/steps.csv").len(), 1 + 3 * 4);
    let never =
        |_: &Tensors<Arc<Matrix>>, _: &TrainingItem, _: &Settings, _: &mut Xoshiro256PlusPlus| Err("no".to_string());
    let error = train(&mut open_run(folder.path(), "none", Some(SETTINGS), false).unwrap(), &never, &mut go_on);
    assert!(error.unwrap_err().to_string().contains("no mesh of this epoch could be used"));
}

#[test]
fn fine_tuning_starts_from_weights_and_takes_their_sizes() {
    let folder = folder();
    let sizes = Architecture { point_sampler_width: 7, point_sampler_layers: 1, ..Architecture::default() };
    let (weights, other) = (Weights::random_of(sizes, 9), Weights::random_of(sizes, 10).to_bytes());
    let init = weights.to_bytes();
    let (data, run) = (folder.path().join("data"), folder.path().join("run"));
    let mut request = TrainRequest::new(&data, &run);
    (request.epochs, request.resume, request.init) = (Some(1), true, Some(init.as_slice()));
    let mut run = open(&request).unwrap();
    assert_eq!(run.tensors(), &weights.tensors().named_tensors());
    train(&mut run, &step, &mut go_on).unwrap();
    assert_ne!(run.tensors(), &weights.tensors().named_tensors());
    drop(run);
    request.init = Some(&other);
    let error = open(&request).unwrap_err();
    assert!(error.to_string().contains("other weights"), "{error}");
    (request.init, request.settings, request.epochs) = (None, Some(""), Some(2));
    assert!(open(&request).is_ok());
}
