//! `neural-mesh simplify` from file to file.

use crate::common::*;
use neural_mesh::picture::{ImageFormat, decode_image};

fn cow(rest: &[&str]) -> Vec<String> {
    let input = test_mesh_path("spot.ply").to_str().unwrap().to_string();
    [&["simplify", &input, "--ratio", "0.2"], rest].concat().iter().map(|word| word.to_string()).collect()
}

fn run_cow(folder: &std::path::Path, rest: &[&str]) -> Run {
    let arguments = cow(rest);
    run(folder, &arguments.iter().map(String::as_str).collect::<Vec<_>>())
}

#[test]
fn a_closed_mesh_comes_out_lighter_and_closed() {
    let folder = folder();
    let run = run_cow(folder.path(), &["-o", "light.ply"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(files(folder.path()), ["light.ply"]);
    let info = info(folder.path(), "light.ply");
    assert!((585..=586).contains(&info["vertices"].as_u64().unwrap()), "{info}");
    assert!(info["closed"] == true && info["manifold"] == true && info["components"] == 1 && info["genus"] == 0);
}

#[test]
fn four_lines_close_the_run() {
    let folder = folder();
    let run = run_cow(folder.path(), &["-o", "light.ply"]);
    let words = String::from_utf8(run.stdout).unwrap();
    let starts: Vec<&str> = words.lines().map(|line| line.split(' ').next().unwrap()).collect();
    assert_eq!(starts, ["size", "file", "distance", "time"], "{words}");
    assert_eq!(run.stderr, "");
}

#[test]
fn no_check_and_quiet_leave_words_out() {
    let folder = folder();
    let unchecked = run_cow(folder.path(), &["-o", "a.ply", "--no-check", "--report", "a.json"]);
    assert_eq!(String::from_utf8(unchecked.stdout).unwrap().lines().count(), 3);
    assert!(json(&folder.path().join("a.json"))["distance"].is_null());
    let quiet = run_cow(folder.path(), &["-o", "b.ply", "--quiet"]);
    assert_eq!((quiet.code, quiet.stdout.len(), quiet.stderr.len()), (Some(0), 0, 0));
}

#[test]
fn the_report_holds_every_key() {
    let folder = folder();
    run_cow(folder.path(), &["-o", "light.ply", "--report", "r.json", "--seed", "7", "--threads", "2"]);
    let report = json(&folder.path().join("r.json"));
    let keys: Vec<&String> = report.as_object().unwrap().keys().collect();
    let asked = ["input", "output", "target", "outcome", "scores", "seed", "threads", "seconds", "cleaned", "distance"];
    assert_eq!(keys, asked);
    for side in ["input", "output"] {
        for key in ["vertices", "faces", "boundary_edges", "non_manifold_edges", "non_manifold_vertices", "components"]
        {
            assert!(report[side][key].is_u64(), "{side}.{key}");
        }
        assert!(report[side]["closed"] == true && report[side]["euler"] == 2);
    }
    for key in ["read", "simplify", "write", "check"] {
        assert!(report["seconds"][key].as_f64().unwrap() > 0.0, "{key}");
    }
    assert!(report["seconds"].get("picture").is_none());
    let drawn = run_cow(folder.path(), &["-o", "drawn.ply", "--report", "d.json", "--picture", "d.png"]);
    assert!(json(&folder.path().join("d.json"))["seconds"]["picture"].as_f64().unwrap() > 0.0);
    assert!(String::from_utf8(drawn.stdout).unwrap().lines().last().unwrap().contains(", picture "));
    let stages = report["seconds"]["stages"].as_object().unwrap();
    let in_stages: f64 = stages.values().map(|seconds| seconds.as_f64().unwrap()).sum();
    assert!(!stages.is_empty() && in_stages <= report["seconds"]["simplify"].as_f64().unwrap());
    assert_eq!(report["scores"], "bending");
    assert_eq!(report["outcome"], "reached");
    assert_eq!((&report["seed"], &report["threads"]), (&7.into(), &2.into()));
    assert_eq!(report["target"]["ratio"], 0.2);
    let [mean, max] = ["mean_percent", "max_percent"].map(|key| report["distance"][key].as_f64().unwrap());
    assert!(0.0 < mean && mean < max && max < 5.0, "{mean} {max}");
}

#[test]
fn the_same_request_gives_the_same_bytes_on_any_number_of_threads() {
    let folder = folder();
    for (output, threads) in [("a.obj", "1"), ("b.obj", "2"), ("c.obj", "8")] {
        assert_eq!(run_cow(folder.path(), &["-o", output, "--threads", threads]).code, Some(0));
    }
    let [a, b, c] = ["a.obj", "b.obj", "c.obj"].map(|name| std::fs::read(folder.path().join(name)).unwrap());
    assert!(a == b && b == c);
}

#[test]
fn vertices_and_faces_are_targets_too() {
    let folder = folder();
    let input = test_mesh_path("spot.ply");
    for (option, key) in [("--vertices", "vertices"), ("--faces", "faces")] {
        succeed(folder.path(), &["simplify", input.to_str().unwrap(), "-o", "a.off", option, "500", "--force"]);
        let n = info(folder.path(), "a.off")[key].as_u64().unwrap();
        assert!((499..=500).contains(&n), "{key}: {n}");
    }
}

#[test]
fn every_format_is_written_and_read_again() {
    let folder = folder();
    for name in ["a.obj", "a.ply", "a.stl", "a.off", "a.glb", "a.gltf", "a.obj.gz"] {
        assert_eq!(run_cow(folder.path(), &["-o", name, "--no-check"]).code, Some(0));
        let info = info(folder.path(), name);
        assert!(info["closed"] == true && info["manifold"] == true, "{name}: {info}");
    }
    for (format, name) in [("ply-ascii", "b.ply"), ("stl-ascii", "b.stl")] {
        assert_eq!(run_cow(folder.path(), &["-o", name, "--no-check", "--format", format]).code, Some(0));
        let text = std::fs::read(folder.path().join(name)).unwrap();
        assert!(text.is_ascii(), "{format}");
    }
}

#[test]
fn pipes_carry_meshes_and_words_go_elsewhere() {
    let folder = folder();
    let input = std::fs::read(test_mesh_path("spot.ply")).unwrap();
    let first =
        run_with_input(folder.path(), &["simplify", "-", "-o", "-", "--format", "off", "--ratio", "0.5"], &input);
    assert_eq!(first.code, Some(0), "{}", first.stderr);
    assert!(first.stdout.starts_with(b"OFF"));
    assert_eq!(first.stderr.lines().count(), 3);
    let second = run_with_input(folder.path(), &["simplify", "-", "-o", "b.ply", "--ratio", "0.5"], &first.stdout);
    assert_eq!(second.code, Some(0), "{}", second.stderr);
    assert_eq!(files(folder.path()), ["b.ply"]);
    let looked = run_with_input(folder.path(), &["info", "-"], &first.stdout);
    assert!(String::from_utf8(looked.stdout).unwrap().starts_with("standard input: 1,465 vertices"));
}

#[test]
fn standard_output_takes_no_levels_that_are_files_of_their_own() {
    let folder = folder();
    let input = test_mesh_path("spot.ply");
    let levels = ["simplify", input.to_str().unwrap(), "-o", "-", "--lods", "50%,20%", "--format"];
    for format in [&["obj"][..], &["glb", "--engine", "unreal"]] {
        let refused = run(folder.path(), &[&levels[..], format].concat());
        assert!(refused.code == Some(2) && refused.stdout.is_empty(), "{}", refused.stderr);
        assert!(error_line(&refused).contains("standard output takes one file"), "{}", refused.stderr);
    }
    assert_eq!(run(folder.path(), &[&levels[..], &["glb", "--engine", "unity"]].concat()).code, Some(0));
}

#[test]
fn the_bytes_of_a_mesh_are_those_before_its_result_replaces_it() {
    let folder = folder();
    std::fs::copy(test_mesh_path("spot.ply"), folder.path().join("a.ply")).unwrap();
    let run = succeed(folder.path(), &["simplify", "a.ply", "-o", "a.ply", "--ratio", "10%", "--force"]);
    let words = String::from_utf8(run.stdout).unwrap();
    let line = words.lines().find(|line| line.starts_with("file ")).unwrap();
    let (before, after) = line.split_once(" -> ").unwrap();
    assert!(!before.ends_with(after), "{line}");
}

#[test]
fn a_picture_shows_both_meshes() {
    let folder = folder();
    assert_eq!(run_cow(folder.path(), &["-o", "a.ply", "--picture", "a.png"]).code, Some(0));
    assert!(std::fs::read(folder.path().join("a.png")).unwrap().starts_with(b"\x89PNG"));
}

#[test]
fn a_picture_has_the_format_that_its_name_shows() {
    let folder = folder();
    for (name, format) in [
        ("a.png", ImageFormat::Png),
        ("a.JPG", ImageFormat::Jpeg),
        ("a.jpeg", ImageFormat::Jpeg),
        ("a.webp", ImageFormat::WebP),
    ] {
        run_cow(folder.path(), &["-o", "a.ply", "--force", "--picture", name]);
        let bytes = std::fs::read(folder.path().join(name)).unwrap();
        assert_eq!(ImageFormat::from_signature(&bytes), Some(format), "{name}");
        assert!(decode_image(&bytes).is_some(), "{name}");
    }
    let spot = test_mesh_path("spot.ply");
    let words = ["simplify", spot.to_str().unwrap(), "-o", "b.ply", "--ratio", "1%", "--picture", "b.gif"];
    assert_eq!(refuse(folder.path(), &words, 2), "neural-mesh: --picture b.gif: end the name in .png, .jpg or .webp");
}

#[test]
fn weights_that_are_none_are_refused() {
    let folder = folder();
    std::fs::write(folder.path().join("w.safetensors"), b"not weights").unwrap();
    let run = run_cow(folder.path(), &["-o", "a.ply", "--weights", "w.safetensors"]);
    assert_eq!(run.code, Some(1));
    assert!(error_line(&run).contains("w.safetensors"));
    assert_eq!(files(folder.path()), ["w.safetensors"]);
}

#[test]
fn scores_may_come_from_the_geometry_alone() {
    let folder = folder();
    let run = run_cow(folder.path(), &["-o", "a.ply", "--scores", "geometry", "--report", "r.json"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(json(&folder.path().join("r.json"))["scores"], "geometry");
}

#[test]
fn the_paper_assembly_works_without_weights_and_keeps_positions_of_the_input() {
    let folder = folder();
    let rest = ["-o", "a.ply", "--assembly", "paper", "--report", "r.json"];
    let run = run_cow(folder.path(), &rest);
    // Random weights may keep no face at all.
    if run.code == Some(1) {
        error_line(&run);
        return;
    }
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    assert_eq!(json(&folder.path().join("r.json"))["scores"], "network");
    let read = |path: &std::path::Path| neural_mesh::io::read_path(path, None).unwrap().positions;
    let original = read(&test_mesh_path("spot.ply"));
    for position in read(&folder.path().join("a.ply")) {
        assert!(original.contains(&position), "{position:?}");
    }
}

#[test]
fn the_holes_that_the_network_leaves_are_closed() {
    use neural_mesh::mesh::cleanup::{CleanOptions, clean};
    let folder = folder();
    let open_edges = |rest: &[&str]| {
        let input = test_mesh_path("spot.ply");
        let words =
            [&["simplify", input.to_str().unwrap(), "-o", "a.ply", "--force", "--assembly", "paper"], rest].concat();
        succeed(folder.path(), &[&words[..], &["--ratio", "0.03"]].concat());
        let raw = neural_mesh::io::read_path(&folder.path().join("a.ply"), None).unwrap();
        let mesh = clean(raw, &CleanOptions::default()).unwrap().mesh;
        neural_mesh::mesh::topology(&mesh).boundary_edges
    };
    let [before, after] = [open_edges(&[]), open_edges(&["--close"])];
    assert!(before > 0 && after == 0, "{before} {after}");
}

#[test]
fn coordinates_far_from_the_origin_keep_their_precision() {
    let folder = folder();
    let moved: String = OCTAHEDRON
        .lines()
        .map(|line| match line.strip_prefix("v ") {
            Some(numbers) => {
                let at: Vec<f64> = numbers.split(' ').map(|x| x.parse::<f64>().unwrap() * 0.001 + 5e6).collect();
                format!("v {} {} {}\n", at[0], at[1], at[2])
            }
            None => format!("{line}\n"),
        })
        .collect();
    let run = run_with_input(folder.path(), &["simplify", "-", "-o", "a.obj", "--ratio", "1"], moved.as_bytes());
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let text = std::fs::read_to_string(folder.path().join("a.obj")).unwrap();
    for line in text.lines().filter(|line| line.starts_with("v ")) {
        for x in line.split(' ').skip(1) {
            let away = (x.parse::<f64>().unwrap() - 5e6).abs();
            assert!(away < 1e-8 || (away - 0.001).abs() < 1e-8, "{line}");
        }
    }
}
