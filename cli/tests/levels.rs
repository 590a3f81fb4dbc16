//! `neural-mesh simplify --lods` by faces, vertices and distances.

use std::path::Path;

use crate::common::{Run, error_line, folder, json, run, succeed, test_mesh_path, write_sphere_and_speck};
use neural_mesh::io::{self, Asset};
use neural_mesh::mesh::shapes;

fn levels(folder: &Path, more: &[&str]) -> Run {
    let spot = test_mesh_path("spot.ply");
    run(folder, &[&["simplify", spot.to_str().unwrap(), "-o", "a.ply", "--report", "a.json"], more].concat())
}

fn faces(folder: &Path, n_levels: usize) -> Vec<usize> {
    let file = |level| io::read_path(&folder.join(format!("a-lod{level}.ply")), None).unwrap();
    (0..n_levels).map(|level| file(level).faces.len()).collect()
}

#[test]
fn levels_have_the_numbers_of_faces_asked_for() {
    let folder = folder();
    let run = levels(folder.path(), &["--lods", "3k,20%,0.1,300", "--lods-by", "faces", "--no-check"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(faces(folder.path(), 4), [3000, 1170, 584, 300]);
    assert_eq!(
        json(&folder.path().join("a.json"))["target"]["lods_faces"],
        serde_json::json!(["3000", "20%", "10%", "300"])
    );
}

#[test]
fn levels_have_the_numbers_of_vertices_asked_for() {
    let folder = folder();
    let run = levels(folder.path(), &["--lods", "1.5k,10%", "--lods-by", "vertices", "--no-check"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let report = json(&folder.path().join("a.json"));
    assert_eq!([0, 1].map(|level| report["levels"][level]["vertices"].as_u64().unwrap()), [1500, 293]);
    assert_eq!(report["target"]["lods_vertices"], serde_json::json!(["1500", "10%"]));
}

#[test]
fn each_level_says_what_it_drops() {
    let folder = folder();
    write_sphere_and_speck(folder.path());
    let words = ["simplify", "two.obj", "-o", "a.ply", "--lods", "100%,10%", "--report", "a.json"];
    let said = String::from_utf8(succeed(folder.path(), &words).stdout).unwrap();
    let level = |number: &str| said.lines().find(|line| line.starts_with(number)).unwrap();
    assert!(!level("level 0").contains("dropped") && level("level 1").contains(", dropped "), "{said}");
    assert_eq!(json(&folder.path().join("a.json"))["levels"][1]["components_pruned"], 1);
}

#[test]
fn levels_by_distance_are_each_proved() {
    let folder = folder();
    let run = levels(folder.path(), &["--lods", "0.5%,1%,3%", "--lods-by", "error", "--no-check"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let report = json(&folder.path().join("a.json"));
    let sizes = faces(folder.path(), 3);
    assert!(sizes.windows(2).all(|pair| pair[1] < pair[0]) && sizes[0] < 5856, "{sizes:?}");
    for (level, most) in [0.5, 1.0, 3.0].into_iter().enumerate() {
        let certified = &report["levels"][level]["certified"];
        let [lower, upper] = ["lower_percent", "upper_percent"].map(|bound| certified[bound].as_f64().unwrap());
        assert!(lower > 0.3 * most && upper <= most, "{level}: {lower} {upper}");
    }
    assert_eq!(report["target"]["lods_error"], serde_json::json!(["0.5%", "1%", "3%"]));
    let said = String::from_utf8(run.stdout).unwrap();
    assert_eq!(said.matches("largest distance proved at most").count(), 3, "{said}");
    // A separate search gives the same mesh.
    let alone = levels(folder.path(), &["--error", "1%", "--no-check", "--force"]);
    assert_eq!(alone.code, Some(0), "{}", alone.stderr);
    assert_eq!(io::read_path(&folder.path().join("a.ply"), None).unwrap().faces.len(), sizes[1]);
}

#[test]
fn levels_of_a_scene_by_distance_are_one_file() {
    let folder = folder();
    std::fs::write(folder.path().join("scene.glb"), crate::common::avatar::Avatar::new(8).glb()).unwrap();
    let words = ["simplify", "scene.glb", "-o", "out.glb", "--lods", "1%,4%", "--lods-by", "error"];
    succeed(folder.path(), &words);
    let asset = Asset::read_path(&folder.path().join("out.glb")).unwrap();
    let sizes: Vec<usize> = asset.parts().iter().map(|part| part.mesh.faces.len()).collect();
    assert!(sizes.len() == 4 && sizes[2] < sizes[0] && sizes[3] < sizes[1], "{sizes:?}");
}

#[test]
fn levels_that_cannot_be_are_one_line() {
    let folder = folder();
    for (words, why) in [
        (&["--lods", "20k,5k"][..], "--lods 20k: is a number: add --lods-by faces or --lods-by vertices"),
        (&["--lods", "1k,2k", "--lods-by", "faces"], "--lods: give falling sizes"),
        (&["--lods", "2%,1%", "--lods-by", "error"], "--lods: give rising distances"),
        (&["--lods", "1%,2", "--lods-by", "error"], "all in percent or all in the unit of the mesh"),
        (&["--lods", "10%,5k", "--lods-by", "faces"], "invalid size"),
        (&["--lods", "1%", "--lods-by", "error", "--assembly", "paper"], "--lods: not available"),
    ] {
        let refused = levels(folder.path(), words);
        assert_eq!(refused.code, Some(2), "{words:?}: {}", refused.stderr);
        assert!(error_line(&refused).contains(why), "{words:?}: {}", refused.stderr);
    }
    assert_eq!(levels(folder.path(), &["--ratio", "0.5", "--lods-by", "faces"]).code, Some(2));
}

#[test]
fn a_batch_takes_levels_by_faces() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("in")).unwrap();
    std::fs::copy(test_mesh_path("spot.ply"), folder.path().join("in/a.ply")).unwrap();
    let words = ["simplify", "in", "-o", ".", "--lods", "2k,500", "--lods-by", "faces", "--no-check"];
    succeed(folder.path(), &words);
    assert_eq!(faces(folder.path(), 2), [2000, 500]);
}

#[test]
fn a_single_level_of_the_paper_is_its_result_at_that_ratio() {
    let folder = folder();
    for words in [["--lods", "0.3"], ["--ratio", "0.3"]] {
        let run = levels(folder.path(), &[&words[..], &["--assembly", "paper", "--no-check", "--force"]].concat());
        assert_eq!(run.code, Some(0), "{}", run.stderr);
    }
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("a-lod0.ply") == bytes("a.ply"));
}

/// Writes the levels of a skinned avatar for an engine and returns the folder.
fn avatar_levels(engine: &str, output: &str) -> tempfile::TempDir {
    avatar_levels_with(engine, output, &["--no-check"])
}

fn avatar_levels_with(engine: &str, output: &str, more: &[&str]) -> tempfile::TempDir {
    let folder = folder();
    std::fs::write(folder.path().join("scene.glb"), crate::common::avatar::Avatar::new(8).glb()).unwrap();
    let words = ["simplify", "scene.glb", "-o", output, "--lods", "60%,30%", "--engine", engine];
    succeed(folder.path(), &[&words, more].concat());
    folder
}

#[test]
fn engines_find_levels_as_named_siblings_with_one_skin() {
    let input = {
        let folder = folder();
        let path = folder.path().join("scene.glb");
        std::fs::write(&path, crate::common::avatar::Avatar::new(8).glb()).unwrap();
        Asset::read_path(&path).unwrap().parts().len()
    };
    for engine in ["unity", "godot"] {
        let folder = avatar_levels(engine, "out.gltf");
        let document = json(&folder.path().join("out.gltf"));
        let nodes = document["nodes"].as_array().unwrap();
        let parents = nodes.iter().filter_map(|node| {
            let name = node["name"].as_str()?;
            let children = node["children"].as_array()?.iter().map(|child| &nodes[child.as_u64().unwrap() as usize]);
            let levels: Vec<_> = children.filter(|child| child.get("mesh").is_some()).collect();
            (!levels.is_empty()).then_some((name, levels))
        });
        let mut n_parents = 0;
        for (name, levels) in parents {
            let names: Vec<_> = levels.iter().map(|level| level["name"].as_str().unwrap().to_string()).collect();
            assert_eq!(names, [0, 1].map(|level| format!("{name}_LOD{level}")), "{engine}");
            assert!(levels.iter().all(|level| level.get("skin") == levels[0].get("skin")));
            n_parents += 1;
        }
        assert!(n_parents >= input, "{engine}: {n_parents}");
        // The buffer is there once.
        let buffers = document["buffers"].as_array().unwrap();
        assert_eq!(
            (buffers.len(), document.get("extensionsUsed").is_some_and(|it| it.to_string().contains("LOD"))),
            (1, false)
        );
    }
}

#[test]
fn each_engine_has_its_files() {
    for (engine, names) in [
        ("unity", &["out.glb"][..]),
        // Without measured errors there are no distances for a script.
        ("godot", &["out.glb"]),
        ("gltf", &["out.glb"]),
        ("unreal", &["out_LOD0.glb", "out_LOD1.glb"]),
    ] {
        let folder = avatar_levels(engine, "out.glb");
        let files =
            std::fs::read_dir(folder.path()).unwrap().map(|file| file.unwrap().file_name().into_string().unwrap());
        let mut files: Vec<String> = files.filter(|name| name != "scene.glb").collect();
        files.sort();
        assert_eq!(files, names, "{engine}");
        let is_extension =
            String::from_utf8_lossy(&std::fs::read(folder.path().join(names[0])).unwrap()).contains("MSFT_lod");
        assert_eq!(is_extension, engine == "gltf", "{engine}");
    }
    let folder = folder();
    let run = levels(folder.path(), &["--lods", "50%,20%", "--engine", "unity", "--no-check"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(["a_LOD0.ply", "a_LOD1.ply"].iter().all(|name| folder.path().join(name).exists()));
    let alone = levels(folder.path(), &["--ratio", "50%", "--engine", "unity"]);
    assert!(error_line(&alone).contains("--engine: give --lods, too"));
    let other = levels(folder.path(), &["--lods", "50%,20%", "--engine", "gltf"]);
    assert!(error_line(&other).contains("--engine gltf: ply is not glTF"));
}

/// Two spheres as objects of an OBJ, the second of two materials, one of which the first has, too.
fn two_objects() -> String {
    let sphere = shapes::icosphere(3);
    let n = sphere.positions().len() as u32;
    let mut text = String::new();
    for (number, name) in (0..).zip(["left", "right"]) {
        text += &format!("o {name}\nusemtl red\n");
        sphere
            .positions()
            .iter()
            .for_each(|p| text += &format!("v {} {} {}\n", p[0] + 3.0 * number as f32, p[1], p[2]));
        for (at, face) in sphere.faces().iter().enumerate() {
            text += if number == 1 && at == sphere.faces().len() / 2 { "usemtl blue\n" } else { "" };
            let [a, b, c] = face.map(|v| v + number * n + 1);
            text += &format!("f {a} {b} {c}\n");
        }
    }
    text
}

#[test]
fn levels_of_a_mesh_for_an_engine_are_those_of_a_scene() {
    let folder = folder();
    std::fs::write(folder.path().join("two.obj"), two_objects()).unwrap();
    for (engine, more) in
        [("unity", &["--no-check"][..]), ("gltf", &["--no-check"]), ("godot", &["--compress=quantize"])]
    {
        let words = ["simplify", "two.obj", "-o", "out.glb", "--force", "--lods", "50%,10%", "--engine", engine];
        succeed(folder.path(), &[&words, more].concat());
        let asset = Asset::read_path(&folder.path().join("out.glb")).unwrap();
        let faces: Vec<usize> = asset.parts().iter().map(|part| part.mesh.faces.len()).collect();
        assert_eq!(faces.len(), 4, "{engine}");
        assert!(faces[0] > 3 * faces[2] && faces[1] > 3 * faces[3] && faces.iter().all(|&n| n > 50), "{faces:?}");
        let materials = |part: usize| &asset.parts()[part].materials[..];
        assert_eq!([materials(0), materials(2)], [["red"]; 2]);
        assert_eq!([materials(1), materials(3)], [["red", "blue"]; 2]);
    }
    assert!(folder.path().join("out_LODs.gd").exists());
    // An object without a name is named after the file, and each level keeps its place.
    let spot = test_mesh_path("spot.ply");
    let words = ["-o", "out.gltf", "--lods", "50%,10%", "--engine", "unity", "--no-check"];
    succeed(folder.path(), &[&["simplify", spot.to_str().unwrap()], &words[..]].concat());
    let document = json(&folder.path().join("out.gltf"));
    let names: Vec<&str> = document["nodes"].as_array().unwrap().iter().filter_map(|it| it["name"].as_str()).collect();
    assert_eq!(names, ["out", "out_LOD0", "out_LOD1"]);
}

#[test]
fn separate_levels_of_a_scene_share_their_buffer() {
    let (apart, embedded) = (avatar_levels("unreal", "out.gltf"), avatar_levels("unreal", "out.glb"));
    let mut names: Vec<_> = std::fs::read_dir(apart.path()).unwrap().map(|file| file.unwrap().file_name()).collect();
    names.sort();
    assert_eq!(names, ["out.bin", "out_0.png", "out_LOD0.gltf", "out_LOD1.gltf", "scene.glb"]);
    let buffer = std::fs::read(apart.path().join("out.bin")).unwrap();
    let mut n_bytes = 0;
    for level in [0, 1] {
        let document = json(&apart.path().join(format!("out_LOD{level}.gltf")));
        assert_eq!(document["buffers"], serde_json::json!([{"byteLength": buffer.len(), "uri": "out.bin"}]));
        let [one, other] =
            [apart.path().join(format!("out_LOD{level}.gltf")), embedded.path().join(format!("out_LOD{level}.glb"))]
                .map(|path| Asset::read_path(&path).unwrap());
        assert!(one.parts().iter().map(|part| &part.mesh).eq(other.parts().iter().map(|part| &part.mesh)));
        n_bytes += document["bufferViews"]
            .as_array()
            .unwrap()
            .iter()
            .map(|view| view["byteLength"].as_u64().unwrap())
            .sum::<u64>();
    }
    // The bones, the animations and the keys' rows of zeros are there once.
    assert!((buffer.len() as u64) < n_bytes, "{} {n_bytes}", buffer.len());
}

#[test]
fn distances_of_levels_are_those_of_the_field_of_view() {
    let view = |more: &[&str]| {
        let folder = avatar_levels_with("godot", "out.glb", &[more, &["--report", "a.json"]].concat());
        let level = json(&folder.path().join("a.json"))["levels"][1].clone();
        let script = std::fs::read_to_string(folder.path().join("out_LODs.gd")).unwrap();
        let distance = level["switch_distance"].as_f64().unwrap();
        let end = format!("{:?}", distance as f32);
        assert!(script.contains(&format!("const RANGES = [[0.0, {end}], [{end}, 0.0]]")), "{script}");
        (distance, level["screen_coverage"].as_f64().unwrap())
    };
    let ((narrow, coverage), (wide, same_coverage)) = (view(&[]), view(&["--field-of-view", "90"]));
    let tangent = 30f64.to_radians().tan();
    assert!((narrow / wide * tangent - 1.0).abs() < 1e-9 && coverage == same_coverage, "{narrow} {wide}");
    // At that distance the diagonal of two spheres, three units apart, takes this share of the screen.
    let diagonal = 2.0 * narrow * tangent * coverage;
    assert!((5.0..7.0).contains(&diagonal), "{diagonal}");
    let folder = folder();
    let refused = levels(folder.path(), &["--lods", "50%", "--field-of-view", "180"]);
    assert!(error_line(&refused).contains("give degrees above 0 and below 180"), "{}", refused.stderr);
    let alone = levels(folder.path(), &["--ratio", "50%", "--field-of-view", "40"]);
    assert!(error_line(&alone).contains("--field-of-view: give --lods, too"), "{}", alone.stderr);
}

#[test]
fn proved_distances_decide_from_where_levels_are_drawn() {
    let folder = folder();
    let run = levels(folder.path(), &["--lods", "1%,3%", "--lods-by", "error"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    for level in json(&folder.path().join("a.json"))["levels"].as_array().unwrap() {
        let proved = level["certified"]["upper_percent"].as_f64().unwrap();
        let coverage = level["screen_coverage"].as_f64().unwrap();
        assert!((coverage * 1080.0 * proved - 100.0).abs() < 1e-6, "{level}");
        let distance = level["certified"]["upper"].as_f64().unwrap() * 540.0 / 30f64.to_radians().tan();
        assert!((level["switch_distance"].as_f64().unwrap() / distance - 1.0).abs() < 1e-6, "{level}");
    }
}

#[test]
fn older_levels_stay_and_are_named() {
    let folder = folder();
    let path = |level: usize| folder.path().join(format!("a-lod{level}.ply"));
    let first = levels(folder.path(), &["--lods", "60%,40%,20%,10%", "--no-check"]);
    assert!(!String::from_utf8_lossy(&first.stdout).contains("left as they are"));
    let theirs = std::fs::read(path(3)).unwrap();
    // A file after a gap is not of a set.
    std::fs::write(path(7), "theirs").unwrap();
    let second = levels(folder.path(), &["--lods", "50%,25%", "--no-check", "--force"]);
    assert_eq!(second.code, Some(0), "{}", second.stderr);
    let said = String::from_utf8(second.stdout).unwrap();
    assert!(said.contains("left as they are: a-lod2.ply, a-lod3.ply\n"), "{said}");
    assert!(std::fs::read(path(3)).unwrap() == theirs && std::fs::read(path(7)).unwrap() == b"theirs");
}
