//! Builds without a feature name it and how to get it.
//!
//! A separate test program, so that a build without features compiles no other tests.
#![cfg(not(any(feature = "bake", feature = "fbx", feature = "meshopt")))]

mod common;

use std::fs;

use common::*;

/// Program under test.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_neural-mesh");

#[test]
fn the_help_lists_no_more_than_the_build_has() {
    let folder = folder();
    let help = |option: &str| String::from_utf8(run(folder.path(), &["simplify", option]).stdout).unwrap();
    for text in [help("--help"), help("--help-all")] {
        assert!(text.contains("3MF") && text.contains("--compress"), "{text}");
        for lacking in ["FBX", "--bake ", "EXT_meshopt_compression"] {
            assert!(!text.contains(lacking), "{lacking}: {text}");
        }
    }
    assert!(help("--help-all").contains("(Draco, meshopt, KTX2)"));
}

#[test]
fn baking_is_refused_with_what_to_do() {
    let folder = folder_with_octahedron();
    let line = refuse(folder.path(), &["simplify", "a.obj", "-o", "b.glb", "--ratio", "0.5", "--bake", "64"], 2);
    assert!(
        line.contains("lacks the feature bake") && line.contains("`cargo install --path cli --features bake`"),
        "{line}"
    );
    assert_eq!(files(folder.path()), ["a.obj"]);
}

#[test]
fn formats_that_a_build_lacks_are_refused_with_what_to_do() {
    let folder = folder_with_octahedron();
    fs::write(folder.path().join("a.fbx"), "; FBX 7.4.0 project file\nObjects:  {\n    Geometry: 1, \"a").unwrap();
    fs::write(folder.path().join("a.3mf"), b"PK\x03\x04 3D/a.model").unwrap();
    let line = refuse(folder.path(), &["simplify", "a.obj", "-o", "b.fbx", "--ratio", "0.5"], 2);
    assert!(line.contains("fbx is not written: choose glb"), "{line}");
    for (format, is_there) in [("3mf", true), ("fbx", false)] {
        let refused = run(folder.path(), &["info", &format!("a.{format}")]);
        assert_eq!(refused.code, Some(1), "{}", refused.stderr);
        let names_it = error_line(&refused).contains(&format!("build with the feature {format}"));
        assert_eq!(names_it, !is_there, "{}", refused.stderr);
    }
}
