//! `neural-mesh train`: interruption, continuation, errors, files.

use std::path::Path;

use crate::common::*;
use neural_mesh::io::{Format, write};
use neural_mesh::mesh::{Frame, TriMesh, shapes};

const SETTINGS: &str = "objective = \"bending\"\nepochs = 40\nvalidation = [\"held_\"]\nnoise = 0.1\n\
    checkpoint_minutes = 0.0005\npoint_sampler_layers = 2\npoint_sampler_width = 12\nedge_predictor_width = 4\n\
    attention_width = 3\nface_classifier_layers = 1\nface_classifier_width = 4\n";

fn training_folder() -> tempfile::TempDir {
    let folder = folder();
    std::fs::create_dir(folder.path().join("data")).unwrap();
    let meshes: [(&str, TriMesh); 5] = [
        ("ball.ply", shapes::icosphere(2)),
        ("box.ply", shapes::cuboid([1.0, 2.0, 3.0], 4)),
        ("held_ring.ply", shapes::torus(8, 6, 2.0, 0.7)),
        ("ring.ply", shapes::torus(16, 8, 2.0, 0.5)),
        ("pipe.ply", shapes::open_cylinder(9, 9)),
    ];
    for (name, mesh) in meshes {
        let bytes = write(&mesh, &Frame::default(), Format::Ply).unwrap();
        std::fs::write(folder.path().join("data").join(name), bytes).unwrap();
    }
    std::fs::write(folder.path().join("small.toml"), SETTINGS).unwrap();
    folder
}

fn training<'a>(run: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&["train", "--data", "data", "--out", run, "--config", "small.toml"], more].concat()
}

fn output_files(folder: &Path, run: &str) -> Vec<Vec<u8>> {
    let files = ["last.safetensors", "best.safetensors", "steps.csv", "epochs.csv", "config.toml", "curves.svg"];
    files.map(|file| std::fs::read(folder.join(run).join(file)).unwrap()).into()
}

#[test]
fn a_training_prints_its_objective_and_its_weights_suit_one_assembly() {
    let folder = training_folder();
    for (objective, assembly, other) in [("paper", "paper", "closed"), ("bending", "closed", "paper")] {
        let arguments = training(objective, &["--objective", objective, "--epochs", "1"]);
        let done = succeed(folder.path(), &arguments);
        let said = String::from_utf8(done.stdout).unwrap();
        assert!(said.contains(&format!("objective {objective}: ")), "{said}");
        assert!(said.contains("1 for validation, whose names begin with held_"), "{said}");
        let weights = format!("{objective}/last.safetensors");
        let simplify = |assembly| {
            let more = ["--ratio", "0.5", "--weights", &weights, "--assembly", assembly, "-f"];
            run(folder.path(), &[&["simplify", "data/ball.ply", "-o", "a.ply"], &more[..]].concat())
        };
        assert_eq!(simplify(assembly).code, Some(0), "{assembly}");
        let refused = simplify(other);
        assert_eq!(refused.code, Some(1));
        assert!(
            refused.stderr.contains(&format!("was trained with the objective \"{objective}\"")),
            "{}",
            refused.stderr
        );
    }
    let unknown = run(folder.path(), &training("new", &["--objective", "nonsense"]));
    assert!(unknown.code == Some(1) && unknown.stderr.contains("must be one of"), "{}", unknown.stderr);
    assert!(!folder.path().join("new").exists());
}

#[test]
fn killed_at_any_moment_it_ends_in_the_same_bits() {
    let folder = training_folder();
    succeed(folder.path(), &training("whole", &["--threads", "1"]));
    // Rows of 41 epochs, and milliseconds until the program is killed.
    let mut n_killed = 0;
    let epochs = folder.path().join("killed/epochs.csv");
    for (n_rows, milliseconds) in [(0, 2), (0, 30), (2, 0), (6, 13), (11, 5), (18, 0), (24, 21), (29, 9)] {
        let child = program(folder.path(), &training("killed", &["--resume"])).spawn().unwrap();
        n_killed += usize::from(kill_after(child, milliseconds, || n_lines(&epochs) >= n_rows));
    }
    assert!(n_killed >= 3, "killed only {n_killed} times");
    succeed(folder.path(), &training("killed", &["--resume", "--threads", "2"]));
    assert!(output_files(folder.path(), "killed") == output_files(folder.path(), "whole"));
    let leftovers: Vec<String> = files(&folder.path().join("killed"));
    assert!(leftovers.iter().all(|name| !name.starts_with('.')), "{leftovers:?}");
}

#[test]
fn a_training_leaves_what_the_help_says() {
    let folder = training_folder();
    let done = run(folder.path(), &training("run", &["--epochs", "2"]));
    assert_eq!((done.code, done.stderr.as_str()), (Some(0), ""));
    let said = String::from_utf8(done.stdout).unwrap();
    assert!(said.contains("4 for training, 1 for validation") && said.contains("epoch     2 of 2"), "{said}");
    let expected = [
        "best.safetensors",
        "checkpoint.safetensors",
        "config.toml",
        "curves.svg",
        "data.csv",
        "epochs.csv",
        "last.safetensors",
        "steps.csv",
    ];
    assert_eq!(files(&folder.path().join("run")), expected);
    let help = String::from_utf8(run(folder.path(), &["train", "--help"]).stdout).unwrap();
    assert!(expected.iter().all(|name| help.contains(name)), "{help}");
    std::fs::remove_file(folder.path().join("run/curves.svg")).unwrap();
    assert_eq!(run(folder.path(), &["train", "--plot", "run", "-q"]).code, Some(0));
    assert!(std::fs::read_to_string(folder.path().join("run/curves.svg")).unwrap().contains("teacher, validation"));
    let config = std::fs::read_to_string(folder.path().join("run/config.toml")).unwrap();
    assert!(config.contains("\nepochs = 2\n") && config.contains("# Seed of the first weights"), "{config}");
    let copy = run(folder.path(), &["train", "--data", "data", "--out", "copy", "--config", "run/config.toml", "-q"]);
    assert_eq!((copy.code, copy.stdout), (Some(0), vec![]));
    assert!(output_files(folder.path(), "copy") == output_files(folder.path(), "run"));
}

#[test]
fn a_training_without_curves_is_a_training() {
    let folder = training_folder();
    assert_eq!(run(folder.path(), &training("run", &["--epochs", "1"])).code, Some(0));
    std::fs::remove_file(folder.path().join("run/curves.svg")).unwrap();
    std::fs::create_dir(folder.path().join("run/curves.svg")).unwrap();
    let done = succeed(folder.path(), &training("run", &["--epochs", "2", "--resume"]));
    assert!(error_line(&done).contains("but its curves are not drawn"), "{}", done.stderr);
}

#[test]
fn refusals_say_what_to_do() {
    let folder = training_folder();
    assert_eq!(run(folder.path(), &training("run", &["--epochs", "1"])).code, Some(0));
    let refused = |code: i32, arguments: &[&str], words: &str| {
        let refusal = run(folder.path(), arguments);
        assert_eq!(refusal.code, Some(code), "{}", refusal.stderr);
        let line = error_line(&refusal);
        assert!(line.contains(words), "{line}");
    };
    refused(1, &training("run", &[]), "--resume");
    refused(1, &training("data", &[]), "no training to resume");
    refused(1, &["train", "--data", "none", "--out", "new"], "none");
    refused(1, &["train", "--plot", "data"], "epochs.csv");
    refused(2, &training("new", &["--epochs", "0"]), "--epochs");
    refused(2, &training("new", &["--threads", "0"]), "--threads");
    for (text, words) in [("epocs = 3", "`epocs`"), ("objective = \"none\"", "`objective`"), ("noise = [", "line 1")] {
        std::fs::write(folder.path().join("bad.toml"), text).unwrap();
        refused(1, &["train", "--data", "data", "--out", "new", "--config", "bad.toml"], words);
        assert!(!folder.path().join("new").exists());
    }
    std::fs::write(folder.path().join("small.toml"), SETTINGS.replace("0.1", "0.2")).unwrap();
    refused(1, &training("run", &["--resume"]), "`noise`");
    assert_eq!(run(folder.path(), &["train", "--data", "data"]).code, Some(2));
    assert_eq!(run(folder.path(), &["train", "--plot", "run", "--data", "data"]).code, Some(2));
}

#[cfg(unix)]
#[test]
fn ctrl_c_stops_after_the_step_with_a_checkpoint() {
    let folder = training_folder();
    std::fs::write(folder.path().join("small.toml"), SETTINGS.replace("epochs = 40", "epochs = 100000")).unwrap();
    let child = program(folder.path(), &training("run", &[])).spawn().unwrap();
    let epochs = folder.path().join("run/epochs.csv");
    let stopped = interrupt_once(child, || n_lines(&epochs) >= 4);
    assert_eq!(stopped.code, Some(130), "{}", stopped.stderr);
    assert!(error_line(&stopped).contains("--resume"));
    let rows = |name: &str| n_lines(&folder.path().join(name));
    let steps = rows("run/steps.csv");
    let done = (rows("run/epochs.csv") - 1).to_string();
    let resumed = run(folder.path(), &training("run", &["--resume", "--epochs", &done]));
    assert_eq!((resumed.code, rows("run/steps.csv")), (Some(0), steps), "{}", resumed.stderr);
}
