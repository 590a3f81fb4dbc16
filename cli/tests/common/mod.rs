//! Helpers that run the program and inspect its output.
#![allow(dead_code, reason = "not every set of features uses all")]

pub mod avatar;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use neural_mesh::io;
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};
use serde_json::Value;
use tempfile::TempDir;

pub struct Run {
    pub code: Option<i32>,
    pub stdout: Vec<u8>,
    pub stderr: String,
}

pub fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

pub fn folder_with_octahedron() -> TempDir {
    let folder = folder();
    std::fs::write(folder.path().join("a.obj"), OCTAHEDRON).unwrap();
    folder
}

pub fn read_welded(path: &Path) -> TriMesh {
    let raw = io::read(&std::fs::read(path).unwrap(), None).unwrap();
    clean(raw, &CleanOptions::default()).unwrap().mesh
}

pub fn test_mesh_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/meshes").join(name)
}

pub fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(crate::PROGRAM);
    command.current_dir(folder).args(arguments);
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

pub fn run(folder: &Path, arguments: &[&str]) -> Run {
    finish(program(folder, arguments).spawn().unwrap())
}

/// Runs the program, which must succeed.
#[track_caller]
pub fn succeed(folder: &Path, arguments: &[&str]) -> Run {
    let run = run(folder, arguments);
    assert_eq!(run.code, Some(0), "{arguments:?}: {}", run.stderr);
    run
}

/// Runs the program, which must end with a code and one line of error; returns the line.
#[track_caller]
pub fn refuse(folder: &Path, arguments: &[&str], code: i32) -> String {
    let refused = run(folder, arguments);
    assert_eq!(refused.code, Some(code), "{arguments:?}: {}", refused.stderr);
    error_line(&refused)
}

pub fn run_with_input(folder: &Path, arguments: &[&str], input: &[u8]) -> Run {
    let mut child = program(folder, arguments).stdin(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let input = input.to_vec();
    // The program may stop before it reads everything.
    let writer = std::thread::spawn(move || drop(stdin.write_all(&input)));
    let run = finish(child);
    writer.join().unwrap();
    run
}

pub fn finish(child: Child) -> Run {
    let output = child.wait_with_output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert!(!stderr.contains("panicked"), "{stderr}");
    Run { code: output.status.code(), stdout: output.stdout, stderr }
}

#[track_caller]
pub fn wait_until(mut holds: impl FnMut() -> bool) {
    let began = Instant::now();
    while !holds() {
        assert!(began.elapsed() < Duration::from_secs(600), "what was waited for never came");
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[track_caller]
pub fn kill_after(mut child: Child, milliseconds: u64, holds: impl Fn() -> bool) -> bool {
    wait_until(|| holds() || child.try_wait().unwrap().is_some());
    std::thread::sleep(Duration::from_millis(milliseconds));
    child.kill().unwrap();
    !child.wait().unwrap().success()
}

#[cfg(unix)]
#[track_caller]
pub fn interrupt_once(child: Child, holds: impl Fn() -> bool) -> Run {
    signal_once(child, nix::sys::signal::Signal::SIGINT, holds)
}

#[cfg(unix)]
#[track_caller]
pub fn signal_once(mut child: Child, signal: nix::sys::signal::Signal, holds: impl Fn() -> bool) -> Run {
    wait_until(|| {
        assert!(child.try_wait().unwrap().is_none(), "it ended before the signal");
        holds()
    });
    nix::sys::signal::kill(nix::unistd::Pid::from_raw(child.id() as i32), signal).unwrap();
    finish(child)
}

pub fn n_lines(path: &Path) -> usize {
    std::fs::read_to_string(path).map_or(0, |text| text.lines().count())
}

pub fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

pub fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

pub fn info(folder: &Path, mesh: &str) -> Value {
    let run = run(folder, &["info", mesh, "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    serde_json::from_slice(&run.stdout).unwrap()
}

pub fn error_line(run: &Run) -> String {
    let lines: Vec<&str> = run.stderr.lines().collect();
    assert_eq!(lines.len(), 1, "{}", run.stderr);
    assert!(lines[0].starts_with("neural-mesh: ") && lines[0].matches(": ").count() >= 2, "{}", lines[0]);
    lines[0].to_string()
}

pub const OCTAHEDRON: &str = "v 1 0 0\nv -1 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\nv 0 0 -1\n\
f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";

/// Writes a sphere and a far smaller one at its surface as `two.obj`.
pub fn write_sphere_and_speck(folder: &Path) {
    let large = sphere(1, 16, [0.0; 3], 1.0);
    let speck = sphere(1 + large.matches("v ").count(), 4, [1.0, 0.0, 0.0], 0.01);
    std::fs::write(folder.join("two.obj"), large + &speck).unwrap();
}

pub fn sphere(first: usize, rings: usize, centre: [f64; 3], radius: f64) -> String {
    use std::f64::consts::PI;
    let around = 2 * rings;
    let point = |ring: usize, step: usize| {
        let (polar, turn) = (PI * ring as f64 / rings as f64, PI * step as f64 / rings as f64 + 0.1);
        let p = [polar.sin() * turn.cos(), polar.cos(), polar.sin() * turn.sin()];
        let [x, y, z] = [0, 1, 2].map(|axis| centre[axis] + radius * p[axis]);
        format!("v {x:?} {y:?} {z:?}\n")
    };
    let mut text = point(0, 0) + &point(rings, 0);
    text.extend((1..rings).flat_map(|ring| (0..around).map(move |step| point(ring, step))));
    let vertex = |ring: usize, step: usize| first + 2 + (ring - 1) * around + step % around;
    for step in 0..around {
        text += &format!("f {first} {} {}\n", vertex(1, step + 1), vertex(1, step));
        text += &format!("f {} {} {}\n", first + 1, vertex(rings - 1, step), vertex(rings - 1, step + 1));
        for ring in 1..rings - 1 {
            let [a, b, c, d] =
                [vertex(ring, step), vertex(ring, step + 1), vertex(ring + 1, step + 1), vertex(ring + 1, step)];
            text += &format!("f {a} {b} {c} {d}\n");
        }
    }
    text
}

/// Writes `plate.obj` after lines of its own, with x shifted by some decimals: a bent square of two materials, left and right.
pub fn write_plate(folder: &Path, first: &str, decimals: &str) {
    let n = 20;
    let mut text = String::from(first);
    let all = || (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j)));
    all().for_each(|(i, j)| text += &format!("v {i}{decimals} {j} {}\n", 0.3 * f64::from(i).sin()));
    all().for_each(|(i, j)| text += &format!("vt {} {}\n", f64::from(i) / 20.0, f64::from(j) / 20.0));
    for (name, rows) in [("left", 0..n / 2), ("right", n / 2..n)] {
        text += &format!("usemtl {name}\n");
        for (i, j) in rows.flat_map(|i| (0..n).map(move |j| (i, j))) {
            let vertex = |i, j| 1 + j * (n + 1) + i;
            let [a, b, c, d] =
                [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)].map(|v| format!("{v}/{v}"));
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    std::fs::write(folder.join("plate.obj"), text).unwrap();
}

/// Returns an OBJ of n x n squares with a chart each, in materials by turns or none.
pub fn charts(n: usize, materials: &[&str]) -> String {
    let mut obj: String =
        (0..(n + 1) * (n + 1)).map(|i| format!("v {} {} {}\n", i % (n + 1), i / (n + 1), (i * i) % 3)).collect();
    for square in 0..n * n {
        let (x, y) = (square % n, square / n);
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
        corners.iter().for_each(|[i, j]| obj += &format!("vt {} {}\n", 2 * x + i, 2 * y + j));
        let [a, b, c, d] = corners.map(|[i, j]| (y + j) * (n + 1) + x + i + 1);
        let [ta, tb, tc, td] = [1, 2, 3, 4].map(|k| 4 * square + k);
        obj.extend(materials.get((x + y) % 2).map(|name| format!("usemtl {name}\n")));
        obj += &format!("f {a}/{ta} {b}/{tb} {c}/{tc}\nf {a}/{ta} {c}/{tc} {d}/{td}\n");
    }
    obj
}
