//! One run of an external program.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::limited::describe_status;
use neural_mesh::io::read_path;
use neural_mesh::mesh::TriMesh;
use neural_mesh::mesh::cleanup::{CleanOptions, clean};

// OpenMP, rayon, OpenBLAS, MKL, Accelerate, numexpr and Julia read these.
const THREADS: [&str; 7] = [
    "OMP_NUM_THREADS",
    "RAYON_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "VECLIB_MAXIMUM_THREADS",
    "NUMEXPR_NUM_THREADS",
    "JULIA_NUM_THREADS",
];

// A program reports its time in a line with this prefix.
const SECONDS: &str = "seconds: ";

#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct ForeignRun {
    pub words: Vec<String>,
    pub threads: usize,
    pub out: PathBuf,
}

pub(super) fn run_foreign(foreign: &ForeignRun) -> Result<f64, String> {
    let (program, arguments) = foreign.words.split_first().ok_or("the command is empty")?;
    let mut command = Command::new(program);
    command.args(arguments).envs(THREADS.map(|name| (name, foreign.threads.to_string())));
    let out = File::create(&foreign.out).map_err(|error| format!("{}: {error}", foreign.out.display()))?;
    command.stdin(Stdio::null()).stdout(out);
    let began = Instant::now();
    let status = command.status().map_err(|error| format!("{program} cannot be started: {error}"))?;
    let seconds = began.elapsed().as_secs_f64();
    if status.success() { Ok(seconds) } else { Err(describe_status(status)) }
}

pub(super) fn reported_seconds(out: &str) -> Option<f64> {
    let reported = out.lines().rev().find_map(|line| line.trim().strip_prefix(SECONDS));
    reported?.trim().parse().ok().filter(|seconds: &f64| seconds.is_finite() && *seconds >= 0.0)
}

pub(super) fn read_result(path: &Path) -> Result<TriMesh, String> {
    if !path.exists() {
        return Err("left no result".into());
    }
    let raw = read_path(path, None).map_err(|error| format!("the result: {error}"))?;
    let cleaned = clean(raw, &CleanOptions::default()).map_err(|error| format!("the result: {error}"))?;
    let positions = cleaned.mesh.positions().iter().map(|&local| cleaned.frame.to_file(local).map(|x| x as f32));
    TriMesh::new(positions.collect(), cleaned.mesh.faces().to_vec()).map_err(|error| format!("the result: {error}"))
}

#[cfg(unix)]
#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str, folder: &tempfile::TempDir) -> ForeignRun {
        let words = ["sh", "-c", script].map(String::from).to_vec();
        ForeignRun { words, threads: 3, out: folder.path().join("out") }
    }

    #[test]
    fn the_time_is_that_of_the_whole_process_or_the_one_it_tells() {
        let folder = tempfile::tempdir().unwrap();
        let began = Instant::now();
        let seconds = run_foreign(&shell("sleep 0.2; echo 'seconds: 0.125'; echo done", &folder)).unwrap();
        assert!((0.2..=began.elapsed().as_secs_f64()).contains(&seconds), "{seconds}");
        assert_eq!(reported_seconds(&std::fs::read_to_string(folder.path().join("out")).unwrap()), Some(0.125));
        for out in ["", "0.125", "seconds: soon", "seconds: -1", "seconds: inf"] {
            assert_eq!(reported_seconds(out), None, "{out}");
        }
    }
}
