//! Builds without a feature name it and how to get it.
//!
//! A separate test program, so that a build without features compiles no other tests.
#![cfg(not(any(feature = "meshopt", feature = "train")))]

mod common;

use std::fs;

use common::*;

/// Program under test.
pub const PROGRAM: &str = env!("CARGO_BIN_EXE_neural-mesh");

#[test]
fn commands_that_are_not_there_say_how_to_get_them() {
    let folder = folder();
    {
        let command = "train";
        for more in [
            &[][..],
            &["--data", "meshes", "--out", "run", "--threads", "3"],
            &["--plot", "run"],
            &["--ratios=0.1,0.5", "-q", "words", "--", "--nonsense"],
            &["--help"],
        ] {
            let refused = run(folder.path(), &[&[command], more].concat());
            assert_eq!(refused.code, Some(2), "{command} {more:?}: {}", refused.stderr);
            let line = error_line(&refused);
            for words in [
                format!("this build lacks the feature {command}"),
                format!("`cargo run --release --features {command} -- {command} ...`"),
                format!("`cargo install --path cli --features {command}`"),
            ] {
                assert!(line.contains(&words), "{line}");
            }
        }
        let help = String::from_utf8(run(folder.path(), &["--help"]).stdout).unwrap();
        assert!(help.contains(&format!("(needs the feature {command})")), "{help}");
    }
    assert_eq!(files(folder.path()), Vec::<String>::new());
}

#[cfg(not(feature = "ktx2"))]
#[test]
fn a_ktx2_keeps_its_bytes_and_the_feature_is_named() {
    let folder = folder();
    let face = "mtllib a.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";
    fs::write(folder.path().join("a.obj"), face).unwrap();
    fs::write(folder.path().join("a.mtl"), "newmtl a\nmap_Kd a.ktx2\n").unwrap();
    let image: &[u8] = include_bytes!("../../tests/images/etc1s.ktx2");
    fs::write(folder.path().join("a.ktx2"), image).unwrap();
    let words = ["simplify", "a.obj", "-o", "b.glb", "--ratio", "1", "--textures", "16", "--picture", "b.png"];
    let said = run(folder.path(), &words);
    assert_eq!(said.code, Some(0), "{}", said.stderr);
    let table = String::from_utf8(said.stdout).unwrap();
    for what in ["an image keeps its size", "a texture is left out"] {
        let line = format!("{what}: it is KTX2: build with `--features ktx2`, or give it as PNG, JPEG or WebP");
        assert_eq!(table.matches(&line).count(), 1, "{table}");
    }
    let written = fs::read(folder.path().join("b.glb")).unwrap();
    assert!(written.windows(image.len()).any(|bytes| bytes == image));
}

#[test]
fn compressed_gltf_is_refused_with_what_to_do() {
    let folder = folder();
    let asset = r#"{"asset": {"version": "2.0"}, "extensionsUsed": ["EXT_meshopt_compression"],
        "extensionsRequired": ["EXT_meshopt_compression"], "buffers": [{"byteLength": 4, "uri": "data:application/octet-stream;base64,AAAAAA=="}],
        "bufferViews": [{"buffer": 0, "byteLength": 4, "extensions": {"EXT_meshopt_compression": {}}}]}"#;
    fs::write(folder.path().join("a.gltf"), asset).unwrap();
    let refused = run(folder.path(), &["simplify", "a.gltf", "-o", "b.ply", "--ratio", "0.5"]);
    assert_eq!(refused.code, Some(1));
    let line = error_line(&refused);
    assert!(line.contains("EXT_meshopt_compression") && line.contains("`--features meshopt`"), "{line}");
}

#[cfg(not(feature = "bake"))]
#[test]
fn baking_is_refused_with_what_to_do() {
    let folder = folder();
    fs::write(folder.path().join("a.obj"), OCTAHEDRON).unwrap();
    let refused = run(folder.path(), &["simplify", "a.obj", "-o", "b.glb", "--ratio", "0.5", "--bake", "64"]);
    assert_eq!(refused.code, Some(2));
    let line = error_line(&refused);
    assert!(
        line.contains("lacks the feature bake") && line.contains("`cargo install --path cli --features bake`"),
        "{line}"
    );
    assert_eq!(files(folder.path()), ["a.obj"]);
}

#[test]
fn formats_that_a_build_lacks_are_refused_with_what_to_do() {
    let folder = folder();
    fs::write(folder.path().join("a.obj"), OCTAHEDRON).unwrap();
    fs::write(folder.path().join("a.fbx"), "; FBX 7.4.0 project file\nObjects:  {\n    Geometry: 1, \"a").unwrap();
    fs::write(folder.path().join("a.3mf"), b"PK\x03\x04 3D/a.model").unwrap();
    let refused = run(folder.path(), &["simplify", "a.obj", "-o", "b.fbx", "--ratio", "0.5"]);
    assert_eq!(refused.code, Some(2));
    assert!(error_line(&refused).contains("fbx can be read but not written: choose glb"), "{}", refused.stderr);
    if cfg!(not(feature = "3mf")) {
        let refused = run(folder.path(), &["simplify", "a.obj", "-o", "b.3mf", "--ratio", "0.5"]);
        assert_eq!(refused.code, Some(2));
        assert!(error_line(&refused).contains("build with the feature 3mf"), "{}", refused.stderr);
    }
    for (format, is_there) in [("3mf", cfg!(feature = "3mf")), ("fbx", cfg!(feature = "fbx"))] {
        let refused = run(folder.path(), &["info", &format!("a.{format}")]);
        assert_eq!(refused.code, Some(1), "{}", refused.stderr);
        let names_it = error_line(&refused).contains(&format!("build with the feature {format}"));
        assert_eq!(names_it, !is_there, "{}", refused.stderr);
    }
}
