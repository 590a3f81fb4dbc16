//! `neural-mesh-bench train-baseline`: weights for `evaluate`, and rejected input.

use crate::common::*;
use neural_mesh::mesh::shapes;

const SETTINGS: &str = "validation = []\nratio_min = 0.1\nratio_max = 0.2\nmax_samples = 100\nlearning_rate = 0.001\n";

fn data_folder() -> tempfile::TempDir {
    let folder =
        crate::data_folder(&[("ball.ply", shapes::icosphere(3)), ("ring.ply", shapes::torus(36, 18, 2.0, 0.6))]);
    std::fs::write(folder.path().join("small.toml"), SETTINGS).unwrap();
    folder
}

fn training<'a>(method: &'a str, run: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let words = ["train-baseline", method, "--data", "data", "--out", run, "--config", "small.toml"];
    [&words[..], &["--width-share", "0.25", "-q"], more].concat()
}

#[test]
fn weights_are_those_of_the_method_and_the_same_after_a_stop() {
    let folder = data_folder();
    let done = |arguments: &[&str]| {
        let done = run(folder.path(), arguments);
        assert_eq!((done.code, done.stderr.as_str()), (Some(0), ""));
    };
    done(&training("potamias", "whole", &["--epochs", "2"]));
    done(&training("potamias", "parts", &["--epochs", "1"]));
    done(&training("potamias", "parts", &["--epochs", "2", "--resume"]));
    let file = |run: &str, name: &str| std::fs::read(folder.path().join(run).join(name)).unwrap();
    for name in ["last.safetensors", "steps.csv", "epochs.csv"] {
        assert!(file("whole", name) == file("parts", name), "{name}");
    }
    done(&training("potamias", "on", &["--epochs", "1", "--init", "whole/last.safetensors"]));
}

#[test]
fn untrainable_requests_are_refused_in_one_line() {
    let folder = data_folder();
    let refused = |code: i32, arguments: &[&str], words: &str| {
        let line = refuse(folder.path(), arguments, code);
        assert!(line.contains(words), "{line}");
    };
    refused(2, &training("magic", "run", &[]), "dse, potamias, pointtrinet");
    refused(2, &training("dse", "run", &["--objective", "shape"]), "--objective");
    refused(1, &training("dse", "run", &["--init", "none.safetensors"]), "none.safetensors");
    std::fs::write(folder.path().join("small.toml"), "width = 3").unwrap();
    refused(1, &training("dse", "run", &[]), "`width`");
}
