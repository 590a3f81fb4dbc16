//! `compare`: measures of results against their original.

use std::path::PathBuf;

use neural_mesh_cli::embedded::{self, CompareArgs, MAX_SAMPLES};
use pyo3::prelude::*;

use crate::background::run_in_background;
use crate::failure::option_error;
use crate::mesh_arrays::MeshArrays;

/// Compares meshes with the first one, reading missing ones from their paths. Returns JSON, and the page if `html` is
/// set.
///
/// The page is written to `html` if `writes`.
#[pyfunction]
#[pyo3(signature = (paths, meshes, *, samples, seed, weld, html, writes, force, threads))]
#[allow(clippy::too_many_arguments, reason = "they are keywords")]
pub fn compare(
    py: Python,
    mut paths: Vec<PathBuf>,
    meshes: Vec<Option<MeshArrays>>,
    samples: usize,
    seed: u64,
    weld: bool,
    html: Option<PathBuf>,
    writes: bool,
    force: bool,
    threads: Option<usize>,
) -> PyResult<(String, Option<String>)> {
    if !(1..=MAX_SAMPLES).contains(&(samples as u64)) {
        return Err(option_error(format!("samples={samples}: give a whole number from 1 to {MAX_SAMPLES}")));
    }
    let read = |mesh: Option<MeshArrays>| mesh.map(|mesh| mesh.read()).transpose();
    let given = meshes.into_iter().map(read).collect::<PyResult<Vec<_>>>()?;
    let simplified = paths.split_off(1.min(paths.len()));
    let args = CompareArgs {
        original: paths.pop().unwrap_or_default(),
        simplified,
        html,
        json: None,
        samples,
        seed,
        all: false,
        threads: None,
        no_weld: !weld,
        quiet: true,
        force,
    };
    let compared = run_in_background(py, threads, None, move |channel| {
        embedded::compare(&args, given, writes, &|| channel.check_cancelled())
    })?;
    Ok((compared.figures, compared.page))
}
