//! Meshes in progress when an earlier run ran out of memory: a single one fails, several are retried alone.

use std::path::Path;

use super::manifest::Manifest;
use crate::failure::Failure;
use crate::{allocator, files, out_of_memory};

const OUT_OF_MEMORY_FILE: &str = ".neural-mesh-out-of-memory";

const FAILURE: &str =
    "ran out of memory, even alone: raise --memory by more than a quarter, and continue with --resume";

/// Returns the meshes to run alone, and registers this run's meshes, in case memory runs out.
pub fn find_unfinished(folder: &Path, manifest: &mut Manifest, resume: bool) -> Result<Vec<usize>, Failure> {
    let path = folder.join(OUT_OF_MEMORY_FILE);
    let known = if resume && path.is_file() { files::read(&path)? } else { Vec::new() };
    if !resume {
        // The file is missing, or belongs to a batch that this one replaces.
        let _ = std::fs::remove_file(&path);
    }
    let known = String::from_utf8_lossy(&known);
    let known: Vec<UnfinishedMesh> = known.lines().filter_map(UnfinishedMesh::parse).collect();
    let mut run_alone = Vec::new();
    for i in manifest.pending_meshes().to_vec() {
        let name = quote(&manifest.name(i));
        let mut runs = known.iter().filter(|mesh| mesh.name == name);
        // A mesh that ran alone would fail again with similar memory; if several ran, another one may have been the
        // cause.
        if runs.clone().any(|mesh| mesh.n_running == 1 && mesh.n_bytes / 4 >= allocator::limit() / 5) {
            manifest.fail_mesh(i, Failure::Failed(FAILURE.into()))?;
        } else if runs.next().is_some() {
            run_alone.push(i);
        }
    }
    out_of_memory::register_batch(path, manifest.names().iter().map(|name| quote(name)).collect());
    Ok(run_alone)
}

struct UnfinishedMesh<'a> {
    n_running: usize,
    /// Memory bound of that run, in bytes.
    n_bytes: usize,
    name: &'a str,
}

impl<'a> UnfinishedMesh<'a> {
    fn parse(line: &'a str) -> Option<Self> {
        let (n_running, rest) = line.split_once(' ')?;
        let (n_bytes, name) = rest.split_once(' ')?;
        Some(Self { n_running: n_running.parse().ok()?, n_bytes: n_bytes.parse().ok()?, name })
    }
}

fn quote(name: &str) -> String {
    format!("{name:?}")
}
