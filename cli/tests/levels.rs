//! `neural-mesh simplify --lods` by faces, vertices and distances.

use std::path::Path;

use crate::common::{Run, error_line, folder, json, run, succeed, test_mesh_path};
use neural_mesh::io::{self, Asset};

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
    let folder = folder();
    std::fs::write(folder.path().join("scene.glb"), crate::common::avatar::Avatar::new(8).glb()).unwrap();
    let words = ["simplify", "scene.glb", "-o", output, "--lods", "60%,30%", "--engine", engine, "--no-check"];
    succeed(folder.path(), &words);
    folder
}

fn gltf_json(path: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
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
        let document = gltf_json(&folder.path().join("out.gltf"));
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
