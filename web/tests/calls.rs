//! Calls as JavaScript makes them, answer natively.

use std::ops::ControlFlow;

use neural_mesh::io::{self, Format};
use neural_mesh::mesh::{Frame, TriMesh, shapes, topology};
use neural_mesh_web::answer::answer_to;
use neural_mesh_web::message::{Answer, Message};
use serde_json::{Value, json};

struct ParsedAnswer {
    bytes: Vec<u8>,
    json: Value,
}

impl ParsedAnswer {
    fn part(&self, number: &Value) -> Vec<u8> {
        Message::read(&self.bytes).unwrap().part(number.as_u64().unwrap() as usize).unwrap().to_vec()
    }

    fn indices(&self, number: &Value) -> Vec<[u32; 3]> {
        Message::read(&self.bytes).unwrap().rows(number.as_u64().unwrap() as usize, u32::from_le_bytes).unwrap()
    }

    fn positions(&self, number: &Value) -> Vec<[f32; 3]> {
        Message::read(&self.bytes).unwrap().rows(number.as_u64().unwrap() as usize, f32::from_le_bytes).unwrap()
    }
}

fn call_with(request: Answer, json: &Value, stops: bool) -> ParsedAnswer {
    let flow = move |_, _| if stops { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let bytes = answer_to(&request.into_bytes(json), Box::new(flow));
    let json = serde_json::from_slice(Message::read(&bytes).unwrap().part(0).unwrap()).unwrap();
    ParsedAnswer { bytes, json }
}

fn call(request: Answer, json: &Value) -> ParsedAnswer {
    call_with(request, json, false)
}

fn buffers(mesh: &TriMesh) -> Answer {
    let mut request = Answer::default();
    request.add_numbers(mesh.faces().iter().copied().flatten(), u32::to_le_bytes);
    request.add_numbers(mesh.positions().iter().copied().flatten(), f32::to_le_bytes);
    request
}

fn file(mesh: &TriMesh, format: Format) -> Vec<u8> {
    io::write(mesh, &Frame::default(), format).unwrap()
}

#[test]
fn a_file_comes_back_at_its_size_in_every_format() {
    let mesh = shapes::wavy_sphere(4, 5.0);
    for name in ["a.obj", "a.ply", "a.stl", "a.off", "a.glb", "a.gltf", "a.3mf", "a.ply.gz"] {
        let mut request = Answer::default();
        request.add(file(&mesh, Format::Ply));
        let json = json!({ "call": "simplify", "options": { "faces": 400 }, "file": { "name": "in.ply", "bytes": 1 }, "out": name });
        let answer = call(request, &json);
        let made = &answer.json["files"][0];
        assert_eq!(made["name"], name, "{}", answer.json);
        let read = io::read_attributed_in(&answer.part(&made["bytes"]), name, &io::Folder::in_memory([("", vec![])]));
        let read = read.unwrap();
        assert_eq!((read.mesh.faces.len(), &answer.json["report"]["output"]["faces"]), (400, &json!(400)), "{name}");
    }
}

#[test]
fn companion_files_of_an_obj_come_with_it() {
    let obj = b"mtllib a.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\nf 1/1 2/2 3/3\nf 2/2 4/4 3/3\n";
    let mtl = b"newmtl red\nKd 1 0 0\nmap_Kd maps/a.png\n";
    let file = json!({ "name": "a.obj", "bytes": 1, "beside": { "a.mtl": 2, "maps/a.png": 3 } });
    let request = || {
        let mut request = Answer::default();
        [&obj[..], mtl, b"png"].into_iter().for_each(|bytes| {
            request.add(bytes.to_vec());
        });
        request
    };
    let seen = call(request(), &json!({ "call": "look", "file": file }));
    let group = &seen.json["mesh"]["groups"][0];
    assert_eq!((&group["color"], &group["faces"]), (&json!([1.0, 0.0, 0.0, 1.0]), &json!(2)), "{}", seen.json);
    assert_eq!(seen.part(&group["image"]), b"png");
    assert_eq!(seen.positions(&seen.json["mesh"]["positions"]).len(), 4);
    let json = json!({ "call": "simplify", "options": { "ratio": 1.0 }, "file": file, "out": "b.obj" });
    let answer = call(request(), &json);
    let beside = answer.json["files"][0]["beside"].as_array().unwrap();
    let names: Vec<&str> = beside.iter().map(|file| file["name"].as_str().unwrap()).collect();
    assert!(names.contains(&"a.mtl") && names.contains(&"maps/a.png"), "{names:?}");
}

#[test]
fn arrays_come_back_as_arrays() {
    let mesh = shapes::wavy_sphere(4, 5.0);
    let mut request = buffers(&mesh);
    request.add_numbers(mesh.positions().iter().flat_map(|p| [p[0], p[1]]), f32::to_le_bytes);
    let arrays = json!({ "positions": 2, "faces": 1, "uv": 3 });
    let options = json!({ "vertices": 200, "no_check": true, "map": true });
    let answer = call(request, &json!({ "call": "simplify", "options": options, "mesh": arrays, "arrays": true }));
    let result = &answer.json["results"][0];
    let (faces, positions) = (answer.indices(&result["faces"]), answer.positions(&result["positions"]));
    assert_eq!((positions.len(), answer.part(&result["uv"]).len()), (200, 200 * 8));
    assert_eq!(answer.part(&result["map"]).len(), 200 * 4);
    assert!(topology(&TriMesh::new(positions, faces).unwrap()).is_closed_manifold());
}

#[test]
fn levels_of_a_mesh_are_separate_files() {
    let mut request = Answer::default();
    request.add(file(&shapes::icosphere(4), Format::Stl));
    let options = json!({ "lods": [0.5, "10%"], "no_check": true });
    let file = json!({ "name": "in.stl", "bytes": 1 });
    let answer = call(request, &json!({ "call": "simplify", "options": options, "file": file, "out": "x.y.ply.gz" }));
    let names: Vec<&Value> = answer.json["files"].as_array().unwrap().iter().map(|file| &file["name"]).collect();
    assert_eq!(names, ["x.y-1.ply.gz", "x.y-2.ply.gz"], "{}", answer.json);
}

#[test]
fn figures_and_distances_are_those_of_the_program() {
    let (original, result) = (shapes::icosphere(4), shapes::icosphere(3));
    let mut request = Answer::default();
    request.add(file(&original, Format::Ply));
    request.add(file(&result, Format::Obj));
    let json = json!({ "call": "compare", "original": { "name": "a.ply", "bytes": 1 }, "results": [{ "name": "b.obj", "bytes": 2 }], "samples": 5000 });
    let answer = call(request, &json);
    let values = &answer.json["comparison"]["results"][0]["values"];
    assert_eq!((&values["faces"], &values["boundary_edges"]), (&json!(1280.0), &json!(0.0)), "{}", answer.json);
    let mean = values["distance_mean"].as_f64().unwrap();
    assert!((0.01..0.2).contains(&mean), "{mean}");
    let distances = &answer.json["distances"][0];
    // Large faces also have distance samples between their corners.
    assert_eq!(answer.part(&distances["of_original"]).len() % 4, 0);
    assert!(answer.part(&distances["of_original"]).len() >= 4 * original.positions().len());
    assert_eq!(answer.indices(&answer.json["surfaces"][1]["faces"]).len(), 1280);
}

#[test]
fn indices_are_fewer_over_the_same_vertices() {
    let mesh = shapes::wavy_sphere(4, 5.0);
    let request_json = json!({ "call": "indices", "indices": 1, "positions": 2, "target": 1200, "error": 1.0 });
    let answer = call(buffers(&mesh), &request_json);
    let faces = answer.indices(&answer.json["indices"]);
    assert_eq!(faces.len(), 400, "{}", answer.json);
    let result = TriMesh::new(mesh.positions().to_vec(), faces).unwrap();
    assert!(topology(&result).is_closed_manifold());
    let error = answer.json["error"].as_f64().unwrap();
    assert!((0.0..0.05).contains(&error), "{error}");
    let near = json!({ "call": "indices", "indices": 1, "positions": 2, "target": 0, "error": 0.01 });
    let answer = call(buffers(&mesh), &near);
    let n_faces = answer.indices(&answer.json["indices"]).len();
    assert!(answer.json["error"].as_f64().unwrap() <= 0.01 && n_faces < 2500, "{n_faces} {}", answer.json);
}

#[test]
fn moved_vertices_match_the_indices() {
    let mesh = shapes::wavy_sphere(4, 5.0);
    let mut request = buffers(&mesh);
    request.add_numbers(mesh.positions().iter().map(|p| p[2]), f32::to_le_bytes);
    let request_json = json!({ "call": "indices", "indices": 1, "positions": 2, "target": 900, "error": 1.0, "move": true, "attributes": 3, "weights": [1.0] });
    let answer = call(request, &request_json);
    let faces = answer.indices(&answer.json["indices"]);
    let positions = answer.positions(&answer.json["positions"]);
    assert_eq!((faces.len(), positions.len()), (300, mesh.positions().len()));
    let heights = answer.part(&answer.json["attributes"]);
    let height = |v: u32| f32::from_le_bytes(*heights.as_chunks().0.get(v as usize).unwrap());
    let most = faces.as_flattened().iter().map(|&v| (height(v) - positions[v as usize][2]).abs()).fold(0.0, f32::max);
    assert!(most < 0.1, "{most}");
    assert!(topology(&TriMesh::new(positions, faces).unwrap()).is_closed_manifold());
}

#[test]
fn seams_keep_the_vertices_of_their_sides() {
    // A grid whose two halves have vertices of their own along the middle.
    let n = 21;
    let grid_point = |x: usize, y: usize| [x as f32, y as f32, (0.3 * x as f32).sin()];
    let positions: Vec<[f32; 3]> = [0..n, n - 1..2 * n - 1]
        .into_iter()
        .flat_map(|xs| xs.flat_map(move |x| (0..n).map(move |y| grid_point(x, y))))
        .collect();
    let place = |half: usize, x: usize, y: usize| (half * n * n + x * n + y) as u32;
    let cell = |half: usize, x: usize, y: usize| {
        let [a, b, c, d] = [place(half, x, y), place(half, x + 1, y), place(half, x + 1, y + 1), place(half, x, y + 1)];
        [[a, b, c], [a, c, d]]
    };
    let faces: Vec<[u32; 3]> =
        (0..2).flat_map(|h| (0..n - 1).flat_map(move |x| (0..n - 1).flat_map(move |y| cell(h, x, y)))).collect();
    let mut request = Answer::default();
    request.add_numbers(faces.iter().copied().flatten(), u32::to_le_bytes);
    request.add_numbers(positions.iter().copied().flatten(), f32::to_le_bytes);
    let answer =
        call(request, &json!({ "call": "indices", "indices": 1, "positions": 2, "target": 450, "error": 1.0 }));
    let left = answer.indices(&answer.json["indices"]);
    assert!(left.len() <= 150, "{}", left.len());
    let half = |v: u32| v as usize / (n * n);
    assert!(left.iter().all(|face| half(face[0]) == half(face[1]) && half(face[1]) == half(face[2])));
}

#[test]
fn locked_vertices_stay() {
    let mesh = shapes::icosphere(4);
    let mut request = buffers(&mesh);
    request.add((0..mesh.positions().len()).map(|v| u8::from(v % 10 == 3)).collect());
    let answer = call(
        request,
        &json!({ "call": "indices", "indices": 1, "positions": 2, "locks": 3, "target": 1800, "error": 1.0 }),
    );
    let faces = answer.indices(&answer.json["indices"]);
    let lacks = |v: u32| !faces.as_flattened().contains(&v);
    assert!(
        faces.len() <= 620 && !(0..mesh.positions().len() as u32).any(|v| v % 10 == 3 && lacks(v)),
        "{}",
        faces.len()
    );
}

#[test]
fn small_components_are_pruned_and_points_selected() {
    let (sphere, small) = (shapes::icosphere(3), shapes::icosphere(1));
    let small = shapes::place(&small, |[x, y, z]| [0.01 * x + 3.0, 0.01 * y, 0.01 * z]);
    let mesh = shapes::unite([&sphere, &small]);
    let answer = call(buffers(&mesh), &json!({ "call": "prune", "indices": 1, "positions": 2, "error": 0.05 }));
    assert_eq!(answer.indices(&answer.json["indices"]).len(), sphere.faces().len());
    let answer = call(buffers(&mesh), &json!({ "call": "points", "positions": 2, "target": 50 }));
    assert_eq!(answer.part(&answer.json["indices"]).len(), 200);
}

#[test]
fn errors_are_one_line() {
    let mesh = shapes::icosphere(1);
    let with_file = |bytes: &[u8]| {
        let mut request = Answer::default();
        request.add(bytes.to_vec());
        request
    };
    let simplify = |options: Value| json!({ "call": "simplify", "options": options, "file": { "name": "a.ply", "bytes": 1 }, "out": "b.ply" });
    let cases = [
        (Answer::default(), json!({})),
        (Answer::default(), json!({ "call": "simplify" })),
        (with_file(b""), simplify(json!({ "ratio": 0.1 }))),
        (with_file(b"ply\nformat ascii 1.0\n"), simplify(json!({ "ratio": 0.1 }))),
        (with_file(b"\x00\xff"), json!({ "call": "look", "file": { "name": "a", "bytes": 1 } })),
        (with_file(&file(&mesh, Format::Ply)), simplify(json!({ "rato": 0.1 }))),
        (with_file(&file(&mesh, Format::Ply)), simplify(json!({}))),
        (with_file(&file(&mesh, Format::Ply)), simplify(json!({ "ratio": 0.5, "assembly": "paper", "bake": 256 }))),
        (buffers(&mesh), json!({ "call": "indices", "indices": 2, "positions": 2, "target": 3, "error": 1.0 })),
        (buffers(&mesh), json!({ "call": "indices", "indices": 1, "positions": 7, "target": 3, "error": 1.0 })),
    ];
    for (request, json) in cases {
        let answer = call(request, &json).json;
        let said = answer["error"].as_str().unwrap_or_default();
        assert!(!said.is_empty() && !said.contains('\n') && said.len() < 600, "{json}: {answer}");
    }
}

#[test]
fn errors_name_options_as_javascript_writes_them() {
    let bytes = file(&shapes::icosphere(1), Format::Ply);
    for (options, says) in [
        (json!({ "rato": 0.1 }), "no such option: rato; did you mean ratio?"),
        (json!({ "ratio": 0.5, "keepFeatures": true }), "no such option: keepFeatures; did you mean keep_features?"),
        (
            json!({ "ratio": 10 }),
            "ratio 10: give a share above 0 and at most 1, like 0.1, or in percent, like 10%; did you mean 10%?",
        ),
        (json!({ "ratio": 0.5, "keep": "wheel" }), "keep wheel: give a list"),
        (json!({}), "give a size: ratio, vertices, faces, error, size or lods"),
        (json!(0.1), "options: give values by name"),
    ] {
        let mut request = Answer::default();
        request.add(bytes.clone());
        let json =
            json!({ "call": "simplify", "options": options, "file": { "name": "a.ply", "bytes": 1 }, "out": "b.ply" });
        assert_eq!(call(request, &json).json["error"], says);
    }
}

#[test]
fn a_run_that_is_ended_says_so() {
    let mesh = shapes::icosphere(4);
    let mut request = Answer::default();
    request.add(file(&mesh, Format::Ply));
    let json = json!({ "call": "simplify", "options": { "ratio": 0.1 }, "file": { "name": "a.ply", "bytes": 1 }, "out": "b.ply" });
    assert_eq!(call_with(request, &json, true).json["interrupted"], true);
}

#[test]
fn groups_keep_their_vertices_where_these_move() {
    // A sphere of 24 groups, each with vertices of its own.
    let mesh = shapes::wavy_sphere(3, 5.0);
    let group_of = |face: usize| (face / 54) as u32;
    let (mut places, mut numbers) = (std::collections::BTreeMap::new(), Vec::new());
    let mut indices = Vec::new();
    for (face, corners) in mesh.faces().iter().enumerate() {
        for &v in corners {
            let next = numbers.len() as u32;
            let place = *places.entry((group_of(face), v)).or_insert(next);
            if place == next {
                numbers.push((group_of(face), v));
            }
            indices.push(place);
        }
    }
    let groups: Vec<u32> = (0..mesh.faces().len()).map(group_of).collect();
    for moves in [false, true] {
        let mut request = Answer::default();
        request.add_numbers(indices.iter().copied(), u32::to_le_bytes);
        request.add_numbers(numbers.iter().flat_map(|(_, v)| mesh.positions()[*v as usize]), f32::to_le_bytes);
        request.add_numbers(groups.iter().copied(), u32::to_le_bytes);
        let request_json = json!({ "call": "indices", "indices": 1, "positions": 2, "groups": 3, "target": 1800, "error": 1.0, "move": moves });
        let answer = call(request, &request_json);
        let faces = answer.indices(&answer.json["indices"]);
        let of_faces = answer.part(&answer.json["groups"]);
        let of_faces: Vec<u32> = of_faces.as_chunks().0.iter().map(|&bytes| u32::from_le_bytes(bytes)).collect();
        assert!(faces.len() <= 640 && faces.len() == of_faces.len(), "{} {}", faces.len(), answer.json);
        let own =
            faces.iter().zip(&of_faces).all(|(face, group)| face.iter().all(|&v| numbers[v as usize].0 == *group));
        let bad: Vec<_> = faces
            .iter()
            .zip(&of_faces)
            .filter(|(face, group)| face.iter().any(|&v| numbers[v as usize].0 != **group))
            .collect();
        assert!(
            own,
            "moved: {moves} {bad:?} {:?}",
            bad.iter().map(|(f, _)| f.map(|v| numbers[v as usize])).collect::<Vec<_>>()
        );
    }
}
