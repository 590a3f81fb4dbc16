//! `neural-mesh simplify` with named nodes, meshes, materials and groups.

use std::path::Path;

use crate::common::avatar::Avatar;
use crate::common::{Run, folder, refuse, run, succeed, write_plate};
use neural_mesh::io::{self, Asset, AssetPart, ReadMesh};
use neural_mesh::mesh::RawMesh;
use serde_json::json;
use tempfile::TempDir;

fn scene(folder: &Path) {
    let mut avatar = Avatar::new(8);
    avatar.document["nodes"][1]["name"] = "box".into();
    avatar.document["nodes"][2]["children"] = json!([3, 1]);
    avatar.document["scenes"][0]["nodes"] = json!([0, 2]);
    std::fs::write(folder.join("scene.glb"), avatar.glb()).unwrap();
}

fn simplify(folder: &Path, more: &[&str]) -> Run {
    succeed(folder, &[&["simplify"], more].concat())
}

fn read(folder: &Path, name: &str) -> ReadMesh {
    io::read_attributed_path(&folder.join(name), None).unwrap()
}

fn faces_of(read: &ReadMesh, material: &str) -> Vec<Vec<u64>> {
    let named = |group: u32| read.extra.groups[group as usize].material.as_deref() == Some(material);
    face_bits(&read.mesh, |f| named(read.mesh.attributes.group(f as u32)))
}

// Lists the bits of faces, each from its least corner on, in an order that no change of numbers changes.
fn face_bits(mesh: &RawMesh, is_wanted: impl Fn(usize) -> bool) -> Vec<Vec<u64>> {
    let corner = |f: usize, c: usize| {
        let place = mesh.positions[mesh.faces[f][c] as usize].map(f64::to_bits).to_vec();
        let values = mesh.attributes.channels.iter().flat_map(|channel| channel.value(mesh.attributes.wedges[f][c]));
        place.into_iter().chain(values.map(|x| u64::from(x.to_bits()))).collect::<Vec<u64>>()
    };
    let face = |f: usize| {
        let mut corners = [0, 1, 2].map(|c| corner(f, c));
        let least = (0..3).min_by_key(|&c| corners[c].clone()).unwrap();
        corners.rotate_left(least);
        corners.concat()
    };
    let mut faces: Vec<Vec<u64>> = (0..mesh.faces.len()).filter(|&f| is_wanted(f)).map(face).collect();
    faces.sort();
    faces
}

fn read_part(folder: &Path, file: &str, name: &str) -> AssetPart {
    let asset = Asset::read_path(&folder.join(file)).unwrap();
    asset.parts().iter().find(|part| part.name == name).unwrap().clone()
}

fn part_faces(folder: &Path, file: &str, name: &str) -> Vec<Vec<u64>> {
    face_bits(&read_part(folder, file, name).mesh, |_| true)
}

fn plate_folder() -> TempDir {
    let folder = folder();
    write_plate(folder.path(), "", ".1");
    folder
}

#[test]
fn a_material_that_is_kept_comes_back_as_it_is() {
    let folder = plate_folder();
    let before = read(folder.path(), "plate.obj");
    simplify(folder.path(), &["plate.obj", "-o", "kept.obj", "--vertices", "260", "--keep", "left"]);
    let after = read(folder.path(), "kept.obj");
    let [kept, rest] = ["left", "right"].map(|name| [&before, &after].map(|read| faces_of(read, name)));
    assert_eq!(kept[0].len(), 400);
    assert!(kept[0] == kept[1] && rest[1].len() < 150 && !rest[1].is_empty(), "{}", rest[1].len());
    // The border is shared: 231 vertices are kept, the others belong to the rest.
    let n_vertices = crate::common::read_welded(&folder.path().join("kept.obj")).positions().len();
    assert!((250..=260).contains(&n_vertices), "{n_vertices}");
}

#[test]
fn both_materials_that_are_kept_are_the_whole() {
    let folder = plate_folder();
    let before = read(folder.path(), "plate.obj");
    let both = ["plate.obj", "-o", "kept.obj", "--ratio", "10%", "--keep", "left", "--keep", "right"];
    let said = String::from_utf8(simplify(folder.path(), &both).stdout).unwrap();
    assert!(said.contains("without --keep left and --keep right those faces are simplified too"), "{said}");
    let after = read(folder.path(), "kept.obj");
    assert!(["left", "right"].iter().all(|name| faces_of(&before, name) == faces_of(&after, name)));
    let strict = run(folder.path(), &[&["simplify"], &both[..], &["--force", "--strict"]].concat());
    assert_eq!(strict.code, Some(3), "{}", strict.stderr);
}

#[test]
fn a_node_that_is_kept_keeps_the_meshes_below_it() {
    let folder = folder();
    scene(folder.path());
    for name in ["box", "hips", "plain"] {
        let out = format!("{name}.glb");
        simplify(folder.path(), &["scene.glb", "-o", &out, "--ratio", "60%", "--keep", name]);
        let [before, after] = ["scene.glb", &out].map(|file| part_faces(folder.path(), file, "plain"));
        assert!(before == after, "{name}");
        let [before, after] = ["scene.glb", &out].map(|file| read_part(folder.path(), file, "ball").mesh.faces.len());
        assert!(after * 3 < before, "{name}: {after} of {before}");
    }
}

#[test]
fn a_skin_and_its_targets_are_kept_bit_for_bit() {
    let folder = folder();
    scene(folder.path());
    simplify(folder.path(), &["scene.glb", "-o", "out.glb", "--ratio", "60%", "--keep", "body"]);
    let [before, after] = ["scene.glb", "out.glb"].map(|file| part_faces(folder.path(), file, "ball"));
    assert!(before == after);
}

#[test]
fn unknown_names_are_refused_with_a_list_of_known_ones() {
    let folder = plate_folder();
    scene(folder.path());
    let refused = |more: &[&str]| refuse(folder.path(), &[&["simplify"], more].concat(), 2);
    let obj = refused(&["plate.obj", "-o", "x.obj", "--ratio", "0.5", "--keep", "top"]);
    assert!(obj.contains("--keep top: the mesh has no such material, group or object; it has: left, right"), "{obj}");
    let glb = refused(&["scene.glb", "-o", "x.glb", "--ratio", "0.5", "--keep", "top"]);
    assert!(glb.contains("no such node, mesh or material; it has: ball, body, box, hips, plain, skin"), "{glb}");
}

#[test]
fn a_node_can_count_more_than_others() {
    let folder = folder();
    scene(folder.path());
    let n_faces = |file: &str, name: &str| read_part(folder.path(), file, name).mesh.faces.len();
    for (name, out) in [("hips=20", "hips.glb"), ("body=20", "body.glb"), ("plain=20", "plain.glb")] {
        simplify(folder.path(), &["scene.glb", "-o", out, "--ratio", "30%", "--importance", name]);
    }
    assert!(n_faces("hips.glb", "plain") > 2 * n_faces("hips.glb", "ball"));
    assert!(n_faces("body.glb", "ball") > 2 * n_faces("body.glb", "plain"));
    assert_eq!(n_faces("plain.glb", "plain"), n_faces("hips.glb", "plain"));
}

#[test]
fn a_batch_keeps_what_has_the_name_and_says_which_mesh_has_none() {
    let folder = plate_folder();
    std::fs::create_dir(folder.path().join("in")).unwrap();
    std::fs::rename(folder.path().join("plate.obj"), folder.path().join("in/plate.obj")).unwrap();
    std::fs::write(folder.path().join("in/other.obj"), crate::common::OCTAHEDRON).unwrap();
    let batch = run(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "60%", "--keep", "left"]);
    assert_eq!(batch.code, Some(1), "{}", batch.stderr);
    let manifest = std::fs::read_to_string(folder.path().join("out/manifest.csv")).unwrap();
    assert!(manifest.contains("no such material, group or object"), "{manifest}");
    let [before, after] = ["in/plate.obj", "out/plate.obj"].map(|name| read(folder.path(), name));
    assert_eq!(faces_of(&before, "left"), faces_of(&after, "left"));
}

fn n_faces(folder: &Path, name: &str) -> [usize; 2] {
    let read = read(folder, name);
    ["left", "right"].map(|material| faces_of(&read, material).len())
}

#[test]
fn a_name_has_its_share_and_the_rest_makes_up_the_whole() {
    let folder = plate_folder();
    let words = ["plate.obj", "-o", "a.obj", "--ratio", "40%", "--ratio", "left=60%", "--report", "a.json"];
    simplify(folder.path(), &words);
    let n_vertices = crate::common::read_welded(&folder.path().join("a.obj")).positions().len();
    assert_eq!(n_vertices, 176);
    let [left, right] = n_faces(folder.path(), "a.obj");
    assert!((200..=260).contains(&left) && right < 130 && right > 20, "{left} {right}");
    let report = crate::common::json(&folder.path().join("a.json"));
    let named = &report["named"][0];
    assert_eq!((&named["name"], &named["ratio"], &named["faces_before"]), (&json!("left"), &json!(0.6), &json!(400)));
    assert_eq!(named["faces"], left);
    assert!(report["distance"]["mean_percent"].as_f64().unwrap() > 0.0);
    // Both as numbers of faces.
    let words = ["plate.obj", "-o", "b.obj", "--faces", "150", "--ratio", "left=10%", "--ratio", "right=20%"];
    simplify(folder.path(), &words);
    let [left, right] = n_faces(folder.path(), "b.obj");
    assert!(left + right <= 150 && left < 60 && right > left, "{left} {right}");
}

#[test]
fn without_a_size_of_the_whole_the_rest_stays() {
    let folder = plate_folder();
    simplify(folder.path(), &["plate.obj", "-o", "a.obj", "--ratio", "left=30%"]);
    let [left, right] = n_faces(folder.path(), "a.obj");
    // The border belongs to the simplified name, and takes faces of the other with it.
    assert!(left < 170 && right > 350, "{left} {right}");
    let closed = crate::common::info(folder.path(), "a.obj");
    assert_eq!((&closed["components"], &closed["manifold"]), (&json!(1), &json!(true)));
}

#[test]
fn shares_go_with_what_is_kept_and_with_formats_without_names() {
    let folder = plate_folder();
    let before = read(folder.path(), "plate.obj");
    simplify(folder.path(), &["plate.obj", "-o", "a.obj", "--ratio", "left=30%", "--keep", "right"]);
    assert_eq!(faces_of(&read(folder.path(), "a.obj"), "right"), faces_of(&before, "right"));
    assert!(n_faces(folder.path(), "a.obj")[0] < 250);
    simplify(folder.path(), &["plate.obj", "-o", "a.stl", "--ratio", "50%", "--ratio", "left=80%"]);
    let mesh = crate::common::read_welded(&folder.path().join("a.stl"));
    let n_left = mesh.positions().iter().filter(|p| p[0] < 9.9).count();
    assert!(n_left > 140 && mesh.positions().len() <= 220, "{n_left} of {}", mesh.positions().len());
}

#[test]
fn nodes_of_a_scene_have_shares_at_each_level() {
    let folder = folder();
    scene(folder.path());
    let words = ["scene.glb", "-o", "l-{level}.glb", "--lods", "60%,45%", "--ratio", "hips=70%"];
    simplify(folder.path(), &words);
    let n_faces = |file: &str, name: &str| read_part(folder.path(), file, name).mesh.faces.len();
    let all = n_faces("scene.glb", "plain");
    let [first, second] = ["l-0.glb", "l-1.glb"].map(|file| ["plain", "ball"].map(|name| n_faces(file, name)));
    assert!(first[0] == second[0] && first[0].abs_diff(all * 7 / 10) < 20, "{first:?} {second:?} of {all}");
    assert!(second[1] < first[1] && first[1] < all * 6 / 10, "{first:?} {second:?}");
    let bones = read_part(folder.path(), "l-0.glb", "ball").mesh.attributes.channels.len();
    assert_eq!(bones, read_part(folder.path(), "scene.glb", "ball").mesh.attributes.channels.len());
}

#[test]
fn shares_that_cannot_be_are_one_line() {
    let folder = plate_folder();
    for (words, why) in [
        (
            &["--ratio", "top=50%"][..],
            "--ratio top: the mesh has no such material, group or object; it has: left, right",
        ),
        (&["--ratio", "left=50"], "did you mean 50%?"),
        (&["--ratio", "50%", "--ratio", "20%"], "--ratio is given twice for the whole mesh"),
        (&["--ratio", "50%", "--faces", "20"], "--ratio cannot be used with --faces"),
        (&["--ratio", "left=50%", "--error", "1%"], "--ratio NAME=R cannot be used with --error"),
        (&["--ratio", "left=50%", "--assembly", "paper"], "--ratio NAME=R: not available with --assembly paper"),
    ] {
        let line = refuse(folder.path(), &[&["simplify", "plate.obj", "-o", "x.obj"], words].concat(), 2);
        assert!(line.contains(why), "{line}");
    }
    let several = ["simplify", "plate.obj", "-o", "x.obj", "--vertices", "9", "--faces", "20"];
    assert_eq!(run(folder.path(), &several).code, Some(2));
    assert_eq!(run(folder.path(), &["simplify", "plate.obj", "-o", "x.obj"]).code, Some(2));
}
