//! `--hidden`: invisible components are dropped.

use neural_mesh::mesh::{TriMesh, topology};
use serde_json::Value;

use crate::common::*;

fn shells() -> String {
    let mut text = sphere(1, 40, [0.0; 3], 1.0);
    for (rings, centre, radius) in [(40, [0.0, 0.05, 0.0], 0.8), (10, [0.1, 0.0, 0.0], 0.3), (6, [2.0, 0.0, 0.0], 0.2)]
    {
        let first = 1 + text.lines().filter(|line| line.starts_with("v ")).count();
        text += &sphere(first, rings, centre, radius);
    }
    text
}

fn simplify_shells(options: &[&str]) -> (TriMesh, Value, usize) {
    let folder = folder();
    std::fs::write(folder.path().join("in.obj"), shells()).unwrap();
    let asked = [&["simplify", "in.obj", "-o", "out.ply", "--report", "r.json"], options].concat();
    succeed(folder.path(), &asked);
    let mesh = read_welded(&folder.path().join("out.ply"));
    let is_outer = |p: &&[f32; 3]| (p.iter().map(|x| x * x).sum::<f32>().sqrt() - 1.0).abs() < 0.06;
    let n_outer = mesh.positions().iter().filter(is_outer).count();
    (mesh, json(&folder.path().join("r.json")), n_outer)
}

#[test]
fn hidden_components_give_vertices_to_visible_ones() {
    let size = ["--vertices", "400"];
    let asked = |hidden: &'static str| simplify_shells(&[&size[..], &["--hidden", hidden]].concat());
    let (keep, drop) = (asked("keep"), asked("drop"));
    for (mesh, report, _) in [&keep, &drop] {
        assert!(topology(mesh).is_closed_manifold());
        assert_eq!(report["outcome"], "reached");
    }
    assert_eq!(topology(&drop.0).components, 2);
    assert_eq!(
        (&drop.1["output"]["components_pruned"], &drop.1["output"]["components_hidden"]),
        (&2.into(), &2.into())
    );
    let [keep, drop] = [keep.2, drop.2];
    assert!(drop as f64 > 1.4 * keep as f64, "{keep} {drop}");
}

#[test]
fn hidden_components_are_dropped_at_any_target() {
    for options in [["--ratio", "1"], ["--error", "1%"], ["--lods", "0.5,0.1"]] {
        let folder = folder();
        std::fs::write(folder.path().join("in.obj"), shells()).unwrap();
        let asked = [&["simplify", "in.obj", "-o", "out.ply", "--hidden", "drop"], &options[..]].concat();
        let done = succeed(folder.path(), &asked);
        let said = String::from_utf8(done.stdout).unwrap();
        assert!(said.contains("hidden    2 components dropped: they are invisible from outside"), "{said}");
        for name in files(folder.path()).iter().filter(|name| name.ends_with(".ply")) {
            let mesh = read_welded(&folder.path().join(name));
            assert!(topology(&mesh).is_closed_manifold() && topology(&mesh).components == 2, "{name} {options:?}");
        }
    }
}

#[test]
fn excluded_combinations_are_usage_errors() {
    let folder = folder_with_octahedron();
    for other in [&["--assembly", "paper"][..], &["--hidden", "away"]] {
        let asked = [&["simplify", "a.obj", "-o", "b.ply", "--ratio", "0.5", "--hidden", "drop"], other].concat();
        assert_eq!(run(folder.path(), &asked).code, Some(2), "{other:?}");
        assert_eq!(files(folder.path()), ["a.obj"]);
    }
}
