//! `--compress`: quantised glTF within the promised precision.

use std::path::Path;

use crate::common::*;
use neural_mesh::io::{self, Asset};
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use neural_mesh::mesh::{TriMesh, topology};
use neural_mesh::metrics::quick_distance;

fn compress_options() -> &'static [&'static str] {
    if cfg!(feature = "meshopt") { &["--compress=quantize", "--compress"] } else { &["--compress=quantize"] }
}

fn simplify_spot(folder: &Path, output: &str, more: &[&str]) -> Run {
    let spot = test_mesh_path("spot.ply");
    let words = ["simplify", spot.to_str().unwrap(), "-o", output, "--force", "--report", "r.json"];
    succeed(folder, &[&words[..], more].concat())
}

fn mesh(path: &Path) -> TriMesh {
    let raw = io::read_path(path, None).unwrap();
    clean(raw, &CleanOptions::default()).unwrap().mesh
}

fn is_closed(mesh: &TriMesh) -> bool {
    let found = topology(mesh);
    found.closed && found.non_manifold_edges + found.non_manifold_vertices + found.inconsistent_edges == 0
}

#[test]
fn closed_meshes_stay_closed_and_take_a_third_of_the_bytes() {
    let folder = folder();
    simplify_spot(folder.path(), "plain.glb", &["--ratio", "0.5"]);
    let plain = std::fs::metadata(folder.path().join("plain.glb")).unwrap().len();
    for way in compress_options() {
        simplify_spot(folder.path(), "small.glb", &["--ratio", "0.5", way]);
        let (small, before) = (mesh(&folder.path().join("small.glb")), mesh(&folder.path().join("plain.glb")));
        assert!(is_closed(&small));
        assert_eq!((small.positions().len(), small.faces().len()), (before.positions().len(), before.faces().len()));
        let n_bytes = std::fs::metadata(folder.path().join("small.glb")).unwrap().len();
        let most = if *way == "--compress" { 0.33 } else { 0.85 };
        assert!((n_bytes as f64) < most * plain as f64, "{way}: {n_bytes} of {plain}");
    }
}

#[test]
fn a_distance_bound_holds_for_the_quantised_file() {
    let folder = folder();
    let original = mesh(&test_mesh_path("spot.ply"));
    for error in ["0.5%", "0.02%"] {
        simplify_spot(folder.path(), "a.glb", &["--error", error, compress_options().last().unwrap()]);
        let said = json(&folder.path().join("r.json"))["certified"]["upper_percent"].as_f64().unwrap();
        assert!(said <= error.trim_end_matches('%').parse().unwrap(), "{said}");
        let found = quick_distance(&original, &mesh(&folder.path().join("a.glb")), 4000, 0).unwrap();
        assert!(100.0 * found.max / original.diagonal() <= said, "{found:?} {said}");
    }
    let spot = test_mesh_path("spot.ply");
    let line = refuse(
        folder.path(),
        &["simplify", spot.to_str().unwrap(), "-o", "b.glb", "--error", "1e-7", "--compress=quantize"],
        1,
    );
    assert!(line.contains("--compress moves vertices by up to"), "{line}");
}

#[test]
fn levels_are_packed_each_and_in_one_file() {
    let folder = folder();
    let way = compress_options().last().unwrap();
    simplify_spot(folder.path(), "a-{level}.glb", &["--lods", "50%,20%", way]);
    for level in ["a-0.glb", "a-1.glb"] {
        assert!(is_closed(&mesh(&folder.path().join(level))));
    }
    simplify_spot(folder.path(), "a.glb", &["--ratio", "1"]);
    let words = ["simplify", "a.glb", "-o", "lods.glb", "--lods", "50%,20%", way];
    succeed(folder.path(), &words);
    let asset = Asset::read_path(&folder.path().join("lods.glb")).unwrap();
    assert_eq!(asset.parts().len(), 2);
    // The node of the scene undoes the quantisation grid.
    assert!(asset.parts()[0].scale < 1e-3);
}

#[test]
fn unsupported_combinations_are_refused() {
    let folder = folder();
    let spot = test_mesh_path("spot.ply");
    for (output, more, why) in [
        ("a.ply", "--quiet", "ply is not glTF: write glb or gltf"),
        ("a.glb", "--lock-boundaries", "cannot be used with"),
        ("a.glb", "--subset", "cannot be used with"),
    ] {
        let words = ["simplify", spot.to_str().unwrap(), "-o", output, "--ratio", "0.5", "--compress=quantize", more];
        let refused = run(folder.path(), &words);
        assert!(refused.code == Some(2) && refused.stderr.contains(why), "{}", refused.stderr);
    }
}

#[cfg(not(feature = "meshopt"))]
#[test]
fn compression_is_refused_with_what_to_do() {
    let folder = folder();
    let spot = test_mesh_path("spot.ply");
    let refused =
        run(folder.path(), &["simplify", spot.to_str().unwrap(), "-o", "a.glb", "--ratio", "0.5", "--compress"]);
    assert_eq!(refused.code, Some(2));
    assert!(error_line(&refused).contains("lacks the feature meshopt"), "{}", refused.stderr);
    assert_eq!(files(folder.path()), Vec::<String>::new());
}
