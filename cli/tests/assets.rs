//! `neural-mesh simplify` carries attributes over, in the file or next to it.

use std::path::Path;

use crate::common::{Run, charts, folder, json, run, run_with_input, succeed, test_mesh_path, write_plate};
use neural_mesh::io::{self, Asset, Format};
use neural_mesh::picture::{Image, decode_image, encode_png};
use tempfile::TempDir;

fn textured_plate() -> TempDir {
    let folder = folder();
    write_plate(folder.path(), "mtllib skin.mtl\n", "");
    std::fs::write(folder.path().join("skin.mtl"), "newmtl left\nmap_Kd maps/skin.png\nnewmtl right\nKd 1 0 0\n")
        .unwrap();
    std::fs::create_dir(folder.path().join("maps")).unwrap();
    std::fs::write(folder.path().join("maps/skin.png"), b"not looked into").unwrap();
    folder
}

fn read_stdout(run: &Run) -> String {
    String::from_utf8(run.stdout.clone()).unwrap()
}

fn simplify_plate(folder: &Path, more: &[&str]) -> Run {
    succeed(folder, &[&["simplify", "plate.obj"], more].concat())
}

fn shares(picture: &Image, channel: usize) -> [f64; 2] {
    let mut counts = [0.0; 2];
    for (i, pixel) in picture.rgba.chunks_exact(4).enumerate() {
        let others = (0..3).filter(|&other| other != channel).map(|other| pixel[other]).max().unwrap_or(0);
        let half = usize::from(i % picture.width >= picture.width / 2);
        counts[half] += f64::from(u8::from(pixel[channel] > others.saturating_add(60)));
    }
    counts.map(|count| 2.0 * count / (picture.width * picture.height) as f64)
}

#[test]
fn ignored_attributes_do_not_limit_the_result() {
    let folder = folder();
    let mesh = charts(12, &[]);
    let outcome = |arguments: &[&str]| {
        let arguments = [&["simplify", "-", "--vertices", "60", "--force", "--report", "r.json"], arguments].concat();
        let run = run_with_input(folder.path(), &arguments, mesh.as_bytes());
        assert_eq!(run.code, Some(0), "{}", run.stderr);
        let report = json(&folder.path().join("r.json"));
        (report["outcome"] == "reached", report["output"]["kept_edges"].as_u64().unwrap())
    };
    // With fixed seams no merge is possible, unless seams give way to the size.
    assert_eq!(outcome(&["-o", "a.obj", "--seam-error", "0", "--hold-shape"]), (false, 264));
    assert_eq!(outcome(&["-o", "a.obj", "--seam-error", "0"]), (true, 264));
    assert_eq!(outcome(&["-o", "a.obj"]), (true, 264));
    assert_eq!(outcome(&["-o", "a.obj", "--seam-error", "0", "--ignore", "uv,normals"]), (true, 0));
    let text = std::fs::read_to_string(folder.path().join("a.obj")).unwrap();
    assert!(!text.contains("vt "), "{text}");
    assert_eq!(outcome(&["-o", "a.stl", "--seam-error", "0"]), (true, 0));
    let notes = json(&folder.path().join("r.json"))["notes"].to_string();
    assert!(notes.contains("stl stores only geometry: uv dropped"), "{notes}");
}

#[test]
fn texels_are_those_of_the_texture() {
    let folder = folder();
    let image = Image { width: 64, height: 32, rgba: [20, 200, 20, 255].repeat(64 * 32) };
    std::fs::write(folder.path().join("skin.png"), encode_png(&image)).unwrap();
    std::fs::write(folder.path().join("skin.mtl"), "newmtl skin\nmap_Kd skin.png\n").unwrap();
    let with_texture = format!("mtllib skin.mtl\nusemtl skin\n{}", charts(24, &[]));
    std::fs::write(folder.path().join("a.obj"), with_texture).unwrap();
    std::fs::write(folder.path().join("b.obj"), charts(24, &[])).unwrap();
    let positions = |mesh: &str, more: &[&str]| {
        let out = ["simplify", mesh, "-o", "out/a.obj", "--ratio", "0.4", "--force"];
        succeed(folder.path(), &[&out, more].concat());
        io::read_attributed_path(&folder.path().join("out/a.obj"), None).unwrap().mesh.positions
    };
    std::fs::create_dir(folder.path().join("out")).unwrap();
    let default = positions("a.obj", &[]);
    assert_eq!(positions("a.obj", &["--seam-error", "1"]), default);
    assert_eq!(positions("b.obj", &["--seam-error", "16"]), default);
    let far = positions("a.obj", &["--seam-error", "16"]);
    assert_ne!(far, default);
    assert_eq!(positions("b.obj", &["--seam-error", "256"]), far);
    for wrong in ["-1", "nan"] {
        let run = run(folder.path(), &["simplify", "a.obj", "-o", "c.obj", "--ratio", "0.4", "--seam-error", wrong]);
        assert!(run.code == Some(2) && run.stderr.contains("give texels, 0 or more"), "{}", run.stderr);
    }
}

#[test]
fn a_picture_shows_textures_and_materials_before_and_after() {
    let folder = textured_plate();
    let green = Image { width: 2, height: 2, rgba: [20, 200, 20, 255].repeat(4) };
    std::fs::write(folder.path().join("maps/skin.png"), encode_png(&green)).unwrap();
    simplify_plate(folder.path(), &["-o", "out.obj", "--vertices", "60", "--picture", "out.png"]);
    let picture = decode_image(&std::fs::read(folder.path().join("out.png")).unwrap()).unwrap();
    let [green, red] = [1, 0].map(|channel| shares(&picture, channel));
    assert!(green.iter().chain(&red).all(|&share| share > 0.1), "{green:?} {red:?}");
    assert!((green[0] - green[1]).abs() < 0.1 && (red[0] - red[1]).abs() < 0.1, "{green:?} {red:?}");
}

#[test]
fn a_texture_that_cannot_be_drawn_is_noted() {
    let folder = textured_plate();
    let run = simplify_plate(folder.path(), &["-o", "out.obj", "--vertices", "60", "--picture", "out.png"]);
    assert!(read_stdout(&run).contains("a texture is left out: it is not PNG, JPEG or WebP"), "{}", read_stdout(&run));
}

#[test]
fn an_obj_keeps_its_materials_and_texture() {
    let folder = textured_plate();
    std::fs::create_dir(folder.path().join("out")).unwrap();
    simplify_plate(folder.path(), &["-o", "out/plate.obj", "--vertices", "60"]);
    let out = folder.path().join("out");
    assert_eq!(std::fs::read(out.join("maps/skin.png")).unwrap(), b"not looked into");
    let read = io::read_attributed_path(&out.join("plate.obj"), None).unwrap();
    let names: Vec<_> = read.extra.groups.iter().map(|group| group.material.clone().unwrap()).collect();
    assert_eq!(names, ["left", "right"]);
    let uv = &read.mesh.attributes.channels[0];
    for (f, face) in read.mesh.faces.iter().enumerate() {
        let is_right = read.mesh.attributes.group(f as u32) == 1;
        for (&v, &wedge) in face.iter().zip(&read.mesh.attributes.wedges[f]) {
            let [x, y, _] = read.mesh.positions[v as usize];
            let [u, v] = [0, 1].map(|i| 20.0 * f64::from(uv.value(wedge)[i]));
            assert!((x - u).abs() < 0.3 && (y - v).abs() < 0.3, "{x} {y} {u} {v}");
            assert!(if is_right { x > 9.7 } else { x < 10.3 }, "a face left its material: {x}");
        }
    }
}

#[test]
fn attributes_that_a_format_cannot_hold_are_noted() {
    let folder = textured_plate();
    let run = simplify_plate(folder.path(), &["-o", "plate.stl", "--ratio", "0.5"]);
    assert!(read_stdout(&run).contains("note") && read_stdout(&run).contains("only geometry"), "{}", read_stdout(&run));
}

#[test]
fn a_scene_stays_a_scene() {
    let folder = textured_plate();
    simplify_plate(folder.path(), &["-o", "plate.glb", "--ratio", "1"]);
    succeed(folder.path(), &["simplify", "plate.glb", "-o", "lighter.glb", "--faces", "200"]);
    let asset = Asset::read_path(&folder.path().join("lighter.glb")).unwrap();
    let mesh = &asset.parts()[0].mesh;
    assert!((190..=200).contains(&mesh.faces.len()));
    assert_eq!(mesh.attributes.groups.iter().max(), Some(&1));
    assert!(mesh.attributes.channels.iter().any(|channel| channel.name == "TEXCOORD_0"));
}

#[test]
fn a_picture_of_a_scene_shows_its_meshes_where_nodes_place_them() {
    let folder = textured_plate();
    simplify_plate(folder.path(), &["-o", "plate.gltf", "--ratio", "1"]);
    let path = folder.path().join("plate.gltf");
    let text = std::fs::read_to_string(&path).unwrap();
    // A second plate to the right of the first one, with a gap between them.
    let two = text.replace(r#""nodes":[0]"#, r#""nodes":[0,1]"#);
    let two = two.replace(r#"{"mesh":0}"#, r#"{"mesh":0},{"mesh":0,"translation":[40,0,0]}"#);
    assert_ne!(two.len(), text.len());
    std::fs::write(&path, two).unwrap();
    let run =
        run(folder.path(), &["simplify", "plate.gltf", "-o", "out.gltf", "--faces", "200", "--picture", "out.png"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let picture = decode_image(&std::fs::read(folder.path().join("out.png")).unwrap()).unwrap();
    // Two plates before and two after: four runs of colour along the middle row, with background between them.
    let row = picture.height / 2 * picture.width;
    let paper = &picture.rgba[4 * row..][..3];
    let is_plate = |x: usize| picture.rgba[4 * (row + x)..][..3].iter().zip(paper).any(|(a, b)| a.abs_diff(*b) > 40);
    let n_plates = (1..picture.width).filter(|&x| is_plate(x) && !(x.saturating_sub(8)..x).any(is_plate)).count();
    assert_eq!(n_plates, 4);
}

#[test]
fn the_levels_of_a_scene_are_one_file() {
    let folder = textured_plate();
    simplify_plate(folder.path(), &["-o", "plate.glb", "--ratio", "1"]);
    succeed(folder.path(), &["simplify", "plate.glb", "-o", "levels.glb", "--lods", "0.5,0.2"]);
    let asset = Asset::read_path(&folder.path().join("levels.glb")).unwrap();
    let sizes: Vec<usize> = asset.parts().iter().map(|part| part.mesh.faces.len()).collect();
    assert!(sizes.len() == 2 && sizes[1] < sizes[0], "{sizes:?}");
    let bytes = std::fs::read(folder.path().join("levels.glb")).unwrap();
    assert!(String::from_utf8_lossy(&bytes).contains("MSFT_screencoverage"));
}

#[test]
fn the_levels_of_a_scene_are_files_of_their_own_where_the_name_says_so() {
    let folder = textured_plate();
    simplify_plate(folder.path(), &["-o", "plate.glb", "--ratio", "1"]);
    succeed(folder.path(), &["simplify", "plate.glb", "-o", "{level}-of-it.glb", "--lods", "50%,20%"]);
    let asset = |name: &str| Asset::read_path(&folder.path().join(name)).unwrap();
    let [first, second] = ["0-of-it.glb", "1-of-it.glb"].map(asset);
    let n_faces = |asset: &Asset| asset.parts().iter().map(|part| part.mesh.faces.len()).collect::<Vec<_>>();
    let ([first_size], [second_size]) = (&n_faces(&first)[..], &n_faces(&second)[..]) else {
        panic!("not a part each")
    };
    assert!(second_size < first_size, "{first_size} {second_size}");
    assert!(!folder.path().join("{level}-of-it.glb").exists());
    let refused = run(folder.path(), &["simplify", "plate.glb", "-o", "{level}.glb", "--ratio", "50%"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("--lods"), "{}", refused.stderr);
}

#[test]
fn levels_map_proof_and_size() {
    let folder = folder();
    let spot = test_mesh_path("spot.ply");
    let spot = spot.to_str().unwrap();
    succeed(folder.path(), &["simplify", spot, "-o", "a.obj", "--lods", "0.5,0.1", "--report", "a.json"]);
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("a.json")).unwrap()).unwrap();
    assert_eq!(report["levels"][1]["vertices"], 293);
    assert!(
        report["levels"][1]["screen_coverage"].as_f64().unwrap()
            < report["levels"][0]["screen_coverage"].as_f64().unwrap()
    );
    let second = io::read_path(&folder.path().join("a-lod1.obj"), Some(Format::Obj)).unwrap();
    assert_eq!(second.positions.len(), 293);
    succeed(folder.path(), &["simplify", spot, "-o", "b.ply", "--ratio", "0.1", "--map", "b.json"]);
    let map: serde_json::Value = serde_json::from_slice(&std::fs::read(folder.path().join("b.json")).unwrap()).unwrap();
    assert_eq!(map["output_vertices"].as_array().unwrap().len(), 2930);
    assert_eq!(map["corner_weights"].as_array().unwrap().len(), 582);
    let proved = run(folder.path(), &["simplify", spot, "-o", "c.ply", "--error", "2%", "--no-check"]);
    assert!(proved.code == Some(0) && read_stdout(&proved).contains("proved "), "{}", proved.stderr);
    let fits = run(folder.path(), &["simplify", spot, "-o", "d.ply", "--size", "20kB", "--no-check"]);
    let n_bytes = std::fs::metadata(folder.path().join("d.ply")).unwrap().len();
    assert!(fits.code == Some(0) && (19_000..=20_000).contains(&n_bytes), "{n_bytes}");
}

#[test]
fn importance_is_taken_from_an_attribute() {
    let folder = folder();
    let mut text = String::from(
        "ply\nformat ascii 1.0\nelement vertex 441\nproperty float x\nproperty float y\nproperty float z\n",
    );
    text += "property float wear\nelement face 800\nproperty list uchar int vertex_indices\nend_header\n";
    for (i, j) in (0..21).flat_map(|j| (0..21).map(move |i| (i, j))) {
        let wear = if i < 10 { 50.0 } else { 1.0 };
        text += &format!("{i} {j} {} {wear}\n", 0.5 * (f64::from(i) * 0.9).sin() * (f64::from(j) * 0.7).cos());
    }
    for (i, j) in (0..20).flat_map(|j| (0..20).map(move |i| (i, j))) {
        let vertex = |i: i32, j: i32| j * 21 + i;
        text += &format!(
            "3 {} {} {}\n3 {} {} {}\n",
            vertex(i, j),
            vertex(i + 1, j),
            vertex(i + 1, j + 1),
            vertex(i, j),
            vertex(i + 1, j + 1),
            vertex(i, j + 1)
        );
    }
    std::fs::write(folder.path().join("a.ply"), text).unwrap();
    let arguments = ["simplify", "a.ply", "-o", "b.ply", "--vertices", "100", "--importance", "wear"];
    succeed(folder.path(), &arguments);
    let mesh = io::read_path(&folder.path().join("b.ply"), None).unwrap();
    assert!(mesh.positions.iter().filter(|p| p[0] < 10.0).count() > 60);
    let unknown = run(folder.path(), &["simplify", "a.ply", "-o", "c.ply", "--ratio", "0.5", "--importance", "tear"]);
    assert!(unknown.code == Some(2) && unknown.stderr.contains("it has: wear"), "{}", unknown.stderr);
}

#[test]
fn a_material_can_count_more_than_others() {
    let folder = textured_plate();
    let on_the_left = |name: &str| {
        let mesh = io::read_path(&folder.path().join(name), None).unwrap();
        mesh.positions.iter().filter(|p| p[0] < 10.0).count()
    };
    simplify_plate(folder.path(), &["-o", "even.obj", "--vertices", "120"]);
    simplify_plate(folder.path(), &["-o", "left.obj", "--vertices", "120", "--importance", "left=20"]);
    simplify_plate(folder.path(), &["-o", "right.obj", "--vertices", "120", "--importance", "right=20"]);
    let [even, left, right] = ["even.obj", "left.obj", "right.obj"].map(on_the_left);
    assert!(left > even + 10 && even > right + 10, "{left} {even} {right}");
    // The same as a scene, whose groups are primitives.
    succeed(folder.path(), &["simplify", "plate.obj", "-o", "plate.glb", "--ratio", "1"]);
    let weighed = ["simplify", "plate.glb", "-o", "left.glb", "--vertices", "120", "--importance", "left=20"];
    assert_eq!(run(folder.path(), &weighed).code, Some(0));
    assert!(on_the_left("left.glb") > even + 10);
    for (wish, why) in [("top=2", "it has: left, right"), ("left=0", "above 0"), ("left=x", "above 0")] {
        let refused =
            run(folder.path(), &["simplify", "plate.obj", "-o", "c.obj", "--ratio", "0.5", "--importance", wish]);
        assert!(refused.code == Some(2) && refused.stderr.contains(why), "{}", refused.stderr);
    }
}
