//! `neural-mesh limits`: how small meshes get.

use crate::common::avatar::Avatar;
use crate::common::{OCTAHEDRON, files, folder, refuse, succeed, test_mesh_path, write_sphere_and_speck};
use serde_json::Value;

fn limits(folder: &std::path::Path, more: &[&str]) -> Value {
    let run = succeed(folder, &[&["limits", "--json"], more].concat());
    serde_json::from_slice(&run.stdout).unwrap()
}

#[test]
fn sizes_fall_and_distances_rise_down_to_the_smallest_closed_surface() {
    let folder = folder();
    let said = limits(folder.path(), &[test_mesh_path("spot.ply").to_str().unwrap()]);
    let levels = said["levels"].as_array().unwrap();
    let list_numbers = |key: &str| levels.iter().map(|level| level[key].as_f64().unwrap()).collect::<Vec<_>>();
    assert_eq!(list_numbers("percent"), [50.0, 25.0, 10.0, 5.0, 2.0, 1.0]);
    assert_eq!(list_numbers("vertices"), [1465.0, 732.0, 293.0, 146.0, 58.0, 29.0]);
    assert!(list_numbers("mean_percent").windows(2).all(|pair| pair[0] < pair[1]), "{said}");
    assert!(list_numbers("flip").windows(2).all(|pair| pair[0] < pair[1]) && list_numbers("flip")[0] > 0.0, "{said}");
    let smallest = &said["smallest"];
    assert!(smallest["vertices"].as_u64().unwrap() < 29 && smallest["components"] == 1, "{said}");
    assert!(said["outcome"].as_str().unwrap().starts_with("stopped: "), "{said}");
    assert_eq!(files(folder.path()), Vec::<String>::new());
}

#[test]
fn dropped_components_are_named_at_the_size_that_drops_them() {
    let folder = folder();
    write_sphere_and_speck(folder.path());
    let said = limits(folder.path(), &["two.obj", "--format", "stl"]);
    let rows = said["levels"].as_array().unwrap().iter().chain([&said["smallest"]]);
    let dropped: usize = rows.map(|row| row["dropped"].as_array().unwrap().len()).sum();
    assert_eq!((said["components"].as_u64(), dropped), (Some(2), 1), "{said}");
    let kept = limits(folder.path(), &["two.obj", "--format", "stl", "--keep-components"]);
    assert_eq!(kept["smallest"]["components"], 2);
    assert!(kept["smallest"]["vertices"].as_u64() > said["smallest"]["vertices"].as_u64());
}

#[test]
fn locked_and_kept_faces_limit_the_size() {
    let folder = folder();
    std::fs::write(folder.path().join("scene.glb"), Avatar::new(8).glb()).unwrap();
    let free = limits(folder.path(), &["scene.glb"]);
    let kept = limits(folder.path(), &["scene.glb", "--keep", "plain"]);
    let [free_size, kept_size] = [&free, &kept].map(|said| said["smallest"]["vertices"].as_u64().unwrap());
    assert!(free_size < 200 && kept_size >= 642, "{free_size} {kept_size}");
    assert_eq!(kept["held"]["locked_vertices"], 642);
    assert!(
        kept["free"]
            .as_array()
            .unwrap()
            .iter()
            .any(|line| line == "without --keep plain those faces are simplified too")
    );
    let line = refuse(folder.path(), &["limits", "scene.glb", "--keep", "nothing"], 2);
    assert!(line.contains("it has: ball, body"), "{line}");
}

#[test]
fn the_table_is_for_people_and_standard_input_is_taken() {
    let folder = folder();
    let run = crate::common::run_with_input(folder.path(), &["limits", "-"], OCTAHEDRON.as_bytes());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let said = String::from_utf8(run.stdout).unwrap();
    assert!(said.starts_with("standard input: 6 vertices, 8 faces, components: 1, closed\nsize "), "{said}");
    assert!(said.contains("\nsmallest") && said.contains("\nlimit     nothing smaller keeps this: "), "{said}");
    assert_eq!(crate::common::run(folder.path(), &["limits", "missing.ply"]).code, Some(1));
    assert_eq!(crate::common::run(folder.path(), &["limits"]).code, Some(2));
}
