//! Compressed files: `.gz` as input and output, and glTF that other programs have compressed.

use std::fs;
use std::path::{Path, PathBuf};

use neural_mesh::io::{ReadMesh, read_attributed_path};
use neural_mesh::mesh::Role;

use crate::common::*;

// Files of gltfpack and gltf-transform, made from `ring.glb` by `scripts/compressed_files`.
fn compressed_gltf() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/meshes/compressed");
    let mut paths: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    assert_eq!(paths.len(), 13);
    paths
}

// Returns the mean of a channel over the corners of all faces.
fn mean(read: &ReadMesh, role: Role) -> Vec<f32> {
    let channel = read.mesh.attributes.channel(role).unwrap();
    let wedges = read.mesh.attributes.wedges.as_flattened();
    let sum = |k: usize| wedges.iter().map(|&wedge| channel.value(wedge)[k]).sum::<f32>();
    (0..channel.width.min(3)).map(|k| sum(k) / wedges.len() as f32).collect()
}

#[test]
fn gltf_that_others_have_compressed_is_read() {
    let paths = compressed_gltf();
    let read = |path: &Path| read_attributed_path(path, None).unwrap();
    let ring = read(paths.iter().find(|path| path.ends_with("ring.glb")).unwrap());
    for path in &paths {
        let found = read(path);
        assert_eq!(found.mesh.faces.len(), ring.mesh.faces.len(), "{}", path.display());
        let distance = |p: &[f64; 3], q: &[f64; 3]| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
        let nearest = |p: &[f64; 3]| ring.mesh.positions.iter().map(|q| distance(p, q)).fold(f64::INFINITY, f64::min);
        let farthest = found.mesh.positions.iter().map(nearest).fold(0.0, f64::max);
        assert!(farthest < 2e-3, "{}: {farthest}", path.display());
        for role in [Role::Normal, Role::Uv, Role::Colour] {
            let pairs = mean(&found, role).into_iter().zip(mean(&ring, role));
            let far = pairs.map(|(found, expected)| (found - expected).abs()).fold(0.0, f32::max);
            assert!(far < 0.02, "{} {role:?}: {far}", path.display());
        }
    }
}

#[test]
fn gltf_that_others_have_compressed_is_simplified_and_drawn() {
    let folder = folder();
    for path in compressed_gltf() {
        let mut words = vec!["simplify", path.to_str().unwrap(), "-o", "a.glb", "--ratio", "0.5", "-f"];
        // One file of each kind of texture: PNG, WebP and KTX2.
        if ["ring.glb", "transform_webp.glb", "ktx2.glb"].iter().any(|name| path.ends_with(name)) {
            words.extend(["--picture", "a.png"]);
        }
        let run = run(folder.path(), &words);
        assert_eq!(run.code, Some(0), "{}: {}", path.display(), run.stderr);
        let said = String::from_utf8(run.stdout).unwrap();
        assert!(!said.contains("is left out"), "{}: {said}", path.display());
        let info = info(folder.path(), "a.glb");
        assert_eq!(
            (&info["closed"], &info["scene"]["skins"][0]["joints"]),
            (&true.into(), &2.into()),
            "{}",
            path.display()
        );
    }
}

#[test]
fn compressed_meshes_go_in_and_out() {
    let folder = folder();
    let place = |name: &str| folder.path().join(name);
    let spot = test_mesh_path("spot.ply");
    for output in ["a.obj.gz", "a.ply"] {
        succeed(folder.path(), &["simplify", spot.to_str().unwrap(), "--ratio", "0.2", "-o", output]);
    }
    let packed = fs::read(place("a.obj.gz")).unwrap();
    assert!(packed.starts_with(b"\x1f\x8b"));
    assert_eq!(info(folder.path(), "a.obj.gz")["vertices"], info(folder.path(), "a.ply")["vertices"]);

    let run = run_with_input(folder.path(), &["simplify", "-", "--ratio", "0.5", "-o", "b.PLY.GZ"], &packed);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert!(fs::read(place("b.PLY.GZ")).unwrap().starts_with(b"\x1f\x8b"));
}

#[test]
fn results_of_a_batch_are_not_compressed() {
    let folder = folder();
    fs::create_dir(folder.path().join("in")).unwrap();
    let spot = test_mesh_path("spot.ply");
    succeed(folder.path(), &["simplify", spot.to_str().unwrap(), "--ratio", "0.2", "-o", "in/a.obj.gz"]);
    succeed(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.5"]);
    assert_eq!(files(&folder.path().join("out")), ["a.obj", "manifest.csv"]);
}

#[test]
fn damaged_data_is_refused_in_one_line() {
    let folder = folder();
    fs::write(folder.path().join("a.obj.gz"), b"\x1f\x8b\x08\x00 and no more").unwrap();
    let line = refuse(folder.path(), &["simplify", "a.obj.gz", "--ratio", "0.5", "-o", "b.obj"], 1);
    assert!(line.contains("the gzip data is cut or damaged"), "{line}");
}
