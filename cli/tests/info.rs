//! `neural-mesh info` on one mesh and on many.

use std::fs;

use crate::common::avatar::Avatar;
use crate::common::*;
use serde_json::Value;

fn folder_of_meshes() -> tempfile::TempDir {
    let folder = folder_with_octahedron();
    fs::write(folder.path().join("b.obj"), OCTAHEDRON.strip_suffix("f 1 4 6\n").unwrap()).unwrap();
    fs::write(folder.path().join("bad.ply"), "ply").unwrap();
    folder
}

#[test]
fn each_mesh_has_a_block_of_its_own() {
    let folder = folder_of_meshes();
    let run = succeed(folder.path(), &["info", "a.obj", "b.obj"]);
    let words = String::from_utf8(run.stdout).unwrap();
    let firsts: Vec<&str> = words.split("\n\n").map(|block| block.lines().next().unwrap()).collect();
    assert_eq!(firsts, ["a.obj: 6 vertices, 12 edges, 8 faces", "b.obj: 6 vertices, 12 edges, 7 faces"]);
}

#[test]
fn json_is_a_line_for_each_mesh() {
    let folder = folder_of_meshes();
    let run = run(folder.path(), &["info", "--json", "a.obj", "b.obj"]);
    let lines: Vec<Value> =
        String::from_utf8(run.stdout).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let told: Vec<_> =
        lines.iter().map(|info| (info["file"].as_str().unwrap(), info["faces"].as_u64().unwrap())).collect();
    assert_eq!(told, [("a.obj", 8), ("b.obj", 7)]);
}

#[test]
fn unreadable_files_get_a_line_and_the_others_are_described() {
    let folder = folder_of_meshes();
    for json in [&[][..], &["--json"]] {
        let run = run(folder.path(), &[&["info", "a.obj", "bad.ply", "missing.ply", "b.obj"], json].concat());
        assert_eq!(run.code, Some(1));
        let complaints: Vec<&str> = run.stderr.lines().collect();
        assert_eq!(complaints.len(), 2, "{}", run.stderr);
        assert!(complaints[0].starts_with("neural-mesh: bad.ply: ply: "), "{}", run.stderr);
        assert!(complaints[1].starts_with("neural-mesh: missing.ply: "), "{}", run.stderr);
        let words = String::from_utf8(run.stdout).unwrap();
        assert!(words.contains("a.obj") && words.contains("b.obj"), "{words}");
    }
    error_line(&run(folder.path(), &["info", "bad.ply"]));
}

#[test]
fn standard_input_holds_one_mesh() {
    let folder = folder_of_meshes();
    let twice = run_with_input(folder.path(), &["info", "-", "-"], OCTAHEDRON.as_bytes());
    assert!(twice.code == Some(2) && error_line(&twice).contains("only one mesh can come from standard input"));
    let once = run_with_input(folder.path(), &["info", "b.obj", "-"], OCTAHEDRON.as_bytes());
    assert!(String::from_utf8(once.stdout).unwrap().contains("\n\nstandard input: 6 vertices"));
}

#[test]
fn attributes_of_a_mesh_are_listed() {
    let folder = folder();
    let textured =
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\nusemtl b\nf 3/3 2/2 1/1\n";
    fs::write(folder.path().join("a.obj"), textured).unwrap();
    let said = String::from_utf8(run(folder.path(), &["info", "a.obj"]).stdout).unwrap();
    assert!(said.contains("\nattributes  texture coordinates, 2 materials or groups\n"), "{said}");
    let folder_itself = run(folder.path(), &["info", "."]);
    assert!(error_line(&folder_itself).contains("is a folder: give the mesh files in it"), "{}", folder_itself.stderr);
}

#[test]
fn a_scene_is_listed() {
    let folder = folder();
    let glb = Avatar::new(8).vrm_1().glb();
    fs::write(folder.path().join("a.vrm"), &glb).unwrap();
    let said = String::from_utf8(run(folder.path(), &["info", "a.vrm"]).stdout).unwrap();
    for line in [
        "scene       4 nodes, 2 meshes, 1 material, 1 image, 1 skin, 1 animation",
        "mesh        ball: 642 vertices, 1,280 faces, 1 component, at 1 node",
        "materials   skin",
        "skins       skin 0 (2 joints)",
        "animations  nod (1.5 s)",
        "extensions  VRMC_vrm, VRMC_springBone, VRMC_node_constraint, VRMC_materials_mtoon",
    ] {
        assert!(said.lines().any(|said| said == line), "{line}: {said}");
    }
    assert!(said.contains("\nimage       face: 8 x 8, ") && said.contains(" bytes, PNG\n"), "{said}");
    for from in ["a.vrm", "-"] {
        let run = run_with_input(folder.path(), &["info", "--json", from], &glb);
        let info: Value = serde_json::from_slice(&run.stdout).unwrap();
        let scene = &info["scene"];
        assert_eq!((&info["faces"], &scene["meshes"][1]["faces"]), (&2560.into(), &1280.into()), "{from}");
        assert_eq!(scene["meshes"][0]["nodes"], serde_json::json!(["body"]));
        assert_eq!(scene["images"][0]["width"], 8);
        assert_eq!(scene["animations"], serde_json::json!([{"name": "nod", "seconds": 1.5}]));
    }
    assert!(info(folder.path(), "a.vrm").get("scene").is_some());
    assert!(!said.contains("stored"));
    let mut repeated = Avatar::new(8);
    repeated.document["nodes"][3]["mesh"] = 0.into();
    fs::write(folder.path().join("twice.glb"), repeated.glb()).unwrap();
    let said = String::from_utf8(run(folder.path(), &["info", "twice.glb"]).stdout).unwrap();
    assert!(said.starts_with("twice.glb: 1,926 vertices, 5,760 edges, 3,840 faces\n"), "{said}");
    assert!(said.contains("\nstored      1,284 vertices, 2,560 faces: sizes count each mesh once\n"), "{said}");
    fs::write(folder.path().join("a.obj"), OCTAHEDRON).unwrap();
    assert!(info(folder.path(), "a.obj").get("scene").is_none());
}
