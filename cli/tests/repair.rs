//! Broken meshes become closed, oriented solids.

use std::fmt::Write as _;

use base64::prelude::*;
use neural_mesh::mesh::topology;
use neural_mesh::metrics::volume;
use serde_json::json;

use crate::common::{
    OCTAHEDRON, error_line, files, folder, folder_with_octahedron, info, read_welded, refuse, run, sphere, succeed,
};

fn remove_each_nth_face(text: &str, nth: usize) -> String {
    let mut n_faces = 0;
    let keeps = |line: &&str| {
        n_faces += usize::from(line.starts_with('f'));
        !line.starts_with('f') || !n_faces.is_multiple_of(nth)
    };
    text.lines().filter(keeps).flat_map(|line| [line, "\n"]).collect()
}

fn reverse_faces(text: &str) -> String {
    let turned = |line: &str| {
        let corners: Vec<&str> = line.split(' ').skip(1).collect();
        format!("f {}", corners.into_iter().rev().collect::<Vec<_>>().join(" "))
    };
    text.lines().map(|line| if line.starts_with('f') { turned(line) } else { line.into() } + "\n").collect()
}

fn n_vertices(text: &str) -> usize {
    text.lines().filter(|line| line.starts_with('v')).count()
}

fn messy() -> String {
    let mut text = remove_each_nth_face(&sphere(1, 24, [0.0; 3], 1.0), 40);
    let more = |text: &mut String, rings, centre, radius, turned: bool| {
        let shell = sphere(n_vertices(text) + 1, rings, centre, radius);
        *text += &if turned { reverse_faces(&shell) } else { shell };
    };
    more(&mut text, 8, [0.4, 0.0, 0.0], 0.2, false);
    more(&mut text, 8, [-0.4, 0.0, 0.0], 0.2, true);
    for i in 0..100 {
        let centre = [1.7, 0.83, 2.9].map(|step| (step * f64::from(i)).sin() * 1.5);
        more(&mut text, 3, centre, 0.002, i % 2 == 0);
    }
    let n = n_vertices(&text);
    write!(text, "v 0.3 1.4 0.2\nf 1 3 {}\n", n + 1).unwrap();
    for i in 0..9 {
        writeln!(text, "v {} -1.3 {}", i % 3, i / 3).unwrap();
    }
    for i in [0, 1, 3, 4] {
        let at = n + 2 + i;
        writeln!(text, "f {at} {} {} {}", at + 1, at + 4, at + 3).unwrap();
    }
    text
}

/// Volume of the sphere minus its cavity, approximately.
const SOLID: f64 = 4.0 / 3.0 * std::f64::consts::PI * (1.0 - 0.008);

#[test]
fn results_are_solid_in_every_format_at_every_size() {
    let folder = folder();
    std::fs::write(folder.path().join("messy.obj"), messy()).unwrap();
    for (name, ratio) in [("a.stl", "0.5"), ("b.ply", "0.2"), ("c.obj", "0.1"), ("d.stl", "0.05"), ("e.stl", "1")] {
        let asked = ["simplify", "messy.obj", "-o", name, "--ratio", ratio, "--printable", "--report", "r.json", "-f"];
        let done = succeed(folder.path(), &asked);
        let solid = read_welded(&folder.path().join(name));
        assert!(topology(&solid).is_closed_manifold(), "{name}: {:?}", topology(&solid));
        assert_eq!(topology(&solid).components, 2, "{name}");
        let volume = volume(&solid).unwrap();
        assert!((volume / SOLID - 1.0).abs() < 0.1, "{name}: {volume}");
        let report = &crate::common::json(&folder.path().join("r.json"))["repaired"];
        assert_eq!((&report["components_dropped"], &report["holes_left"]), (&102.into(), &0.into()), "{report}");
        assert!(report["holes_filled"].as_u64().unwrap() > 20 && report["faces_added"].as_u64().unwrap() > 40);
        let said = String::from_utf8(done.stdout).unwrap();
        assert_eq!(said.lines().filter(|line| line.starts_with("repaired  holes filled: ")).count(), 1, "{said}");
    }
}

// Surfaces of suzanne touch at vertices, in double precision; once separated, they stay so unless merged.
#[test]
fn separated_surfaces_stay_separate_at_full_size() {
    let folder = folder();
    let suzanne = crate::common::test_mesh_path("suzanne.ply");
    for name in ["a.ply", "a.obj", "a.stl"] {
        let asked = ["simplify", suzanne.to_str().unwrap(), "-o", name, "--ratio", "1", "--printable"];
        succeed(folder.path(), &asked);
        let solid = topology(&read_welded(&folder.path().join(name)));
        assert!(solid.is_closed_manifold(), "{name}: {solid:?}");
    }
}

#[test]
fn holes_are_filled_up_to_the_length_asked_for() {
    let folder = folder();
    std::fs::write(folder.path().join("torn.obj"), remove_each_nth_face(&sphere(1, 24, [0.0; 3], 1.0), 40)).unwrap();
    let filled = |option: &str| {
        let asked = ["simplify", "torn.obj", "-o", "a.stl", "--ratio", "0.5", option, "--report", "r.json", "-f"];
        succeed(folder.path(), &asked);
        let report = crate::common::json(&folder.path().join("r.json"))["repaired"].clone();
        (topology(&read_welded(&folder.path().join("a.stl"))).closed, report["holes_left"] == 0)
    };
    assert_eq!(filled("--fill-holes"), (true, true));
    assert_eq!(filled("--fill-holes=3"), (false, false));
    assert_eq!(filled("--fill-holes=4"), (true, true));
}

#[test]
fn meshes_without_volume_are_refused_in_one_line() {
    let folder = folder();
    for sheet in ["v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"] {
        std::fs::write(folder.path().join("sheet.obj"), sheet).unwrap();
        let line = refuse(folder.path(), &["simplify", "sheet.obj", "-o", "a.stl", "--ratio", "0.5", "--printable"], 1);
        assert!(line.contains("no component encloses a volume"), "{line}");
        assert_eq!(files(folder.path()), ["sheet.obj"]);
    }
}

#[test]
fn excluded_combinations_are_usage_errors() {
    let folder = folder_with_octahedron();
    let printable = ["--printable", "--printable=1%"];
    for options in [["--printable=small", "--strict"], ["--fill-holes=-1", "--strict"], ["--printable", "--fill-holes"]]
        .into_iter()
        .chain(printable.into_iter().map(|option| [option, "--no-weld"]))
    {
        let asked = [&["simplify", "a.obj", "-o", "b.stl", "--ratio", "0.5"], &options[..]].concat();
        assert_eq!(run(folder.path(), &asked).code, Some(2), "{options:?}");
    }
    let paper = ["simplify", "a.obj", "-o", "b.stl", "--ratio", "0.5", "--printable", "--assembly", "paper"];
    assert!(error_line(&run(folder.path(), &paper)).contains("--printable: not available with --assembly paper"));
}

fn scene_of_two(text: &str) -> String {
    let numbers = |first: char| -> Vec<f64> {
        let lines = text.lines().filter(|line| line.starts_with(first));
        lines.flat_map(|line| line.split(' ').skip(1).map(|x| x.parse().unwrap())).collect()
    };
    let (positions, corners) = (numbers('v'), numbers('f'));
    let mut bytes: Vec<u8> = positions.iter().flat_map(|&x| (x as f32).to_le_bytes()).collect();
    let n_front = bytes.len();
    bytes.extend(corners.iter().flat_map(|&x| (x as u32 - 1).to_le_bytes()));
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&bytes));
    let mesh = json!({"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]});
    json!({
        "asset": {"version": "2.0"}, "buffers": [{"byteLength": bytes.len(), "uri": uri}],
        "bufferViews": [
            {"buffer": 0, "byteLength": n_front},
            {"buffer": 0, "byteOffset": n_front, "byteLength": bytes.len() - n_front}
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": positions.len() / 3,
                "min": [-1, -1, -1], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": corners.len()}
        ],
        "meshes": [mesh, mesh], "nodes": [{"mesh": 0}, {"mesh": 1, "translation": [3, 0, 0]}],
        "scenes": [{"nodes": [0, 1]}], "scene": 0
    })
    .to_string()
}

#[test]
fn a_scene_of_several_meshes_is_no_solid_but_loses_its_holes() {
    let folder = folder();
    let scene = scene_of_two(&remove_each_nth_face(OCTAHEDRON, 5));
    std::fs::write(folder.path().join("scene.gltf"), scene).unwrap();
    let asked = |output, option| run(folder.path(), &["simplify", "scene.gltf", "-o", output, "--ratio", "1", option]);
    let refused = asked("a.glb", "--printable");
    assert!(refused.code == Some(2) && error_line(&refused).contains("--printable: a scene of several meshes"));
    assert_eq!(asked("a.stl", "--printable").code, Some(0));
    assert_eq!(asked("b.glb", "--fill-holes").code, Some(0));
    assert!(info(folder.path(), "b.glb")["closed"].as_bool().unwrap());
}

#[test]
fn a_batch_repairs_each_mesh() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("in")).unwrap();
    std::fs::write(folder.path().join("in/messy.obj"), messy()).unwrap();
    std::fs::write(folder.path().join("in/sheet.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let asked = ["simplify", "in", "-o", "out", "--ratio", "0.3", "--printable", "--format", "stl"];
    assert_eq!(run(folder.path(), &asked).code, Some(1));
    assert!(topology(&read_welded(&folder.path().join("out/messy.stl"))).is_closed_manifold());
    let rows = std::fs::read_to_string(folder.path().join("out/manifest.csv")).unwrap();
    assert!(rows.contains("--printable") && rows.contains("no component encloses a volume"), "{rows}");
}
