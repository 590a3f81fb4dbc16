//! Compressed meshes (`.gz`) as input and output.

use std::fs;

use crate::common::*;

#[test]
fn compressed_meshes_go_in_and_out() {
    let folder = folder();
    let place = |name: &str| folder.path().join(name);
    let spot = test_mesh_path("spot.ply");
    for output in ["a.obj.gz", "a.ply"] {
        let run = run(folder.path(), &["simplify", spot.to_str().unwrap(), "--ratio", "0.2", "-o", output]);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    }
    let packed = fs::read(place("a.obj.gz")).unwrap();
    assert!(packed.starts_with(b"\x1f\x8b"));
    assert_eq!(info(folder.path(), "a.obj.gz")["vertices"], info(folder.path(), "a.ply")["vertices"]);

    let run = run_with_input(folder.path(), &["simplify", "-", "--ratio", "0.5", "-o", "b.PLY.GZ"], &packed);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(fs::read(place("b.PLY.GZ")).unwrap().starts_with(b"\x1f\x8b"));
}

#[test]
fn results_of_a_batch_are_not_compressed() {
    let folder = folder();
    fs::create_dir(folder.path().join("in")).unwrap();
    let spot = test_mesh_path("spot.ply");
    let made = run(folder.path(), &["simplify", spot.to_str().unwrap(), "--ratio", "0.2", "-o", "in/a.obj.gz"]);
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let run = run(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.5"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(files(&folder.path().join("out")), ["a.obj", "manifest.csv"]);
}

#[test]
fn damaged_data_is_refused_in_one_line() {
    let folder = folder();
    fs::write(folder.path().join("a.obj.gz"), b"\x1f\x8b\x08\x00 and no more").unwrap();
    let run = run(folder.path(), &["simplify", "a.obj.gz", "--ratio", "0.5", "-o", "b.obj"]);
    assert_eq!(run.code, Some(1));
    assert!(error_line(&run).contains("the gzip data is cut or damaged"), "{}", run.stderr);
}
