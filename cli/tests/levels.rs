//! `neural-mesh simplify --lods` by faces, vertices and distances.

use std::path::Path;

use crate::common::{Run, error_line, folder, json, run, test_mesh_path};
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
    let run = run(folder.path(), &words);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
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
    let run = run(folder.path(), &words);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
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
