//! Meshes that were under way when the memory of an earlier run was at an end: one alone fails, of several each is done alone.

use std::path::Path;

use super::manifest::Manifest;
use crate::failure::Failure;
use crate::{allocator, files, out_of_memory};

/// The file in OUTDIR that has them, a line each.
const NAME: &str = ".neural-mesh-out-of-memory";

/// Why a mesh failed that took a run down.
const WHY: &str = "ran out of memory: raise --memory or use fewer --threads";

/// Gives those that are to be done alone; has those of this run written down if it ends the same way.
pub fn meet(folder: &Path, manifest: &mut Manifest, resume: bool) -> Result<Vec<usize>, Failure> {
    let path = folder.join(NAME);
    let known = if resume && path.is_file() { files::read(&path)? } else { Vec::new() };
    if !resume {
        // None is there, or it is of a batch that this one replaces.
        let _ = std::fs::remove_file(&path);
    }
    let known = String::from_utf8_lossy(&known);
    let known: Vec<Fallen> = known.lines().filter_map(Fallen::of).collect();
    let mut alone = Vec::new();
    for i in manifest.waiting().to_vec() {
        let name = written(&manifest.name(i));
        let mut runs = known.iter().filter(|fallen| fallen.name == name);
        if runs.clone().any(|fallen| fallen.n_running == 1 && fallen.most / 4 >= allocator::most() / 5) {
            manifest.give_up(i, Failure::Failed(WHY.into()))?;
        } else if runs.next().is_some() {
            alone.push(i);
        }
    }
    out_of_memory::remember(path, manifest.names().iter().map(|name| written(name)).collect());
    Ok(alone)
}

/// A mesh that was under way.
struct Fallen<'a> {
    /// How many were.
    n_running: usize,
    /// The bytes that might be taken then.
    most: usize,
    name: &'a str,
}

impl<'a> Fallen<'a> {
    fn of(line: &'a str) -> Option<Self> {
        let (n_running, rest) = line.split_once(' ')?;
        let (most, name) = rest.split_once(' ')?;
        Some(Self { n_running: n_running.parse().ok()?, most: most.parse().ok()?, name })
    }
}

/// A name within a line.
fn written(name: &str) -> String {
    format!("{name:?}")
}
