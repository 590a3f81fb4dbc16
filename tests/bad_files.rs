//! Broken and unusual files give a one-line error or a valid mesh in short time.
//!
//! `tests/meshes/bad` is always read; the larger collection in `../shared/data` or `NEURAL_MESH_DATA` only if it exists.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use neural_mesh::io::{self, Format};
use neural_mesh::mesh::cleanup::{self, CleanOptions, Cleaned};

// Files of `tests/meshes/bad` without a usable face.
const REFUSED: [&str; 12] = [
    "all_same_point.ply",
    "ascii_stl_nan.stl",
    "faces_no_vertices.obj",
    "nan_text.obj",
    "not_a_mesh.obj",
    "obj_index_out_of_range.obj",
    "obj_index_zero.obj",
    "single_vertex.ply",
    "truncated_header.ply",
    "truncated_vertices.ply",
    "zero_bytes.stl",
    "README.md",
];

// Returns the mesh of a file or its error, within a minute.
fn outcome(path: &Path) -> Result<Cleaned, String> {
    let start = Instant::now();
    let result = io::read_path(path, None)
        .map_err(|error| error.to_string())
        .and_then(|raw| cleanup::clean(raw, &CleanOptions::default()).map_err(|error| error.to_string()));
    assert!(start.elapsed() < Duration::from_secs(60), "{path:?} took {:?}", start.elapsed());
    match &result {
        Err(line) => assert!(!line.is_empty() && !line.contains(['\n', '\r']), "{path:?}: {line:?}"),
        Ok(cleaned) => check(path, cleaned),
    }
    check_attributed(path, result.as_ref().ok());
    result
}

// Expects that the mesh is not empty, uses all vertices, and survives writing.
fn check(path: &Path, Cleaned { mesh, frame, source, .. }: &Cleaned) {
    assert!(!mesh.faces().is_empty(), "{path:?}");
    let mut used = vec![false; mesh.positions().len()];
    mesh.faces().iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
    assert!(used.into_iter().all(|used| used) && source.len() == mesh.positions().len(), "{path:?}");
    let bytes = io::write(mesh, frame, Format::Ply).unwrap();
    let again = cleanup::clean(io::read(&bytes, None).unwrap(), &CleanOptions::default()).unwrap();
    assert_eq!(again.mesh.faces(), mesh.faces(), "{path:?}");
}

// Expects that reading attributes gives the same mesh, which survives OBJ and PLY.
fn check_attributed(path: &Path, bare: Option<&Cleaned>) {
    let read = io::read_attributed_path(path, None).ok();
    assert!(read.iter().flat_map(|read| &read.notes).all(|note| !note.contains(['\n', '\r'])), "{path:?}");
    let cleaned = read.and_then(|read| Some((cleanup::clean(read.mesh, &CleanOptions::default()).ok()?, read.extra)));
    assert_eq!(cleaned.as_ref().map(|(cleaned, _)| &cleaned.mesh), bare.map(|bare| &bare.mesh), "{path:?}");
    let Some((Cleaned { mesh, frame, attributes, .. }, extra)) = &cleaned else { return };
    for format in [Format::Obj, Format::Ply] {
        let model = io::Model::new(mesh, *frame, attributes, extra);
        let options = io::WriteOptions::new(format, "out");
        let written = io::write_attributed(&model, &options).unwrap();
        let back = io::read_attributed(&written.bytes, Some(format)).unwrap();
        let back = cleanup::clean(back.mesh, &CleanOptions::default()).unwrap();
        assert_eq!(back.mesh.faces().len(), mesh.faces().len(), "{path:?} {format:?}");
        assert!(back.attributes.is_valid_for(mesh.faces().len()), "{path:?} {format:?}");
    }
}

#[test]
fn shipped_files() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes/bad");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        let result = outcome(&path);
        assert_eq!(result.is_err(), REFUSED.contains(&name), "{name}: {:?}", result.err());
    }
}

#[test]
fn shipped_files_are_cleaned_of_what_is_wrong() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes/bad");
    for (name, n_vertices, n_faces, cleaned) in [
        ("crlf_tabs_sci.obj", 642, 1280, "nothing"),
        ("ply_big_endian.ply", 642, 1280, "nothing"),
        ("ply_odd_properties.ply", 3, 1, "nothing"),
        ("obj_negative_quads.obj", 42, 40, "welded vertices: 38"),
        ("degenerate_index.ply", 642, 1248, "degenerate faces: 32"),
        ("inf_vertices.ply", 640, 1270, "unreferenced vertices: 2, faces with non-finite corners: 10"),
        ("face_two_vertices.obj", 3, 1, "faces with fewer than three corners: 1"),
        ("mixed_tri_quad_ngon.obj", 8, 6, "nothing"),
        ("ngon_concave_star.obj", 40, 38, "nothing"),
    ] {
        let Cleaned { mesh, counts, .. } = outcome(&folder.join(name)).unwrap();
        assert_eq!((mesh.positions().len(), mesh.faces().len()), (n_vertices, n_faces), "{name}");
        assert_eq!(counts.to_string(), cleaned, "{name}");
    }
}

#[test]
fn the_concave_star_is_covered_once() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes/bad/ngon_concave_star.obj");
    let mesh = outcome(&path).unwrap().mesh;
    let normal = |face: &[u32; 3]| {
        neural_mesh::geometry::triangle::area_normal(face.map(|v| mesh.positions()[v as usize].into()))
    };
    let sum: glam::Vec3 = mesh.faces().iter().map(normal).sum();
    let area: f32 = mesh.faces().iter().map(|face| normal(face).length()).sum();
    assert!((sum.length() - area).abs() < 1e-5 * area, "{} {area}", sum.length());
}

#[test]
fn collection() {
    let Some((manifest, folder)) = collection_folder() else {
        eprintln!("skipped: no collection of broken files beside the checkout");
        return;
    };
    let rows = manifest.lines().filter_map(|line| line.strip_prefix("bad,"));
    let mut n_files = 0;
    for row in rows {
        let (file, rest) = row.split_once(',').unwrap();
        let result = outcome(&folder.join(file));
        let says_valid = rest.split(|c: char| !c.is_ascii_alphabetic()).any(|word| word == "valid");
        assert!(!says_valid || result.is_ok(), "{file} is valid but refused: {:?}", result.err());
        n_files += 1;
    }
    assert!(n_files > 100);
}

// Returns the manifest and the unpacked folder of the collection, if it exists.
fn collection_folder() -> Option<(String, PathBuf)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let data = std::env::var_os("NEURAL_MESH_DATA").map_or(root.join("../shared/data"), PathBuf::from);
    let manifest = std::fs::read_to_string(data.join("MANIFEST.csv")).ok()?;
    let target = root.join("target/meshes");
    if !target.join("bad").is_dir() {
        std::fs::create_dir_all(&target).ok()?;
        // The archive is unpacked under another name and then renamed, so that a parallel test never reads half of it.
        let aside = tempfile::tempdir_in(&target).ok()?;
        let archive = data.join("bad.tar.xz");
        let status =
            std::process::Command::new("tar").arg("-xJf").arg(archive).arg("-C").arg(aside.path()).status().ok()?;
        if !status.success() {
            return None;
        }
        std::fs::rename(aside.path().join("bad"), target.join("bad")).ok();
    }
    Some((manifest, target.join("bad")))
}
