//! Insufficient memory and endless files.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
#[cfg(target_os = "linux")]
use std::process::Stdio;

use crate::common::*;
use neural_mesh::io::{Format, write};
use neural_mesh::mesh::{Frame, TriMesh, shapes};
use neural_mesh::metrics::quick_distance;

/// Memory in GiB that suffices for a few hundred vertices but not for forty thousand.
const LITTLE: &str = "0.008";

fn write_mesh(path: &Path, mesh: &TriMesh) {
    fs::write(path, write(mesh, &Frame::default(), Format::Ply).unwrap()).unwrap();
}

fn folder_of_meshes() -> tempfile::TempDir {
    let folder = folder();
    let input = folder.path().join("in");
    fs::create_dir(&input).unwrap();
    write_mesh(&input.join("a.ply"), &shapes::icosphere(2));
    write_mesh(&input.join("big.ply"), &shapes::icosphere(6));
    write_mesh(&input.join("c.ply"), &shapes::bolt(8));
    folder
}

fn outcomes(folder: &Path) -> BTreeMap<String, String> {
    let rows = csv::Reader::from_path(folder.join("out/manifest.csv")).unwrap().into_deserialize();
    let row = |row: Result<BTreeMap<String, String>, csv::Error>| {
        row.map(|row| (row["name"].clone(), row["outcome"].clone()))
    };
    rows.map(|found| row(found).unwrap()).collect()
}

#[test]
fn a_mesh_that_takes_more_memory_than_allowed_ends_in_one_line() {
    let folder = folder_of_meshes();
    let arguments = ["simplify", "in/big.ply", "-o", "out.ply", "--ratio", "0.1", "--memory"];
    let line = refuse(folder.path(), &[&arguments[..], &[LITTLE]].concat(), 1);
    assert!(line.contains("in/big.ply: this target needs about 0.1 GiB of memory"), "{line}");
    assert_eq!(files(folder.path()), ["in"], "something was left");
    succeed(folder.path(), &[&arguments[..], &["1"]].concat());
}

#[test]
fn a_file_longer_than_the_memory_is_refused_in_one_line() {
    let folder = folder();
    let sparse = fs::File::create(folder.path().join("long.ply")).unwrap();
    sparse.set_len(1 << 40).unwrap();
    for command in [&["info", "long.ply"][..], &["simplify", "long.ply", "-o", "a.ply", "--ratio", "0.5"]] {
        let line = refuse(folder.path(), command, 1);
        assert!(line.contains("the file needs more memory than is available"), "{line}");
    }
}

#[cfg(unix)]
#[test]
fn endless_files_are_refused_in_one_line() {
    let folder = folder();
    for command in [&["info", "/dev/zero"][..], &["simplify", "/dev/zero", "-o", "a.ply", "--ratio", "0.5"]] {
        let line = refuse(folder.path(), command, 1);
        assert!(line.contains("is a device and has no end"), "{line}");
    }
    let zeros = fs::File::open("/dev/zero").unwrap();
    let arguments = ["simplify", "-", "-o", "a.ply", "--ratio", "0.5", "--memory", LITTLE];
    let refused = finish(program(folder.path(), &arguments).stdin(zeros).spawn().unwrap());
    assert_eq!(refused.code, Some(1), "{}", refused.stderr);
    assert!(error_line(&refused).contains("the file needs more memory than is available"), "{}", refused.stderr);
}

#[test]
fn a_mesh_that_exhausted_the_memory_is_a_failed_row_on_resume() {
    let folder = folder_of_meshes();
    // With one thread, the mesh in progress is alone when memory runs out.
    let arguments = ["simplify", "in", "-o", "out", "--ratio", "0.2", "--memory", LITTLE, "--threads", "1"];
    let line = refuse(folder.path(), &arguments, 1);
    assert!(line.starts_with("neural-mesh: out of memory: "), "{line}");
    for _ in 0..2 {
        let resumed = run(folder.path(), &[&arguments[..], &["--resume"]].concat());
        assert_eq!(resumed.code, Some(1), "{}", resumed.stderr);
        let outcomes = outcomes(folder.path());
        assert!(outcomes["big.ply"].starts_with("failed: ran out of memory"), "{outcomes:?}");
        assert_eq!((outcomes["a.ply"].as_str(), outcomes["c.ply"].as_str()), ("reached", "reached"));
    }
    // With more memory it is tried again.
    succeed(folder.path(), &["simplify", "in", "-o", "out", "--ratio", "0.2", "--memory", "1", "--resume"]);
    assert_eq!(outcomes(folder.path())["big.ply"], "reached");
}

fn large(folder: &Path) -> &'static str {
    write_mesh(&folder.join("large.ply"), &shapes::icosphere(8));
    "0.25"
}

#[test]
fn a_mesh_larger_than_the_memory_is_simplified_in_blocks() {
    let folder = folder();
    let memory = large(folder.path());
    let words = ["simplify", "large.ply", "-o", "out.ply", "--faces", "5000", "--memory", memory, "--report", "r.json"];
    let done = succeed(folder.path(), &words);
    let report = json(&folder.path().join("r.json"));
    assert_eq!((&report["input"]["faces"], &report["output"]["faces"]), (&1_310_720.into(), &5000.into()));
    assert_eq!(report["output"]["closed"], true);
    let mesh = |name: &str| read_welded(&folder.path().join(name));
    let whole = quick_distance(&mesh("large.ply"), &mesh("out.ply"), 8000, 0).unwrap();
    let percent = report["distance"]["mean_percent"].as_f64().unwrap();
    assert!((percent / (100.0 * whole.mean / whole.diagonal) - 1.0).abs() < 0.02, "{percent} {whole:?}");
    let said = String::from_utf8(done.stdout).unwrap();
    assert!(said.contains("distance  mean"), "{said}");
    assert!(report["notes"][0].as_str().unwrap().starts_with("simplified in 3 blocks"), "{}", report["notes"]);
    assert_eq!(files(folder.path()), ["large.ply", "out.ply", "r.json"]);
}

#[test]
fn info_describes_meshes_larger_than_the_memory() {
    let folder = folder();
    let memory = large(folder.path());
    let said = |more: &[&str]| {
        let done = succeed(folder.path(), &[&["info", "large.ply"][..], more].concat());
        String::from_utf8(done.stdout).unwrap()
    };
    assert_eq!(said(&["--memory", memory]), said(&[]));
    assert_eq!(said(&["--memory", memory, "--json"]), said(&["--json"]));
    let refused = run(folder.path(), &["info", "large.ply", "--memory", "0.01"]);
    assert!(error_line(&refused).contains("GiB of memory"), "{}", refused.stderr);
}

#[cfg(target_os = "linux")]
#[test]
fn temporary_files_go_however_the_run_ends() {
    use nix::sys::signal::Signal::{SIGINT, SIGKILL, SIGTERM};
    let folder = folder();
    let memory = large(folder.path());
    let words = ["simplify", "large.ply", "-o", "out.ply", "--faces", "5000", "--memory", memory, "--threads", "1"];
    for signal in [SIGINT, SIGTERM, SIGKILL] {
        let child = program(folder.path(), &words).spawn().unwrap();
        let open = format!("/proc/{}/fd", child.id());
        let waits_on_disk = || {
            let mut links = fs::read_dir(&open).into_iter().flatten().flatten();
            links
                .any(|link| fs::read_link(link.path()).is_ok_and(|path| path.to_string_lossy().ends_with(" (deleted)")))
        };
        let ended = signal_once(child, signal, waits_on_disk);
        assert_ne!(ended.code, Some(0), "{signal}: {}", ended.stderr);
        assert_eq!(files(folder.path()), ["large.ply"], "{signal}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_in_one_line() {
    let folder = folder();
    let memory = large(folder.path());
    let words = ["simplify", "large.ply", "-o", "out.ply", "--faces", "5000", "--memory", memory];
    // No file may exceed a megabyte.
    let limited = "trap '' XFSZ; ulimit -f 2000; exec \"$0\" \"$@\"";
    let mut full = std::process::Command::new("sh");
    full.args(["-c", limited, env!("CARGO_BIN_EXE_neural-mesh")]).args(words).current_dir(folder.path());
    full.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let ended = finish(full.spawn().unwrap());
    assert_eq!(ended.code, Some(1), "{}", ended.stderr);
    assert!(error_line(&ended).contains("temporary files next to the output failed"), "{}", ended.stderr);
    assert_eq!(files(folder.path()), ["large.ply"]);
}

#[test]
fn options_without_blocks_are_refused_in_one_line() {
    let folder = folder();
    let memory = large(folder.path());
    for (more, why) in [
        (&["--ratio", "0.01", "--map", "m.json"][..], "--map does not work in blocks: allow more with --memory"),
        (&["--error", "1%"], "--error does not work in blocks"),
        (&["--ratio", "0.9"], "this target needs about"),
    ] {
        let words = ["simplify", "large.ply", "-o", "out.ply", "--memory", memory];
        let line = refuse(folder.path(), &[&words[..], more].concat(), 1);
        assert!(line.contains(why), "{line}");
    }
    let mesh = shapes::icosphere(7);
    let text = String::from_utf8(write(&mesh, &Frame::default(), Format::Obj).unwrap()).unwrap();
    fs::write(folder.path().join("textured.obj"), format!("vt 0 0\n{text}")).unwrap();
    let words = ["simplify", "textured.obj", "-o", "out.obj", "--ratio", "0.01", "--memory", "0.08"];
    let refused = run(folder.path(), &words);
    assert!(
        error_line(&refused).contains("would drop its texture coordinates, normals or materials"),
        "{}",
        refused.stderr
    );
    assert_eq!(files(folder.path()), ["large.ply", "textured.obj"]);
}
