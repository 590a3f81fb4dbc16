//! Standard output holds the mesh or JSON, and nothing else.

use std::fs;

use crate::common::*;
use neural_mesh::io::{Format, write};
use neural_mesh::mesh::{Frame, shapes};

fn simplify_pipe(input: &[u8], more: &[&str]) -> Run {
    let folder = folder();
    let run = run_with_input(folder.path(), &[&["simplify", "-", "-o", "-", "--ratio", "50%"], more].concat(), input);
    assert_eq!(files(folder.path()), Vec::<String>::new());
    run
}

#[test]
fn a_pipe_keeps_the_format_that_comes_in() {
    let mesh = shapes::icosphere(2);
    let bytes = |format| write(&mesh, &Frame::default(), format).unwrap();
    // Files next to a glTF are embedded in a GLB.
    for (before, after) in [
        (Format::Obj, Format::Obj),
        (Format::Ply, Format::Ply),
        (Format::PlyAscii, Format::Ply),
        (Format::Stl, Format::Stl),
        (Format::Off, Format::Off),
        (Format::Gltf, Format::Glb),
        (Format::Glb, Format::Glb),
    ] {
        let run = simplify_pipe(&bytes(before), &[]);
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        assert_eq!(Format::from_content(&run.stdout), Some(after), "{before:?}");
    }
    let run = simplify_pipe(&bytes(Format::Obj), &["--format", "off"]);
    assert_eq!(Format::from_content(&run.stdout), Some(Format::Off));
    assert_eq!(simplify_pipe(b"hello", &[]).code, Some(1));
}

#[test]
fn a_compressed_pipe_keeps_its_format_too() {
    let folder = folder();
    run_with_input(folder.path(), &["simplify", "-", "-o", "a.off.gz", "--ratio", "1"], OCTAHEDRON.as_bytes());
    let run = simplify_pipe(&fs::read(folder.path().join("a.off.gz")).unwrap(), &[]);
    assert_eq!(Format::from_content(&run.stdout), Some(Format::Off), "{}", run.stderr);
}

#[test]
fn a_file_to_standard_output_keeps_its_format() {
    let folder = folder_with_octahedron();
    fs::write(folder.path().join("a.dat"), OCTAHEDRON).unwrap();
    for name in ["a.obj", "a.dat"] {
        let run = run(folder.path(), &["simplify", name, "-o", "-", "--ratio", "1"]);
        assert_eq!((run.code, Format::from_content(&run.stdout)), (Some(0), Some(Format::Obj)), "{name}");
    }
}

#[test]
fn json_is_all_that_goes_to_standard_output() {
    let folder = folder_with_octahedron();
    for json in [&["--json"][..], &["--report", "-"]] {
        let arguments = ["simplify", "a.obj", "-o", "b.obj", "--ratio", "1", "--force", "--explain"];
        let run = succeed(folder.path(), &[&arguments[..], json].concat());
        let report: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
        assert_eq!((&report["output"]["faces"], &report["output"]["closed"]), (&8.into(), &true.into()));
        assert!(run.stderr.contains("size      6 vertices"), "{}", run.stderr);
    }
    assert_eq!(files(folder.path()), ["a.obj", "b.obj"]);
}

#[test]
fn standard_output_takes_one_of_mesh_and_report() {
    let folder = folder();
    for (command, json) in [
        ("simplify", &["--json", "--ratio", "1"][..]),
        ("simplify", &["--report", "-", "--ratio", "1"]),
        ("mesh-points", &["--report", "-"]),
    ] {
        let line = refuse(folder.path(), &[&[command, "missing.obj", "-o", "-", "--format", "obj"], json].concat(), 2);
        assert!(line.contains("the mesh or the report"), "{line}");
    }
    let line = refuse(folder.path(), &["simplify", ".", "-o", "out", "--ratio", "1", "--json"], 2);
    assert!(line.contains("--json"), "{line}");
}

#[test]
fn the_json_of_a_comparison_goes_to_standard_output_alone() {
    let folder = folder_with_octahedron();
    let run = succeed(folder.path(), &["compare", "a.obj", "a.obj", "--samples", "100", "--json", "-"]);
    let figures: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    assert_eq!(figures["results"][0]["name"], "a.obj");
    assert!(run.stderr.contains("original  a.obj"), "{}", run.stderr);
}

const SEAM: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvt 0.5 0.5\nvt 0.7 0.7\n\
f 1/1 2/2 3/3\nf 1/5 3/6 4/4\n";

#[test]
fn vertices_are_counted_as_written_too() {
    let folder = folder();
    fs::write(folder.path().join("a.obj"), SEAM).unwrap();
    for (name, written) in
        [("b.obj", Some(4)), ("b.off", Some(4)), ("b.ply", Some(6)), ("b.glb", Some(6)), ("b.stl", None)]
    {
        let words = succeed(folder.path(), &["simplify", "a.obj", "-o", name, "--ratio", "1"]);
        let words = String::from_utf8(words.stdout).unwrap();
        assert_eq!(words.contains("written   6 vertices"), written == Some(6), "{name}: {words}");
        let json = run(folder.path(), &["simplify", "a.obj", "-o", name, "--ratio", "1", "--force", "--json"]);
        let report: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
        assert_eq!(report["output"]["vertices"], 4);
        assert_eq!(report["output"].get("vertices_written").and_then(|n| n.as_u64()), written, "{name}");
    }
    // A scene and its levels; `info` counts without welding.
    let arguments = ["simplify", "b.glb", "-o", "c.glb", "--lods", "1,0.75", "--json"];
    let report: serde_json::Value = serde_json::from_slice(&run(folder.path(), &arguments).stdout).unwrap();
    for (level, n_written) in [(0, 6), (1, 3)] {
        assert_eq!(report["levels"][level]["vertices_written"], n_written);
    }
    let split = run(folder.path(), &["info", "b.glb", "--no-weld", "--json"]);
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&split.stdout).unwrap()["vertices"], 6);
}
