//! Parsing of numbers, and errors that name the accepted range.

use crate::common::*;
use neural_mesh::io;
use neural_mesh::mesh::shapes;
use neural_mesh::model::Weights;

fn cow(size: &[&str]) -> serde_json::Value {
    let (folder, input) = (folder(), test_mesh_path("spot.ply"));
    let all = ["simplify", input.to_str().unwrap(), "-o", "a.off", "--no-check", "--json"];
    let run = run(folder.path(), &[&all[..], size].concat());
    assert_eq!(run.code, Some(0), "{size:?}: {}", run.stderr);
    serde_json::from_slice(&run.stdout).unwrap()
}

#[track_caller]
fn refusal(words: &[&str]) -> String {
    refuse(folder().path(), words, 2)
}

#[test]
fn percent_and_fractions_ask_for_the_same() {
    let [share, percent] = [["--ratio", "0.1"], ["--ratio", "10%"]].map(|size| cow(&size));
    assert_eq!((&share["target"], &share["output"]["vertices"]), (&percent["target"], &percent["output"]["vertices"]));
    assert_eq!(percent["target"]["ratio"], 0.1);
    let of_vertices = cow(&["--vertices", "10%"]);
    assert_eq!(of_vertices["output"]["vertices"], share["output"]["vertices"]);
}

#[test]
fn a_share_of_the_faces_is_one_of_the_faces_of_the_input() {
    let report = cow(&["--faces", "10%"]);
    assert_eq!((&report["input"]["faces"], &report["target"]["faces_percent"]), (&5856.into(), &10.0.into()));
    assert!((584..=585).contains(&report["output"]["faces"].as_u64().unwrap()), "{}", report["output"]);
}

#[test]
fn thousands_have_suffixes() {
    for (typed, faces) in [("1k", 1000), ("1.5K", 1500), ("0.002M", 2000)] {
        let report = cow(&["--faces", typed]);
        assert_eq!(report["target"]["faces"], faces, "{typed}");
        assert!(report["output"]["faces"].as_u64().unwrap() <= faces, "{typed}");
    }
}

#[test]
fn levels_of_detail_take_percent() {
    let report = cow(&["--lods", "50%,25%,10%"]);
    assert_eq!(report["target"]["lods"], serde_json::json!([0.5, 0.25, 0.1]));
    assert_eq!(report["levels"].as_array().unwrap().len(), 3);
}

#[test]
fn clouds_take_the_same_sizes() {
    let folder = folder();
    std::fs::write(folder.path().join("w.safetensors"), Weights::random(1).to_bytes()).unwrap();
    let lines: String = shapes::icosphere(2).positions().iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    std::fs::write(folder.path().join("ball.xyz"), lines).unwrap();
    let report = |size: [&str; 2]| {
        let all = ["mesh-points", "ball.xyz", "--weights", "w.safetensors", "-o", "a.ply", "--force", "--report", "-"];
        let run = run(folder.path(), &[&all[..], &size].concat());
        assert_eq!(run.code, Some(0), "{size:?}: {}", run.stderr);
        let mut report: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
        report["seconds"] = 0.into();
        report
    };
    let half = report(["--ratio", "0.5"]);
    assert_eq!(half["vertices"].as_u64().unwrap() + half["unused_points"].as_u64().unwrap(), 81);
    for size in [["--ratio", "50%"], ["--vertices", "50%"], ["--vertices", "0.081k"]] {
        assert_eq!(report(size), half, "{size:?}");
    }
}

#[test]
fn a_ratio_in_percent_without_its_sign_is_suggested() {
    let line = refusal(&["simplify", "missing.ply", "-o", "a.ply", "--ratio", "50"]);
    assert_eq!(
        line,
        "neural-mesh: --ratio 50: give a share above 0 and at most 1, like 0.1, or in percent, like 10%; did you mean 50%?"
    );
    let line = refusal(&["simplify", "missing.ply", "-o", "a.ply", "--lods", "50,25"]);
    assert!(line.contains("--lods 50: ") && line.ends_with("did you mean 50%?"), "{line}");
    let line = refusal(&["mesh-points", "missing.ply", "-o", "a.ply", "--ratio", "25"]);
    assert!(line.ends_with("did you mean 25%?"), "{line}");
    let line = refusal(&["simplify", "missing.ply", "-o", "a.ply", "--faces", "0.25"]);
    assert!(line.ends_with("did you mean 25%?"), "{line}");
}

#[test]
fn every_number_that_is_none_is_told_what_is_taken() {
    let simplify: &[&str] = &["simplify", "missing.ply", "-o", "a.glb"];
    let sized: &[&str] = &["simplify", "missing.ply", "-o", "a.glb", "--ratio", "0.5"];
    let points: &[&str] = &["mesh-points", "missing.ply", "-o", "a.ply"];
    let compare: &[&str] = &["compare", "missing.ply", "b.ply"];
    let cases = [
        (simplify, "--ratio", "-1", "like 10%"),
        (simplify, "--vertices", "0", "10k or 1.5M"),
        (simplify, "--faces", "-5", "10k or 1.5M"),
        (simplify, "--error", "-1", "like 0.5%"),
        (simplify, "--size", "0", "like 500kB or 2MB"),
        (simplify, "--lods", "2,1", "like 10%"),
        (sized, "--memory", "-1", "a number of GiB above 0"),
        (sized, "--crease-angle", "200", "degrees from 0 to 180"),
        (sized, "--seam-error", "-1", "texels, 0 or more"),
        (sized, "--seed", "-1", "a whole number of at least 0"),
        (sized, "--threads", "0", "from 1 to 1024"),
        (sized, "--fill-holes=", "-1", "a whole number of at least 0"),
        (sized, "--prune=", "-1", "like 0.5%"),
        (sized, "--printable=", "-1", "like 0.5%"),
        (sized, "--weld", "-1", "like 0.5%"),
        (points, "--ratio", "0", "like 10%"),
        (points, "--vertices", "0", "10k or 1.5M"),
        (points, "--seed", "-1", "a whole number of at least 0"),
        (points, "--threads", "1025", "from 1 to 1024"),
        (compare, "--samples", "0", "from 1 to 10000000"),
        (compare, "--seed", "-1", "a whole number of at least 0"),
        (compare, "--threads", "-1", "from 1 to 1024"),
    ];
    refuse_each(&cases);
}

/// First arguments, an option, a bad value, and the error message.
type Case<'a> = (&'a [&'a str], &'a str, &'a str, &'a str);

#[track_caller]
fn refuse_each(cases: &[Case]) {
    for &(words, option, out_of_range, taken) in cases {
        for value in ["garbage", out_of_range, "1e", "nan"] {
            let joined = format!("{option}{value}");
            let more = if option.ends_with('=') { vec![joined.as_str()] } else { vec![option, value] };
            let line = refusal(&[words, &more].concat());
            let name = option.trim_end_matches('=');
            assert!(line.starts_with(&format!("neural-mesh: {name}")) && line.contains(taken), "{line}");
            assert!(!line.contains("invalid"), "{line}");
        }
    }
}

#[cfg(feature = "bake")]
#[test]
fn sizes_of_textures_are_whole_numbers() {
    refuse_each(&[(&["simplify", "missing.ply", "-o", "a.glb", "--ratio", "0.5"], "--bake", "9", "from 16 to 8192")]);
}

#[test]
fn numbers_of_train_are_told_what_is_taken() {
    let train: &[&str] = &["train", "--data", "missing", "--out", "run"];
    refuse_each(&[(train, "--epochs", "0", "at least 1"), (train, "--threads", "0", "from 1 to 1024")]);
}

#[test]
fn a_format_that_is_not_known_says_which_are() {
    let line = refusal(&["simplify", "missing.ply", "-o", "a.xyz", "--ratio", "0.5"]);
    let endings = "a.xyz: the format is not known: end the name in .obj, .ply, .stl, .off, .gltf, .glb or .3mf, or";
    assert!(line.contains(endings), "{line}");
    assert!(line.contains("or give --format, one of obj, ply, ply-ascii, stl, stl-ascii, off, gltf, glb"), "{line}");
    assert!(!line.contains("fbx"), "{line}");
    let line = refusal(&["mesh-points", "missing.ply", "-o", "-"]);
    assert!(line.contains("standard output: the format is not known: give --format, one of obj, "), "{line}");
    let line = refusal(&["simplify", "missing.ply", "-o", "none/", "--ratio", "0.5"]);
    assert!(line.contains("none/: there is no such folder: create it first"), "{line}");
}

#[test]
fn content_that_is_not_known_says_what_can_be_read_and_which_format_is_meant() {
    let folder = folder();
    std::fs::write(folder.path().join("a.dat"), "hello").unwrap();
    let line = |words: &[&str]| refuse(folder.path(), words, 1);
    // Formats that this build reads.
    let more = [("3MF", io::Format::ThreeMf), ("FBX", io::Format::Fbx)];
    let more = more.into_iter().filter(|(_, format)| io::can_read(*format)).map(|(name, _)| name);
    let names: Vec<&str> = ["OBJ", "PLY", "STL", "OFF", "glTF", "GLB", "VRM"].into_iter().chain(more).collect();
    let (last, others) = names.split_last().unwrap();
    let all = format!("a.dat: the content has no known format: give {} or {last}", others.join(", "));
    for (words, more) in [
        (
            &["simplify", "a.dat", "-o", "-", "--ratio", "1"][..],
            "; --format NAME sets the format of the result, and that of IN if nothing else shows it",
        ),
        (
            &["simplify", "a.dat", "-o", "b.ply", "--ratio", "1"],
            "; --format NAME sets the format of IN, as the name of OUT has a known ending",
        ),
        (&["info", "a.dat"], "; --format NAME sets the format of the file"),
        (&["compare", "a.dat", "a.dat"], ""),
    ] {
        assert_eq!(line(words), format!("neural-mesh: {all}{more}"));
    }
}
