//! Extreme requests and meshes get useful answers.

use crate::common::*;
use serde_json::Value;

fn simplify_text(mesh: &str, arguments: &[&str]) -> (Option<i32>, Value, Value) {
    let folder = folder();
    let all = [&["simplify", "-", "-o", "a.obj", "--report", "r.json"], arguments].concat();
    let run = run_with_input(folder.path(), &all, mesh.as_bytes());
    if run.code == Some(0) {
        (run.code, json(&folder.path().join("r.json")), info(folder.path(), "a.obj"))
    } else {
        error_line(&run);
        assert_eq!(files(folder.path()), Vec::<String>::new());
        (run.code, Value::Null, Value::Null)
    }
}

#[test]
fn the_whole_mesh_is_written_as_it_is() {
    for size in
        [["--ratio", "1"], ["--vertices", "6"], ["--vertices", "1000"], ["--faces", "8"], ["--faces", "99999999"]]
    {
        let (code, report, info) = simplify_text(OCTAHEDRON, &size);
        assert_eq!(code, Some(0), "{size:?}");
        assert_eq!((&info["vertices"], &info["faces"]), (&6.into(), &8.into()), "{size:?}");
        assert_eq!(report["outcome"], "reached", "{size:?}");
        assert!(report["distance"]["max_percent"].as_f64().unwrap() < 1e-9);
    }
}

#[test]
fn positions_that_stay_keep_every_digit() {
    let folder = folder();
    let mesh = OCTAHEDRON.replace("v 1 0 0", "v 1.234567890123456 0 1e-17");
    let run = run_with_input(folder.path(), &["simplify", "-", "-o", "a.obj", "--ratio", "1"], mesh.as_bytes());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let text = std::fs::read_to_string(folder.path().join("a.obj")).unwrap();
    let x: f64 = text.split(' ').nth(1).unwrap().parse().unwrap();
    let z: f64 = text.lines().next().unwrap().rsplit(' ').next().unwrap().parse().unwrap();
    assert_eq!((x, z), (1.234567890123456, 1e-17), "{text}");
}

#[test]
fn a_mesh_without_faces_is_refused() {
    for mesh in ["v 0 0 0\n", "# nothing\n", "v 0 0 0\nv 1 0 0\nf 1 2\n", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n"] {
        assert_eq!(simplify_text(mesh, &["--ratio", "0.5"]).0, Some(1), "{mesh:?}");
    }
}

#[test]
fn one_face_stays() {
    let (code, _, info) = simplify_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &["--ratio", "0.1"]);
    assert_eq!((code, &info["faces"]), (Some(0), &1.into()));
}

#[test]
fn a_tetrahedron_is_the_smallest_closed_mesh() {
    let tetrahedron = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
    let (code, report, info) = simplify_text(tetrahedron, &["--faces", "1"]);
    assert_eq!((code, &info["faces"], &info["closed"]), (Some(0), &4.into(), &true.into()));
    assert_ne!(report["outcome"], "reached");
}

#[test]
fn a_closed_mesh_stops_at_its_smallest_closed_form() {
    let (code, report, info) = simplify_text(&sphere(1, 8, [0.0; 3], 1.0), &["--vertices", "1"]);
    assert_eq!(
        (code, &info["vertices"], &info["closed"], &info["manifold"]),
        (Some(0), &4.into(), &true.into(), &true.into())
    );
    assert_ne!(report["outcome"], "reached");
}

#[test]
fn vertices_in_one_point_or_plane_do_no_harm() {
    let point: String = OCTAHEDRON.replace("v 1 0 0", "v 0 0 0").replace("-1", "0").replace(" 1 0\n", " 0 0\n");
    assert_eq!(simplify_text(&point.replace("v 0 0 1", "v 0 0 0"), &["--ratio", "0.5"]).0, Some(1));
    let one = OCTAHEDRON.lines().map(|line| if line.starts_with('v') { "v 2 2 2" } else { line });
    let (code, ..) = simplify_text(&one.collect::<Vec<_>>().join("\n"), &["--ratio", "0.5", "--no-weld"]);
    assert!(code == Some(0) || code == Some(1));
    let flat = sphere(1, 6, [0.0; 3], 1.0).lines().map(flatten_vertex).collect::<String>();
    let (code, _, info) = simplify_text(&flat, &["--ratio", "0.5"]);
    assert_eq!(code, Some(0));
    assert!(info["faces"].as_u64().unwrap() > 0);
}

fn flatten_vertex(line: &str) -> String {
    match line.strip_prefix("v ").and_then(|numbers| numbers.rsplit_once(' ')) {
        Some((xy, _)) => format!("v {xy} 0\n"),
        None => format!("{line}\n"),
    }
}

#[test]
fn components_below_a_size_are_dropped_and_no_others() {
    let large = sphere(1, 16, [0.0; 3], 1.0);
    let n_large = large.lines().filter(|line| line.starts_with('v')).count();
    // Diagonals of the boxes: 3.46 and 0.035; of both together 4.9.
    let both = large + &sphere(n_large + 1, 8, [3.0, 0.0, 0.0], 0.01);
    for (size, n_left) in [("0.03", 2), ("0.04", 1), ("0.5%", 2), ("1%", 1), ("1000", 1)] {
        let (code, report, info) = simplify_text(&both, &["--ratio", "0.5", &format!("--prune={size}")]);
        assert_eq!((code, &info["components"], &info["closed"]), (Some(0), &n_left.into(), &true.into()), "{size}");
        assert_eq!(report["output"]["components_pruned"], 2 - n_left, "{size}");
    }
    for wrong in ["--prune=x", "--prune=-1", "--prune=1%%"] {
        assert_eq!(simplify_text(&both, &["--ratio", "0.5", wrong]).0, Some(2), "{wrong}");
    }
}

#[test]
fn components_below_a_size_go_where_the_mesh_is_as_small_as_asked_already() {
    let large = sphere(1, 8, [0.0; 3], 1.0);
    let n_large = large.lines().filter(|line| line.starts_with('v')).count();
    let both = large + &sphere(n_large + 1, 4, [3.0, 0.0, 0.0], 0.01);
    let targets =
        [["--ratio", "1"], ["--vertices", "100000"], ["--faces", "100000"], ["--size", "1MB"], ["--error", "90%"]];
    for target in targets {
        let (code, report, info) = simplify_text(&both, &[&target[..], &["--prune=1%"]].concat());
        assert_eq!((code, &info["components"], &info["closed"]), (Some(0), &1.into(), &true.into()), "{target:?}");
        assert_eq!(report["output"]["components_pruned"], 1, "{target:?}");
        let n = info["vertices"].as_u64().unwrap() as usize;
        assert!(n == n_large || target[0] == "--error" && n < n_large, "{target:?}: {n}");
    }
    let (code, report, info) = simplify_text(&both, &["--ratio", "1", "--prune=0.1%"]);
    assert_eq!((code, &info["components"]), (Some(0), &2.into()));
    assert_eq!(report["output"]["components_pruned"], 0);
    // The large sphere keeps its vertices, the small one is dropped.
    let folder = folder();
    let run = run_with_input(folder.path(), &MAPPED, both.as_bytes());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let map = json(&folder.path().join("m.json"));
    let outputs = map["output_vertices"].as_array().unwrap();
    assert_eq!(outputs.iter().filter(|x| x.is_u64()).count(), n_large);
    assert!(outputs[n_large..].iter().all(Value::is_null));
    assert_eq!(map["input_vertices"].as_array().unwrap().len(), n_large);
}

const MAPPED: [&str; 8] = ["simplify", "-", "-o", "a.obj", "--ratio", "1", "--prune=1%", "--map=m.json"];

#[test]
fn components_that_touch_at_a_vertex_are_dropped_and_counted_as_in_the_report() {
    let large = sphere(1, 16, [0.0; 3], 1.0);
    let n_large = large.lines().filter(|line| line.starts_with('v')).count();
    // Two small tetrahedra touch the top of the sphere, 0 1 0, the first vertex.
    let tetrahedron = |n: usize, x: f64| {
        format!(
            "v {x} 1.01 0\nv 0 1.01 {x}\nv {x} 1.01 {x}\nf 1 {n} {}\nf 1 {} {}\nf 1 {} {n}\nf {n} {} {}\n",
            n + 1,
            n + 1,
            n + 2,
            n + 2,
            n + 2,
            n + 1
        )
    };
    let touching = large + &tetrahedron(n_large + 1, 0.01) + &tetrahedron(n_large + 4, -0.02);
    for size in ["--ratio=1", "--ratio=0.5", "--ratio=0.1"] {
        for (prune, n_left) in [("--prune=1%", 1), ("--prune=0.6%", 2), ("--prune=0.1%", 3)] {
            let (code, report, info) = simplify_text(&touching, &[size, prune, "--keep-components"]);
            assert_eq!(report["input"]["components"], 3);
            assert_eq!((code, &info["components"]), (Some(0), &n_left.into()), "{size} {prune}");
            assert_eq!(report["output"]["components_pruned"], 3 - n_left, "{size} {prune}");
        }
    }
    let (code, report, info) = simplify_text(&touching, &["--ratio=0.05"]);
    assert_eq!((code, &info["components"]), (Some(0), &1.into()));
    assert_eq!(report["output"]["components_pruned"], 2);
}

#[test]
fn vertices_that_nearly_meet_are_welded_where_that_is_asked_for() {
    let octahedron: Vec<&str> = OCTAHEDRON.lines().filter(|line| !line.is_empty()).collect();
    let corners: Vec<&str> = octahedron.iter().filter(|line| line.starts_with("v ")).copied().collect();
    let faces = octahedron.iter().filter(|line| line.starts_with("f "));
    // Each face has its own vertices, slightly displaced.
    let (mut text, mut n) = (String::new(), 0);
    for (number, face) in faces.enumerate() {
        for corner in face.split(' ').skip(1) {
            let xyz = corners[corner.split('/').next().unwrap().parse::<usize>().unwrap() - 1];
            let numbers = xyz.split(' ').skip(1).map(|x| x.parse::<f64>().unwrap() + 1e-4 * number as f64);
            text += &numbers.fold("v".to_string(), |line, x| format!("{line} {x}"));
            text.push('\n');
        }
        n += 3;
        text += &format!("f {} {} {n}\n", n - 2, n - 1);
    }
    let (code, _, info) = simplify_text(&text, &["--ratio", "1"]);
    assert_eq!((code, &info["vertices"], &info["closed"]), (Some(0), &24.into(), &false.into()));
    for distance in ["0.01", "0.5%"] {
        let (code, report, info) = simplify_text(&text, &["--ratio", "1", "--weld", distance]);
        assert_eq!((code, &info["vertices"], &info["closed"]), (Some(0), &6.into(), &true.into()), "{distance}");
        assert_eq!(report["cleaned"]["welded_vertices"], 18, "{distance}");
    }
    assert_eq!(simplify_text(&text, &["--ratio", "1", "--weld", "0.0001"]).2["vertices"], 24);
    for wrong in [["--weld", "far"], ["--weld", "-1"]] {
        assert_eq!(simplify_text(&text, &[["--ratio", "1"], wrong].concat()).0, Some(2), "{wrong:?}");
    }
}

#[test]
fn a_weld_that_leaves_no_face_is_named() {
    let folder = folder_with_octahedron();
    succeed(folder.path(), &["simplify", "a.obj", "-o", "a.glb", "--ratio", "1", "--quiet"]);
    for input in ["a.obj", "a.glb"] {
        let line = refuse(folder.path(), &["simplify", input, "-o", "b.glb", "--ratio", "1", "--weld", "1000%"], 1);
        assert_eq!(line, format!("neural-mesh: {input}: --weld 1000%: no face is left: give a smaller distance"));
    }
}

#[test]
fn a_tiny_component_goes_where_it_costs_more_than_it_shows() {
    let large = sphere(1, 16, [0.0; 3], 1.0);
    let n_large = large.lines().filter(|line| line.starts_with('v')).count();
    let both = large + &sphere(n_large + 1, 4, [3.0, 0.0, 0.0], 0.001);
    for (options, n_left) in [
        (&["--ratio", "0.1"][..], 1),
        (&["--ratio", "0.02", "--prune"], 1),
        (&["--error", "5%"], 2),
        (&["--error", "5%", "--prune"], 1),
        (&["--ratio", "0.1", "--keep-components"], 2),
        (&["--ratio", "0.1", "--subset"], 2),
        (&["--ratio", "1"], 2),
    ] {
        let (code, report, info) = simplify_text(&both, options);
        assert_eq!(
            (code, &info["components"], &info["closed"]),
            (Some(0), &n_left.into(), &true.into()),
            "{options:?}"
        );
        assert_eq!(report["output"]["components_pruned"], 2 - n_left, "{options:?}");
        assert_eq!(report["outcome"], "reached");
    }
}
