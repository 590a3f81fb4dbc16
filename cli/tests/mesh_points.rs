//! `neural-mesh mesh-points` from clouds in all formats.

use crate::common::*;
use neural_mesh::io::{self, Format};
use neural_mesh::mesh::shapes;
use neural_mesh::model::Weights;

fn folder_with_cloud() -> tempfile::TempDir {
    let folder = folder();
    std::fs::write(folder.path().join("w.safetensors"), Weights::random(1).to_bytes()).unwrap();
    let cloud = shapes::icosphere(2);
    let lines: String = cloud.positions().iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    std::fs::write(folder.path().join("ball.xyz"), lines).unwrap();
    folder
}

const CALL: [&str; 5] = ["mesh-points", "ball.xyz", "--weights", "w.safetensors", "-o"];

#[test]
fn a_cloud_becomes_a_mesh_and_a_report() {
    let folder = folder_with_cloud();
    let run = succeed(folder.path(), &[&CALL[..], &["ball.ply", "--report", "r.json", "--ratio", "0.5"]].concat());
    let words = String::from_utf8(run.stdout).unwrap();
    assert!(words.contains("162 points -> ") && words.contains(" non-manifold edges"), "{words}");
    let (report, mesh) = (json(&folder.path().join("r.json")), info(folder.path(), "ball.ply"));
    for (told, found) in [("vertices", "vertices"), ("faces", "faces"), ("holes", "boundary_loops")] {
        assert_eq!(report[told], mesh[found], "{told}");
    }
    assert_eq!(report["vertices"].as_u64().unwrap() + report["unused_points"].as_u64().unwrap(), 81);
    assert_eq!((&report["points"], &report["non_manifold_edges"]), (&162.into(), &0.into()));
}

#[test]
fn the_formats_of_the_help_are_written() {
    let folder = folder_with_cloud();
    let help = String::from_utf8(succeed(folder.path(), &["mesh-points", "--help"]).stdout).unwrap();
    let words: Vec<&str> = help.split_whitespace().collect();
    let list = words.join(" ").split_once("has no known ending: ").unwrap().1.split_once(" --").unwrap().0.to_string();
    for format in list.split([',', ' ']).filter(|word| !word.is_empty()) {
        let run = succeed(folder.path(), &[&CALL[..], &["-", "--format", format]].concat());
        assert!(io::read(&run.stdout, Format::from_name(format)).unwrap().faces.len() > 9, "{format}");
    }
    assert!(list.contains("glb"), "{list}");
}

#[test]
fn weights_come_with_the_program() {
    let folder = folder_with_cloud();
    let run = run(folder.path(), &["mesh-points", "ball.xyz", "-o", "ball.ply", "--ratio", "0.5"]);
    // Random weights may keep no face, which is reported.
    if run.code == Some(1) {
        assert!(error_line(&run).contains("kept no face"));
        return;
    }
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(files(folder.path()), ["ball.ply", "ball.xyz", "w.safetensors"]);
}

#[test]
fn standard_streams_and_threads_change_no_byte() {
    let folder = folder_with_cloud();
    let file = std::fs::read(folder.path().join("ball.xyz")).unwrap();
    let through = |threads: &str| {
        let arguments = ["mesh-points", "-", "-o", "-", "--weights", "w.safetensors", "--format", "obj"];
        run_with_input(folder.path(), &[&arguments[..], &["--threads", threads]].concat(), &file)
    };
    let one = through("1");
    assert_eq!(one.code, Some(0), "{}", one.stderr);
    assert!(one.stdout.starts_with(b"v ") && one.stdout == through("3").stdout);
}

#[test]
fn points_far_from_the_origin_are_written_as_they_were_read() {
    let folder = folder_with_cloud();
    let cloud = shapes::icosphere(2);
    let far = |[x, y, z]: [f32; 3]| format!("{} {y} {z}", 5e6 + f64::from(x));
    let lines: Vec<String> = cloud.positions().iter().map(|&p| far(p)).collect();
    std::fs::write(folder.path().join("ball.xyz"), lines.join("\n")).unwrap();
    succeed(folder.path(), &[&CALL[..], &["ball.obj"]].concat());
    let written = std::fs::read_to_string(folder.path().join("ball.obj")).unwrap();
    let mut vertices = written.lines().filter_map(|line| line.strip_prefix("v "));
    assert!(vertices.all(|vertex| lines.iter().any(|line| line == vertex)));
}

#[test]
fn errors_are_one_line() {
    let folder = folder_with_cloud();
    for (content, reason) in [("", "no points"), ("1 2 3\n4 5\n", "line 2"), ("1 2 3\n4 5 6\n", "2 points are too few")]
    {
        std::fs::write(folder.path().join("ball.xyz"), content).unwrap();
        let line = refuse(folder.path(), &[&CALL[..], &["ball.ply"]].concat(), 1);
        assert!(line.contains("ball.xyz") && line.contains(reason), "{line}");
    }
    assert_eq!(files(folder.path()), ["ball.xyz", "w.safetensors"]);
}

#[test]
fn usage_is_checked_before_any_file() {
    let folder = folder();
    for bad in [
        &["-o", "a.ply", "--weights", "w", "--ratio", "0"][..],
        &["-o", "a.ply", "--weights", "w", "--ratio", "0.5", "--vertices", "9"],
        &["-o", "a.ply", "--weights", "w", "--threads", "0"],
        &["-o", "a.ply", "--weights", "w", "--report", "a.ply"],
        &["-o", "a.doc", "--weights", "w"],
    ] {
        let run = run(folder.path(), &[&["mesh-points", "missing.xyz"], bad].concat());
        assert_eq!(run.code, Some(2), "{bad:?}: {}", run.stderr);
    }
}
