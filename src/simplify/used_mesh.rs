//! Removal of unused vertices, and renumbering of results to the input.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use rayon::prelude::*;

use crate::mesh::pulse::{PARALLEL, Pulse};
use crate::mesh::{TriMesh, compact};

use super::closed::Derivative;
use super::map;
use super::options::{Simplified, SimplifyError};

pub(super) struct UsedMesh<'a> {
    pub mesh: Cow<'a, TriMesh>,
    pub sources: Option<Vec<u32>>,
    n_input: usize,
}

impl<'a> UsedMesh<'a> {
    /// Removes the unused vertices of a mesh.
    ///
    /// # Errors
    /// [`SimplifyError::Empty`] for a mesh without faces.
    pub fn new(pulse: Pulse, mesh: &'a TriMesh) -> Result<Self, SimplifyError> {
        if mesh.faces().is_empty() {
            return Err(SimplifyError::Empty);
        }
        let n_input = mesh.positions().len();
        // Marks commute, so threads may set them in any order.
        let used: Vec<AtomicBool> = (0..n_input).map(|_| AtomicBool::new(false)).collect();
        let mark = |face: &[u32; 3]| face.iter().for_each(|&v| used[v as usize].store(true, Relaxed));
        for faces in pulse.chunks(mesh.faces()) {
            faces.par_iter().with_min_len(PARALLEL).for_each(mark);
        }
        if used.into_iter().all(AtomicBool::into_inner) {
            return Ok(Self { mesh: Cow::Borrowed(mesh), sources: None, n_input });
        }
        let (mesh, sources) = compact(mesh.positions(), mesh.faces().to_vec()).map_err(|_| SimplifyError::Overflow)?;
        Ok(Self { mesh: Cow::Owned(mesh), sources: Some(sources), n_input })
    }

    pub fn renumber(&self, mut simplified: Simplified) -> Simplified {
        let Some(sources) = &self.sources else { return simplified };
        simplified.map.iter_mut().for_each(|map| map::renumber_map(map, sources, self.n_input));
        simplified.source_vertices.iter_mut().flatten().for_each(|v| *v = sources[*v as usize]);
        simplified
    }

    pub fn renumber_derivative(&self, derivative: Derivative) -> Derivative {
        match &self.sources {
            Some(sources) => derivative.extend_to(sources),
            None => derivative,
        }
    }
}
