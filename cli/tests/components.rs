//! Scenes of many components.

use base64::prelude::*;
use neural_mesh::io::Asset;
use neural_mesh::mesh::{RawMesh, TriMesh, shapes};
use neural_mesh::metrics::{Surface, surface_distance};
use serde_json::{Value, json};

use crate::common::{folder, json as read_json, run, succeed};

fn scene_of(meshes: &[TriMesh], nodes: &Value) -> String {
    let (mut bytes, mut views, mut accessors) = (Vec::new(), Vec::new(), Vec::new());
    let mut put = |rows: Vec<u8>, component: u32, shape: &str, count: usize, bounds: [Value; 2]| {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": rows.len()}));
        bytes.extend(rows);
        let [min, max] = bounds;
        accessors
            .push(json!({"bufferView": views.len() - 1, "componentType": component, "type": shape, "count": count,
            "min": min, "max": max}));
        accessors.len() - 1
    };
    let mut described = Vec::new();
    for mesh in meshes {
        let n = mesh.faces().len();
        let rows = mesh.positions().as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        let bound = |choose: fn(f32, f32) -> f32, from: f32| {
            json!([0, 1, 2].map(|axis| mesh.positions().iter().map(|p| p[axis]).fold(from, choose)))
        };
        let bounds = [bound(f32::min, f32::INFINITY), bound(f32::max, f32::NEG_INFINITY)];
        let positions = put(rows, 5126, "VEC3", mesh.positions().len(), bounds);
        let rows = mesh.faces().as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
        let last = mesh.positions().len() - 1;
        let indices = put(rows, 5125, "SCALAR", 3 * n, [json!([0]), json!([last])]);
        described.push(json!({"primitives": [{"attributes": {"POSITION": positions}, "indices": indices}]}));
    }
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(&bytes));
    let roots: Vec<usize> = (0..nodes.as_array().unwrap().len()).collect();
    json!({
        "asset": {"version": "2.0"}, "buffers": [{"byteLength": bytes.len(), "uri": uri}], "bufferViews": views,
        "accessors": accessors, "meshes": described, "nodes": nodes, "scenes": [{"nodes": roots}], "scene": 0
    })
    .to_string()
}

fn read_scene_mesh(path: &std::path::Path) -> TriMesh {
    let asset = Asset::read_path(path).unwrap();
    let meshes: Vec<RawMesh> = asset.parts().iter().map(|part| part.mesh.clone()).collect();
    let scene = asset.scene_mesh(&meshes).unwrap();
    let positions = scene.positions.iter().map(|p| p.map(|x| x as f32)).collect();
    TriMesh::new(positions, scene.faces).unwrap()
}

fn scale_mesh(mesh: &TriMesh, by: f32) -> TriMesh {
    TriMesh::new(mesh.positions().iter().map(|p| p.map(|x| by * x)).collect(), mesh.faces().to_vec()).unwrap()
}

fn nine_spheres() -> String {
    let scale = |i: u32| if i == 8 { 4.0 } else { 1.0 };
    let node =
        |i: u32| json!({"mesh": i, "translation": [2.5 * f64::from(i), 0, 0], "scale": [scale(i), scale(i), scale(i)]});
    let nodes: Vec<Value> = (0..9).map(node).collect();
    scene_of(&vec![shapes::icosphere(2); 9], &nodes.into())
}

#[test]
fn meshes_that_nodes_place_apart_all_come_back() {
    let folder = folder();
    std::fs::write(folder.path().join("in.gltf"), nine_spheres()).unwrap();
    for size in [["--ratio", "0.3"], ["--error", "2%"], ["--faces", "500"]] {
        let [option, value] = size;
        let asked = ["simplify", "in.gltf", "-o", "out.glb", option, value, "--report", "r.json", "--force"];
        assert_eq!(run(folder.path(), &asked).code, Some(0), "{size:?}");
        let asset = Asset::read_path(&folder.path().join("out.glb")).unwrap();
        assert_eq!(asset.parts().len(), 9, "{size:?}");
        let report = read_json(&folder.path().join("r.json"));
        let [before, after] = ["in.gltf", "out.glb"].map(|name| read_scene_mesh(&folder.path().join(name)));
        let measured =
            surface_distance(&Surface::new(&before, 30_000, 1), &Surface::new(&after, 30_000, 2)).unwrap().both;
        let percent = 100.0 / before.diagonal();
        let said = report["distance"]["mean_percent"].as_f64().unwrap();
        assert!((said / (percent * measured.mean) - 1.0).abs() < 0.1, "{size:?}: {said} {}", percent * measured.mean);
        assert!(report["distance"]["max_percent"].as_f64().unwrap() > 0.9 * percent * measured.max);
        if option == "--error" {
            let upper = report["certified"]["upper_percent"].as_f64().unwrap();
            assert!(upper <= 2.0 && percent * measured.max <= upper, "{upper} {}", percent * measured.max);
        }
    }
}

#[test]
fn components_give_way_to_the_size_unless_shapes_are_held() {
    let folder = folder();
    let panes = vec![shapes::grid(2, 2); 12];
    let nodes: Vec<Value> = (0..12).map(|i| json!({"mesh": i, "translation": [1.5 * f64::from(i), 0, 0]})).collect();
    std::fs::write(folder.path().join("in.gltf"), scene_of(&panes, &nodes.into())).unwrap();
    let asked = ["simplify", "in.gltf", "-o", "reached.glb", "--faces", "6", "--report", "f.json", "--strict"];
    let done = run(folder.path(), &asked);
    assert!(done.code == Some(3) && done.stderr.contains("the size has its price"), "{}", done.stderr);
    assert!(String::from_utf8_lossy(&done.stdout).contains("missed least at this size"));
    let report = read_json(&folder.path().join("f.json"));
    assert_eq!((&report["outcome"], &report["output"]["faces"]), (&json!("reached"), &json!(6)));
    assert_eq!(report["output"]["size_with_shape"], json!([48, 24]));
    let held = ["simplify", "in.gltf", "-o", "out.glb", "--ratio", "0.1", "--hold-shape", "--report", "r.json"];
    let done = run(folder.path(), &held);
    assert!(String::from_utf8_lossy(&done.stdout).contains("change the shape of components"), "{}", done.stderr);
    let report = read_json(&folder.path().join("r.json"));
    assert!(report["distance"]["max_percent"].as_f64().unwrap() < 0.01, "{report}");
    assert_eq!(report["output"]["vertices"], 48);
    // With --prune, small ones are dropped.
    let asked = ["simplify", "in.gltf", "-o", "none.glb", "--ratio", "0.1", "--prune=99%", "--report", "p.json"];
    assert_eq!(run(folder.path(), &asked).code, Some(0));
    let report = read_json(&folder.path().join("p.json"));
    let dropped = report["output"]["dropped"].as_array().unwrap();
    assert_eq!((dropped.len(), dropped[0]["faces"].as_u64()), (11, Some(shapes::grid(2, 2).faces().len() as u64)));
    assert!(dropped[0]["name"].as_str().unwrap().starts_with("mesh 0"), "{dropped:?}");
    // Nodes that lost their mesh remain and draw nothing.
    let text = String::from_utf8_lossy(&std::fs::read(folder.path().join("none.glb")).unwrap()).into_owned();
    assert_eq!(text.matches("\"translation\"").count(), 12);
    assert_eq!(text.matches("\"mesh\":").count(), 1, "{text}");
}

fn chequered_plane(n: usize) -> String {
    let mut text = String::from("mtllib tiles.mtl\n");
    let sphere = shapes::icosphere(3);
    let tiles = (0..(n + 1) * (n + 1)).map(|k| [(k % (n + 1)) as f32 / n as f32, (k / (n + 1)) as f32 / n as f32, 0.0]);
    for [x, y, z] in tiles.chain(sphere.positions().iter().map(|p| [0.4 * p[0], 0.4 * p[1], 1.0 + 0.4 * p[2]])) {
        text += &format!("v {x} {y} {z}\n");
    }
    for colour in 0..2 {
        text += &format!("usemtl {}\n", ["black", "white"][colour]);
        for (i, j) in (0..n * n).map(|tile| (tile % n, tile / n)).filter(|(i, j)| (i + j) % 2 == colour) {
            let k = j * (n + 1) + i + 1;
            text += &format!("f {} {} {} {}\n", k, k + 1, k + n + 2, k + n + 1);
        }
    }
    let first = (n + 1) * (n + 1) + 1;
    sphere.faces().iter().for_each(|f| {
        text += &format!("f {} {} {}\n", f[0] as usize + first, f[1] as usize + first, f[2] as usize + first)
    });
    text
}

#[test]
fn tiles_of_two_materials_in_one_plane_keep_their_outlines_beside_others() {
    let folder = folder();
    std::fs::write(folder.path().join("in.obj"), chequered_plane(8)).unwrap();
    std::fs::write(folder.path().join("tiles.mtl"), "newmtl black\nKd 0 0 0\nnewmtl white\nKd 1 1 1\n").unwrap();
    succeed(folder.path(), &["simplify", "in.obj", "-o", "out.obj", "--ratio", "0.1", "--hold-shape"]);
    let text = std::fs::read_to_string(folder.path().join("out.obj")).unwrap();
    let on_grid = |line: &str| {
        let place: Vec<f64> = line.split_whitespace().skip(1).map(|x| x.parse().unwrap()).collect();
        place[2] < 0.1 && place[..2].iter().all(|x| ((8.0 * x).round() - 8.0 * x).abs() < 1e-3)
    };
    assert_eq!(text.lines().filter(|line| line.starts_with("v ") && on_grid(line)).count(), 81);
}

fn frame(n: usize) -> TriMesh {
    let square = |half: f32| {
        (0..4 * n).map(move |i| {
            let t = half * (2.0 * (i % n) as f32 / n as f32 - 1.0);
            [[t, -half, 0.0], [half, t, 0.0], [-t, half, 0.0], [-half, -t, 0.0]][i / n]
        })
    };
    let m = 4 * n as u32;
    let faces = (0..m).flat_map(|i| [[i, (i + 1) % m, i + m], [(i + 1) % m, (i + 1) % m + m, i + m]]);
    TriMesh::new(square(1.0).chain(square(0.7)).collect(), faces.collect()).unwrap()
}

fn flat_area([a, b, c]: [[f32; 3]; 3]) -> f32 {
    0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs()
}

#[test]
fn openings_of_components_stay_open_where_nothing_but_a_boundary_shows_them() {
    let folder = folder();
    let nodes: Vec<Value> = (0..12).map(|i| json!({"mesh": i, "translation": [2.5 * f64::from(i), 0, 0]})).collect();
    for turned in [false, true] {
        let turn_mesh = |mesh: TriMesh| match turned {
            true => TriMesh::new(mesh.positions().to_vec(), mesh.faces().iter().map(|&[a, b, c]| [b, a, c]).collect())
                .unwrap(),
            false => mesh,
        };
        let frames: Vec<TriMesh> = (0..12).map(|i| turn_mesh(frame(1 + i % 3))).collect();
        std::fs::write(folder.path().join("in.gltf"), scene_of(&frames, &nodes.clone().into())).unwrap();
        let asked = ["simplify", "in.gltf", "-o", "out.glb", "--ratio", "0.1", "--hold-shape", "--force"];
        assert_eq!(run(folder.path(), &asked).code, Some(0));
        let drawn = read_scene_mesh(&folder.path().join("out.glb"));
        let area: f32 = drawn.faces().iter().map(|face| flat_area(face.map(|v| drawn.positions()[v as usize]))).sum();
        let all = 12.0 * 4.0 * (1.0 - 0.7 * 0.7);
        assert!((area / all - 1.0).abs() < 0.02, "{turned}: {area} of {all}");
    }
}

#[test]
fn small_meshes_inside_large_ones_of_a_scene_are_hidden_where_they_stand() {
    let folder = folder();
    // In local coordinates the second is inside the first; its node moves it out.
    let meshes = [shapes::icosphere(3), scale_mesh(&shapes::icosphere(2), 0.5)];
    for (x, n_left) in [(0.0, 1), (3.0, 2)] {
        let nodes = json!([{"mesh": 0}, {"mesh": 1, "translation": [x, 0, 0]}]);
        std::fs::write(folder.path().join("in.gltf"), scene_of(&meshes, &nodes)).unwrap();
        let asked = ["simplify", "in.gltf", "-o", "out.glb", "--ratio", "0.5", "--hidden", "drop", "--force"];
        assert_eq!(run(folder.path(), &asked).code, Some(0));
        let drawn = read_scene_mesh(&folder.path().join("out.glb"));
        assert_eq!(neural_mesh::mesh::topology(&drawn).components, n_left, "{x}");
    }
}

/// Faces of a mesh that a test accepts, as a mesh of their own.
fn part_of(mesh: &TriMesh, accepts: impl Fn([f32; 3]) -> bool) -> TriMesh {
    let middle = |face: &[u32; 3]| {
        let corners = face.map(|v| mesh.positions()[v as usize]);
        [0, 1, 2].map(|axis| corners.iter().map(|p| p[axis]).sum::<f32>() / 3.0)
    };
    let faces = mesh.faces().iter().copied().filter(|face| accepts(middle(face))).collect();
    neural_mesh::mesh::compact(mesh.positions(), faces).unwrap().0
}

/// Returns the edges by position with one face, as a viewer sees them.
fn count_open_edges(mesh: &TriMesh) -> usize {
    let (first, _) = neural_mesh::mesh::join_positions(mesh.positions());
    let faces = mesh.faces().iter().map(|face| face.map(|v| first[v as usize])).collect();
    let joined = neural_mesh::mesh::compact(mesh.positions(), faces).unwrap().0;
    neural_mesh::mesh::edges(&joined).iter().filter(|edge| edge.n_faces() == 1).count()
}

#[test]
fn meshes_of_a_scene_that_continue_each_other_stay_in_touch() {
    let folder = folder();
    let sphere = shapes::wavy_sphere(4, 6.0);
    let third = |k: i32| move |p: [f32; 3]| (p[0].atan2(p[1]) * 3.0 / std::f32::consts::TAU).floor() as i32 == k;
    let meshes = [-2, -1, 0, 1].map(|k| part_of(&sphere, third(k)));
    let place = [5.0, 1.0, -2.0];
    let nodes: Vec<Value> = (0..4).map(|i| json!({"mesh": i, "translation": place, "scale": [2, 2, 2]})).collect();
    std::fs::write(folder.path().join("in.gltf"), scene_of(&meshes, &json!(nodes))).unwrap();
    assert_eq!(count_open_edges(&read_scene_mesh(&folder.path().join("in.gltf"))), 0);
    for (ratio, effort) in [("0.5", "fast"), ("0.1", "standard"), ("0.02", "best")] {
        let asked = ["simplify", "in.gltf", "-o", "out.glb", "--ratio", ratio, "--effort", effort, "--force"];
        assert_eq!(run(folder.path(), &asked).code, Some(0));
        let light = read_scene_mesh(&folder.path().join("out.glb"));
        assert_eq!(count_open_edges(&light), 0, "{ratio}");
        let asked: f64 = ratio.parse().unwrap();
        let share = light.faces().len() as f64 / sphere.faces().len() as f64;
        assert!((0.8 * asked..=1.05 * asked).contains(&share), "{ratio}: {share}");
    }
}
