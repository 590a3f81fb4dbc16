//! A mesh without the vertices that no face uses, and results over all of its vertices again.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use rayon::prelude::*;

use crate::mesh::pulse::{PARALLEL, Pulse};
use crate::mesh::{TriMesh, compact};

use super::closed::Derivative;
use super::map;
use super::options::{Simplified, SimplifyError};

/// A mesh without the vertices that no face uses.
pub(super) struct Used<'a> {
    /// The mesh.
    pub mesh: Cow<'a, TriMesh>,
    /// Where its vertices stood, if any went.
    pub sources: Option<Vec<u32>>,
    /// Vertices of the caller's mesh.
    n_before: usize,
}

impl<'a> Used<'a> {
    /// The used part of a mesh.
    ///
    /// # Errors
    /// [`SimplifyError::Empty`] where there is no face.
    pub fn of(pulse: Pulse, mesh: &'a TriMesh) -> Result<Self, SimplifyError> {
        if mesh.faces().is_empty() {
            return Err(SimplifyError::Empty);
        }
        let n_before = mesh.positions().len();
        let used: Vec<AtomicBool> = (0..n_before).map(|_| AtomicBool::new(false)).collect();
        let mark = |face: &[u32; 3]| face.iter().for_each(|&v| used[v as usize].store(true, Relaxed));
        for faces in pulse.over(mesh.faces()) {
            faces.par_iter().with_min_len(PARALLEL).for_each(mark);
        }
        if used.into_iter().all(AtomicBool::into_inner) {
            return Ok(Self { mesh: Cow::Borrowed(mesh), sources: None, n_before });
        }
        let (mesh, sources) = compact(mesh.positions(), mesh.faces().to_vec()).map_err(|_| SimplifyError::Overflow)?;
        Ok(Self { mesh: Cow::Owned(mesh), sources: Some(sources), n_before })
    }

    /// The result with the vertices of the caller's mesh.
    pub fn widen(&self, mut simplified: Simplified) -> Simplified {
        let Some(sources) = &self.sources else { return simplified };
        simplified.map.iter_mut().for_each(|map| map::widen_vertices(map, sources, self.n_before));
        simplified.source_vertices.iter_mut().flatten().for_each(|v| *v = sources[*v as usize]);
        simplified
    }

    /// The derivative over the vertices of the caller's mesh.
    pub fn widen_derivative(&self, derivative: Derivative) -> Derivative {
        match &self.sources {
            Some(sources) => derivative.within(sources),
            None => derivative,
        }
    }
}
