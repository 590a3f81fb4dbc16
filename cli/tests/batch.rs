//! `neural-mesh simplify` on many meshes.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common::*;
use neural_mesh::io::{Format, write};
use neural_mesh::mesh::{Frame, TriMesh, shapes};

fn manifest(folder: &Path) -> BTreeMap<String, BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(folder.join("manifest.csv")).unwrap();
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_string).collect();
    let row = |record: csv::StringRecord| -> BTreeMap<String, String> {
        names.iter().cloned().zip(record.iter().map(str::to_string)).collect()
    };
    reader.records().map(|record| row(record.unwrap())).map(|row| (row["name"].clone(), row)).collect()
}

fn outcome(folder: &Path, mesh: &str) -> String {
    manifest(folder)[mesh]["outcome"].clone()
}

fn write_mesh(path: &Path, mesh: &TriMesh, format: Format) {
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, write(mesh, &Frame::default(), format).unwrap()).unwrap();
}

fn folder_of_meshes() -> tempfile::TempDir {
    let folder = folder();
    let input = folder.path().join("in");
    write_mesh(&input.join("a.obj"), &shapes::icosphere(3), Format::Obj);
    write_mesh(&input.join("a.ply"), &shapes::torus(24, 16, 1.0, 0.3), Format::Ply);
    write_mesh(&input.join("deep/er/b.stl"), &shapes::bolt(16), Format::Stl);
    write_mesh(&input.join("c.off"), &shapes::grid(12, 9), Format::Off);
    fs::write(input.join("words.txt"), "no mesh").unwrap();
    folder
}

#[cfg(target_os = "linux")]
#[test]
fn meshes_whose_names_differ_by_case_are_two() {
    let folder = folder();
    write_mesh(&folder.path().join("in/a.ply"), &shapes::icosphere(2), Format::Ply);
    write_mesh(&folder.path().join("in/A.ply"), &shapes::icosphere(3), Format::Ply);
    for more in [&[][..], &["--force"]] {
        succeed(folder.path(), &[&["simplify", "in", "-o", "out", "--ratio", "0.5"], more].concat());
    }
    assert_eq!(files(&folder.path().join("out")), ["A.ply", "a.ply", "manifest.csv"]);
}

#[test]
fn a_folder_becomes_a_folder_with_a_manifest() {
    let folder = folder_of_meshes();
    succeed(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.2"]);
    let out = folder.path().join("out");
    assert_eq!(files(&out), ["a.obj", "a.ply", "c.off", "deep", "manifest.csv"]);
    assert_eq!(files(&out.join("deep/er")), ["b.stl"]);
    let rows = manifest(&out);
    assert_eq!(rows.keys().collect::<Vec<_>>(), ["a.obj", "a.ply", "c.off", "deep/er/b.stl"]);
    for row in rows.values() {
        assert_eq!(row["outcome"], "reached");
        let figure = |name: &str| row[name].parse::<f64>().unwrap();
        assert!(figure("output_vertices") <= (0.2 * figure("vertices")).ceil(), "{row:?}");
        assert!(figure("mean_percent") > 0.0 && figure("max_percent") >= figure("mean_percent"), "{row:?}");
        assert!(figure("seconds") > 0.0);
        let result = info(&out, &row["output"]);
        assert_eq!(result["faces"].to_string(), row["output_faces"]);
    }
}

#[test]
fn a_size_in_other_words_is_the_same_batch() {
    let folder = folder_of_meshes();
    let batch = |out: &str, size: [&str; 2], more: &[&str]| {
        run(folder.path(), &[&["simplify", "in", "-o", out], &size[..], more].concat())
    };
    for (out, size, same, other) in [
        ("a", ["--ratio", "20%"], ["--ratio", "0.2"], ["--ratio", "21%"]),
        ("b", ["--faces", "0.1k"], ["--faces", "100"], ["--faces", "20%"]),
        ("c", ["--faces", "20%"], ["--faces", "20.0 %"], ["--vertices", "20%"]),
    ] {
        assert_eq!(batch(out, size, &[]).code, Some(0));
        assert_eq!(batch(out, same, &["--resume"]).code, Some(0));
        let refused = batch(out, other, &["--resume"]);
        assert!(
            refused.code == Some(1) && error_line(&refused).contains("belongs to a batch with other options"),
            "{}",
            refused.stderr
        );
    }
    let rows = manifest(&folder.path().join("c"));
    assert_eq!(rows["a.obj"]["request"], "--faces 20%");
    for row in rows.values() {
        let [all, kept] = ["faces", "output_faces"].map(|name| row[name].parse::<f64>().unwrap());
        assert!(kept <= 0.2 * all, "{row:?}");
    }
}

#[test]
fn each_result_is_that_of_the_mesh_alone() {
    let folder = folder_of_meshes();
    assert_eq!(run(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.3"]).code, Some(0));
    assert_eq!(run(folder.path(), &["simplify", "in/a.ply", "-o", "alone.ply", "--ratio", "0.3"]).code, Some(0));
    assert_eq!(fs::read(folder.path().join("out/a.ply")).unwrap(), fs::read(folder.path().join("alone.ply")).unwrap());
}

#[test]
fn levels_of_detail_are_files_of_their_own_in_a_row_of_their_mesh() {
    let folder = folder_of_meshes();
    let arguments = ["simplify", "in", "-o", "out", "--lods", "50%,20%"];
    succeed(folder.path(), &arguments);
    let rows = manifest(&folder.path().join("out"));
    let n_files = rows.values().map(|row| {
        let faces: Vec<usize> = row["output_faces"].split(';').map(|n| n.parse().unwrap()).collect();
        assert!(faces.len() == 2 && faces[1] < faces[0], "{row:?}");
        assert_eq!(row["mean_percent"].split(';').count(), 2);
        for (level, n_faces) in faces.iter().enumerate() {
            let path = folder.path().join("out").join(row["output"].replace("{level}", &level.to_string()));
            assert_eq!(read_welded(&path).faces().len(), *n_faces);
            std::fs::remove_file(path).unwrap();
        }
        faces.len()
    });
    assert_eq!(n_files.sum::<usize>(), 2 * rows.len());
    // A level is missing, so the mesh is not done.
    succeed(folder.path(), &[&arguments[..], &["--resume"]].concat());
    assert!(rows.values().all(|row| folder.path().join("out").join(row["output"].replace("{level}", "1")).is_file()));
}

#[test]
fn a_mesh_with_fewer_sizes_than_levels_is_done() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("in")).unwrap();
    std::fs::copy(test_mesh_path("spot.ply"), folder.path().join("in/a.ply")).unwrap();
    let arguments = ["simplify", "in", "-o", "out", "--lods", "50%,0.1%,0.05%", "--no-check"];
    succeed(folder.path(), &arguments);
    let output = |level: usize| folder.path().join(format!("out/a-lod{level}.ply"));
    assert_eq!([0, 1, 2].map(|level| output(level).exists()), [true, true, false]);
    let written = || std::fs::metadata(output(1)).unwrap().modified().unwrap();
    let before = written();
    let resumed = run(folder.path(), &[&arguments[..], &["--resume"]].concat());
    assert_eq!((resumed.code, written()), (Some(0), before), "{}", resumed.stderr);
}

#[test]
fn each_mesh_gets_its_report_and_its_picture() {
    let folder = folder_of_meshes();
    let told = ["--report", "told", "--picture", "drawn"];
    let arguments = [&["simplify", "in", "-o", "out", "--ratio", "0.2"], &told[..]].concat();
    succeed(folder.path(), &arguments);
    let rows = manifest(&folder.path().join("out"));
    assert!(rows.len() == 4 && folder.path().join("told/deep/er/b.stl.json").is_file());
    for (name, row) in &rows {
        let report = fs::read(folder.path().join(format!("told/{name}.json"))).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        assert_eq!(report["output"]["faces"].to_string(), row["output_faces"]);
        assert!(fs::read(folder.path().join(format!("drawn/{name}.png"))).unwrap().starts_with(b"\x89PNG"));
    }
    // A mesh is done when all requested files exist.
    fs::remove_file(folder.path().join("drawn/c.off.png")).unwrap();
    succeed(folder.path(), &[&arguments[..], &["--resume"]].concat());
    assert!(folder.path().join("drawn/c.off.png").is_file());
    let line = refuse(folder.path(), &["simplify", "in", "-o", "other", "--ratio", "0.2", "--report", "told"], 1);
    assert!(line.contains("exists already"), "{line}");
}

#[test]
fn meshes_that_would_share_a_name_keep_their_endings() {
    let folder = folder_of_meshes();
    succeed(folder.path(), &["simplify", "in", "-o", "out", "--vertices", "60", "--format", "ply"]);
    let out = folder.path().join("out");
    assert_eq!(files(&out), ["a.obj.ply", "a.ply.ply", "c.ply", "deep", "manifest.csv"]);
    assert_eq!(info(&out, "a.obj.ply")["genus"], 0);
    assert_eq!(info(&out, "a.ply.ply")["genus"], 1);
}

#[test]
fn a_failing_mesh_is_a_row_and_not_the_end() {
    let folder = folder_of_meshes();
    let bad: [(&str, &[u8]); 5] = [
        ("empty.ply", b""),
        ("cut.ply", b"ply\nformat binary_little_endian 1.0\nelement vertex 9\nproperty float x\n"),
        ("nan.obj", b"v nan nan nan\nv nan 0 0\nv 0 nan 0\nf 1 2 3\n"),
        ("nowhere.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 7 8 9\n"),
        ("announced.stl", b"solid\0\0"),
    ];
    for (name, bytes) in bad {
        fs::write(folder.path().join("in").join(name), bytes).unwrap();
    }
    let run = run(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.2"]);
    assert_eq!(run.code, Some(1));
    let out = folder.path().join("out");
    for (name, _) in bad {
        assert!(outcome(&out, name).starts_with("failed: "), "{}", outcome(&out, name));
        assert!(run.stderr.contains(name), "{}", run.stderr);
        assert!(!out.join(name).exists());
    }
    for name in ["a.obj", "a.ply", "c.off", "deep/er/b.stl"] {
        assert_eq!(outcome(&out, name), "reached");
    }
    assert!(run.stderr.contains("5 meshes failed"), "{}", run.stderr);
}

#[test]
fn a_mesh_that_stops_short_is_no_failure() {
    let folder = folder();
    write_mesh(&folder.path().join("in/chain.ply"), &shapes::chain_of_tori(5), Format::Ply);
    succeed(folder.path(), &["simplify", "in", "-o", "out", "--vertices", "4"]);
    let outcome = outcome(&folder.path().join("out"), "chain.ply");
    assert!(outcome != "reached" && !outcome.starts_with("failed"), "{outcome}");
}

#[test]
fn killed_and_resumed_it_has_the_same_files_and_rows() {
    let folder = folder();
    for i in 0..12 {
        let mesh = shapes::wavy_sphere(4, 2.0 + f64::from(i));
        write_mesh(&folder.path().join(format!("in/{i}.ply")), &mesh, Format::Ply);
    }
    assert_eq!(run(folder.path(), &["simplify", "in", "-o", "whole", "--ratio", "0.1"]).code, Some(0));
    let n_results = || {
        let there = |i: &u32| folder.path().join(format!("out/{i}.ply")).exists();
        (0..12).filter(there).count()
    };
    let mut n_killed = 0;
    for (n_done, milliseconds) in [(0, 3), (1, 0), (4, 7), (7, 11)] {
        let child =
            program(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.1", "--resume"]).spawn().unwrap();
        n_killed += usize::from(kill_after(child, milliseconds, || n_results() >= n_done));
    }
    assert!(n_killed >= 2, "killed only {n_killed} times");
    succeed(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.1", "--resume"]);
    let [whole, out] = ["whole", "out"].map(|name| folder.path().join(name));
    let without_time = |folder: &Path| {
        let mut rows = manifest(folder);
        rows.values_mut().for_each(|row| drop(row.remove("seconds")));
        rows
    };
    assert_eq!(without_time(&whole), without_time(&out));
    for i in 0..12 {
        let name = format!("{i}.ply");
        assert_eq!(fs::read(whole.join(&name)).unwrap(), fs::read(out.join(&name)).unwrap(), "{name}");
    }
}

#[test]
fn finished_meshes_are_not_repeated() {
    let folder = folder_of_meshes();
    fs::write(folder.path().join("in/bad.ply"), "ply").unwrap();
    let arguments = ["simplify", "in", "-o", "out", "--ratio", "0.2", "--resume"];
    assert_eq!(run(folder.path(), &arguments).code, Some(1));
    let out = folder.path().join("out");
    // Existing results stay unchanged; deleted and failed ones are made.
    fs::write(out.join("a.obj"), "mine").unwrap();
    fs::remove_file(out.join("c.off")).unwrap();
    write_mesh(&folder.path().join("in/bad.ply"), &shapes::icosphere(2), Format::Ply);
    succeed(folder.path(), &arguments);
    assert_eq!(fs::read(out.join("a.obj")).unwrap(), b"mine");
    assert!(out.join("c.off").exists());
    assert_eq!(outcome(&out, "bad.ply"), "reached");
}

#[test]
fn a_resumed_batch_is_the_same_batch() {
    let folder = folder_of_meshes();
    assert_eq!(run(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.2"]).code, Some(0));
    let line = refuse(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.2"], 1);
    assert!(line.contains("--resume"), "{line}");
    let line = refuse(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.3", "--resume"], 1);
    assert!(line.contains("--ratio 0.2"), "{line}");
    assert_eq!(run(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.3", "--force"]).code, Some(0));
    // A file that the batch did not make stays.
    write_mesh(&folder.path().join("in/new.ply"), &shapes::icosphere(2), Format::Ply);
    fs::write(folder.path().join("out/new.ply"), "mine").unwrap();
    let resumed = run(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.3", "--resume"]);
    assert_eq!(resumed.code, Some(1));
    assert_eq!(fs::read(folder.path().join("out/new.ply")).unwrap(), b"mine");
}

#[test]
fn lists_patterns_and_names() {
    let folder = folder_of_meshes();
    fs::create_dir(folder.path().join("work")).unwrap();
    let work = folder.path().join("work");
    let list = "../in/a.ply\n\n../in/deep/er/b.stl\n../in/gone.ply\n";
    let listed = run_with_input(&work, &["simplify", "--list", "-", "-o", "listed", "--ratio", "0.5"], list.as_bytes());
    assert_eq!(listed.code, Some(1), "{}", listed.stderr);
    assert_eq!(files(&work), ["listed"]);
    assert_eq!(files(&work.join("listed")), ["a.ply", "deep", "manifest.csv"]);
    assert!(outcome(&work.join("listed"), "gone.ply").starts_with("failed"));
    succeed(folder.path(), &["simplify", "in/**/*.[ps]*", "-o", "matched", "--ratio", "0.5"]);
    assert_eq!(files(&folder.path().join("matched")), ["a.ply", "deep", "manifest.csv"]);
    succeed(folder.path(), &["simplify", "in/a.ply", "in/c.off", "-o", "named", "--ratio", "0.5"]);
    assert_eq!(files(&folder.path().join("named")), ["a.ply", "c.off", "manifest.csv"]);
    let nothing = run(folder.path(), &["simplify", "in/*.glb", "-o", "none", "--ratio", "0.5"]);
    assert_eq!((nothing.code, folder.path().join("none").exists()), (Some(1), false));
}

#[test]
fn results_within_the_searched_folder_are_no_meshes_of_it() {
    let folder = folder_of_meshes();
    let arguments = ["simplify", "in", "-o", "in/out", "--ratio", "0.5", "--resume"];
    assert_eq!(run(folder.path(), &arguments).code, Some(0));
    assert_eq!(run(folder.path(), &arguments).code, Some(0));
    assert_eq!(manifest(&folder.path().join("in/out")).len(), 4);
}

#[cfg(unix)]
#[test]
fn nothing_is_written_outside_the_folder() {
    let folder = folder_of_meshes();
    for name in ["out", "elsewhere"] {
        fs::create_dir(folder.path().join(name)).unwrap();
    }
    std::os::unix::fs::symlink("../elsewhere", folder.path().join("out/deep")).unwrap();
    std::os::unix::fs::symlink("../elsewhere/a.ply", folder.path().join("out/a.ply")).unwrap();
    let run = run(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.5", "--force"]);
    assert_eq!(run.code, Some(1));
    assert_eq!(files(&folder.path().join("elsewhere")), Vec::<String>::new());
    for name in ["a.ply", "deep/er/b.stl"] {
        assert!(outcome(&folder.path().join("out"), name).starts_with("failed"));
    }
    assert_eq!(outcome(&folder.path().join("out"), "c.off"), "reached");
}

#[cfg(unix)]
#[test]
fn a_manifest_that_is_a_link_is_refused() {
    let folder = folder_of_meshes();
    fs::create_dir(folder.path().join("out")).unwrap();
    fs::write(folder.path().join("mine.csv"), "mine").unwrap();
    for to in ["../mine.csv", "../new.csv"] {
        let link = folder.path().join("out/manifest.csv");
        std::os::unix::fs::symlink(to, &link).unwrap();
        for more in ["--force", "--resume"] {
            let line = refuse(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.5", more], 1);
            assert!(line.contains("is a link"), "{line}");
        }
        fs::remove_file(link).unwrap();
    }
    assert_eq!(files(folder.path()), ["in", "mine.csv", "out"]);
    assert_eq!(fs::read(folder.path().join("mine.csv")).unwrap(), b"mine");
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_batch_that_goes_on() {
    let folder = folder();
    for i in 0..40 {
        write_mesh(&folder.path().join(format!("in/{i}.ply")), &shapes::wavy_sphere(4, 3.0), Format::Ply);
    }
    let arguments = ["simplify", "in", "-o", "out", "--ratio", "0.1", "--resume"];
    let child = program(folder.path(), &arguments).spawn().unwrap();
    let out = folder.path().join("out");
    let stopped = interrupt_once(child, || out.exists() && files(&out).iter().any(|name| name.ends_with(".ply")));
    assert_eq!(stopped.code, Some(130), "{}", stopped.stderr);
    assert!(error_line(&stopped).contains("--resume"));
    assert!(files(&out).iter().all(|name| !name.starts_with('.')), "{:?}", files(&out));
    assert!(files(&out).len() < 41);
    assert_eq!(run(folder.path(), &arguments).code, Some(0));
    assert_eq!(files(&out).len(), 41);
}

#[test]
fn a_texture_never_takes_the_place_of_another_mesh() {
    let folder = folder();
    let input_path = |name: &str| folder.path().join("in").join(name);
    write_mesh(&input_path("b.ply"), &shapes::icosphere(3), Format::Ply);
    write_mesh(&input_path("c.obj"), &shapes::icosphere(2), Format::Obj);
    for (name, texture) in [("a", "b.ply"), ("d", "c.obj"), ("e", "manifest.csv"), ("f", "t.png")] {
        fs::write(input_path(&format!("{name}.mtl")), format!("newmtl m\nmap_Kd {texture}\n")).unwrap();
        fs::write(input_path(&format!("{name}.obj")), format!("mtllib {name}.mtl\nusemtl m\n{OCTAHEDRON}")).unwrap();
    }
    fs::write(input_path("manifest.csv"), "evil").unwrap();
    fs::write(input_path("t.png"), "texture").unwrap();
    let out = folder.path().join("out");
    for more in [&[][..], &["--force"], &["--force", "--threads", "1"]] {
        let run = run(folder.path(), &[&["simplify", "in", "-o", "out", "--ratio", "1"], more].concat());
        assert_eq!(run.code, Some(1));
        for (name, texture) in [("a.obj", "b.ply"), ("d.obj", "c.obj"), ("e.obj", "manifest.csv")] {
            let outcome = outcome(&out, name);
            assert!(outcome.starts_with("failed: ") && outcome.contains(texture), "{outcome}");
        }
        for name in ["b.ply", "c.obj", "f.obj"] {
            assert_eq!(outcome(&out, name), "reached");
        }
        assert_eq!(info(&out, "b.ply")["vertices"], 642);
        assert_eq!(info(&out, "c.obj")["vertices"], 162);
        assert_eq!(files(&out), ["b.ply", "c.obj", "f.mtl", "f.obj", "manifest.csv", "t.png"]);
    }
}

#[test]
fn two_meshes_never_share_a_file_that_differs() {
    let folder = folder();
    let input_path = |name: &str| folder.path().join("in").join(name);
    for (place, texture) in [("x", "one"), ("y", "two")] {
        fs::create_dir_all(input_path(place)).unwrap();
        fs::write(input_path(place).join("t.png"), texture).unwrap();
        fs::write(input_path(&format!("{place}.mtl")), format!("newmtl m\nmap_Kd {place}/t.png\n")).unwrap();
        fs::create_dir_all(input_path("meshes")).unwrap();
        let mesh = format!("mtllib ../{place}.mtl\nusemtl m\n{OCTAHEDRON}");
        fs::write(input_path(&format!("meshes/{place}.obj")), mesh).unwrap();
    }
    // Both textures come from outside and would become `t.png` next to the result.
    let arguments = ["simplify", "in/meshes", "-o", "out", "--ratio", "1", "--allow-outside", "--force"];
    let run = run(folder.path(), &arguments);
    let out = folder.path().join("out");
    let mut outcomes = ["x.obj", "y.obj"].map(|name| outcome(&out, name));
    outcomes.sort();
    assert_eq!(run.code, Some(1), "{outcomes:?}");
    assert!(outcomes[0].contains("t.png") && outcomes[0].contains("different texture"), "{outcomes:?}");
    assert_eq!(outcomes[1], "reached");
    let kept = if outcome(&out, "x.obj") == "reached" { "one" } else { "two" };
    assert_eq!(fs::read_to_string(out.join("t.png")).unwrap(), kept);
}

#[cfg(unix)]
#[test]
fn two_batches_in_one_folder_exclude_each_other() {
    let folder = folder_of_meshes();
    let made = std::process::Command::new("mkfifo").arg(folder.path().join("weights")).status().unwrap();
    assert!(made.success());
    // The pipe of the weights stays empty, so the first batch waits and keeps its folder locked.
    let arguments = ["simplify", "in", "-o", "out", "--ratio", "0.2"];
    let mut first = program(folder.path(), &[&arguments[..], &["--weights", "weights"]].concat()).spawn().unwrap();
    wait_until(|| folder.path().join("out/manifest.csv").exists());
    for more in [&[][..], &["--resume"], &["--force"]] {
        let line = refuse(folder.path(), &[&arguments[..], more].concat(), 1);
        assert!(line.contains("another batch writes into this folder"), "{line}");
    }
    assert_eq!(run(folder.path(), &["simplify", "in", "-o", "elsewhere", "--ratio", "0.2"]).code, Some(0));
    assert_eq!(files(&folder.path().join("out")), ["manifest.csv"]);
    // After it is killed, the lock is free.
    first.kill().unwrap();
    first.wait().unwrap();
    assert_eq!(run(folder.path(), &[&arguments[..], &["--force"]].concat()).code, Some(0));
}

#[cfg(target_os = "linux")]
#[test]
fn names_that_are_not_utf_8_are_refused() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = folder_of_meshes();
    let path = folder.path().join("in").join(OsStr::from_bytes(b"a\xfe.ply"));
    write_mesh(&path, &shapes::icosphere(2), Format::Ply);
    let line = refuse(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.2"], 1);
    assert!(line.contains("not UTF-8: rename it"), "{line}");
    assert!(!folder.path().join("out").exists());
}

#[cfg(unix)]
#[test]
fn names_with_backslashes_and_marks_are_rows_of_their_own() {
    let folder = folder();
    let names = ["a\\xff.ply", "a\u{fffd}.ply", "a;b,\"c.ply"];
    for (level, name) in names.iter().enumerate() {
        write_mesh(&folder.path().join("in").join(name), &shapes::wavy_sphere(2, 1.0 + level as f64), Format::Ply);
    }
    let arguments = ["simplify", "in", "-o", "out", "--vertices", "40", "--resume"];
    assert_eq!(run(folder.path(), &arguments).code, Some(0));
    let out = folder.path().join("out");
    assert_eq!(manifest(&out).keys().collect::<Vec<_>>(), ["a;b,\"c.ply", "a\\xff.ply", "a\u{fffd}.ply"]);
    // Each is recognised by its name: a deleted one is made again, the others stay.
    let result = fs::read(out.join(names[0])).unwrap();
    fs::remove_file(out.join(names[0])).unwrap();
    names[1..].iter().for_each(|name| fs::write(out.join(name), "mine").unwrap());
    assert_eq!(run(folder.path(), &arguments).code, Some(0));
    assert_eq!(fs::read(out.join(names[0])).unwrap(), result);
    assert!(names[1..].iter().all(|name| fs::read(out.join(name)).unwrap() == b"mine"));
}

#[test]
fn results_of_an_interrupted_run_are_found_again_and_others_stay() {
    let folder = folder_of_meshes();
    let arguments = ["simplify", "in", "-o", "out", "--ratio", "0.2", "--resume"];
    assert_eq!(run(folder.path(), &arguments).code, Some(0));
    let out = folder.path().join("out");
    let path = out.join("manifest.csv");
    let without_time = || {
        let mut rows = manifest(&out);
        rows.values_mut().for_each(|row| drop(row.remove("seconds")));
        rows
    };
    let (whole, text) = (without_time(), fs::read_to_string(&path).unwrap());
    // Rows of a run that found results of a killed run.
    let failed = text.replace(",reached,", ",\"failed: it exists already: continue with --resume\",");
    assert_ne!(failed, text);
    for left in [Some(failed), None] {
        let written = left.map(|rows| fs::write(&path, rows));
        if written.is_none() {
            fs::remove_file(&path).unwrap();
        }
        succeed(folder.path(), &arguments);
        assert_eq!(without_time(), whole);
    }
    // A file that is no result of this batch stays after any number of interruptions.
    fs::write(out.join("c.off"), "mine").unwrap();
    fs::remove_file(&path).unwrap();
    for _ in 0..2 {
        let refused = run(folder.path(), &arguments);
        assert_eq!(refused.code, Some(1));
        assert!(outcome(&out, "c.off").contains("exists already"), "{}", outcome(&out, "c.off"));
        assert_eq!(fs::read(out.join("c.off")).unwrap(), b"mine");
        assert_eq!(outcome(&out, "a.ply"), "reached");
    }
}

#[test]
fn options_for_single_meshes_are_usage_errors() {
    let folder = folder_of_meshes();
    for more in [
        &["--report", "-"][..],
        &["--picture", "-"],
        &["--map", "r.json"],
        &["--format", "fbx"],
        &["--memory", "0"],
        &["--threads", "0"],
    ] {
        let refused = run(folder.path(), &[&["simplify", "in", "-o", "out", "--ratio", "0.2"], more].concat());
        assert_eq!(refused.code, Some(2), "{more:?} {}", refused.stderr);
    }
    assert_eq!(run(folder.path(), &["simplify", "in", "-o", "-", "--ratio", "0.2"]).code, Some(2));
    let single = run(folder.path(), &["simplify", "in/a.ply", "-o", "a.ply", "--ratio", "0.2", "--resume"]);
    assert_eq!(single.code, Some(2));
    assert!(!folder.path().join("out").exists());
}

#[test]
fn a_value_apart_from_its_option_and_a_mesh_for_a_folder_are_refused() {
    let folder = folder_of_meshes();
    for more in
        [&["--ratio", "0.5", "--fill-holes", "30"][..], &["--error", "0.2", "%"], &["--ratio", "0.5", "--prune", "1%"]]
    {
        let words = [&["simplify", "in/a.ply", "-o", "out.ply"], more].concat();
        let line = refuse(folder.path(), &words, 2);
        assert!(line.contains("write --prune=1% instead of --prune 1%"), "{line}");
    }
    let line = refuse(folder.path(), &["simplify", "in", "-o", "out.ply", "--ratio", "0.5"], 2);
    assert!(line.contains("several meshes need a folder"), "{line}");
    assert!(!folder.path().join("out.ply").exists());
}

#[test]
fn little_memory_makes_it_slower_and_nothing_else() {
    let folder = folder_of_meshes();
    assert_eq!(run(folder.path(), &["simplify", "in", "-o", "wide", "--ratio", "0.2"]).code, Some(0));
    let arguments = ["simplify", "in", "-o", "narrow", "--ratio", "0.2", "--memory", "0.001", "--threads", "3"];
    assert_eq!(run(folder.path(), &arguments).code, Some(0));
    for name in ["a.obj", "a.ply", "c.off", "deep/er/b.stl"] {
        let [wide, narrow] = ["wide", "narrow"].map(|out| fs::read(folder.path().join(out).join(name)).unwrap());
        assert_eq!(wide, narrow, "{name}");
    }
}
