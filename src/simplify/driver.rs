//! From the caller's mesh and options to results, whichever assembly makes them.

use std::borrow::Cow;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use rayon::prelude::*;

use crate::mesh::shares::PARALLEL;
use crate::mesh::{TriMesh, compact};
use crate::model::Weights;

use super::assemblies::{Sizes, Task, closed_levels, paper_result, unchanged};
use super::closed::{Closed, Derivative, is_sound};
use super::input::Input;
use super::limits::{resolve_levels, resolve_limit, resolve_oversample};
use super::map;
use super::options::{Assembly, Event, Simplified, SimplifyError, Target};
use super::symmetric;

/// One result, and how it depends on the positions, if that is asked for.
pub(super) fn run(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<(Simplified, Option<Derivative>), SimplifyError> {
    let options = task.options;
    input.check()?;
    if let Some(symmetry) = options.symmetric {
        let levels = symmetric::levels(input, weights, task, symmetry, &[options.target], progress)?;
        return Ok((levels.into_iter().next().ok_or(SimplifyError::Empty)?, None));
    }
    let used = Used::of(input.mesh)?;
    let importance = input.importance_of(used.sources.as_deref());
    let input = Input { mesh: &used.mesh, importance: &importance, ..*input };
    let limit = resolve_limit(&used.mesh, options)?;
    let oversample = resolve_oversample(&used.mesh, limit, options)?;
    let is_closed = options.assembly == Assembly::Closed;
    let is_done = limit.is_met_by(&used.mesh) && (!is_closed || is_sound(&used.mesh, &options.frame));
    let (simplified, derivative) = if is_done {
        (unchanged(&input, options, oversample), None)
    } else if is_closed {
        let levels = closed_levels(&input, weights, task, &Sizes { limits: &[limit], oversample }, progress)?;
        levels.into_iter().next().map(Closed::into_result).ok_or(SimplifyError::Empty)?
    } else {
        (paper_result(&used.mesh, weights, options, limit, progress)?, None)
    };
    let derivative = derivative.map(|derivative| used.widen_derivative(derivative));
    Ok((used.widen(simplified), derivative))
}

/// Results of these sizes, each no larger than the one before.
pub(super) fn run_levels(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    targets: &[Target],
    progress: &mut dyn FnMut(Event) -> ControlFlow<()>,
) -> Result<Vec<Simplified>, SimplifyError> {
    let options = task.options;
    input.check()?;
    if let Some(symmetry) = options.symmetric {
        return symmetric::levels(input, weights, task, symmetry, targets, progress);
    }
    let used = Used::of(input.mesh)?;
    let importance = input.importance_of(used.sources.as_deref());
    let input = Input { mesh: &used.mesh, importance: &importance, ..*input };
    let limits = resolve_levels(&used.mesh, targets, options)?;
    let oversample = resolve_oversample(&used.mesh, limits[0], options)?;
    // What is as large as the mesh is the mesh, as where there is one target.
    let is_sound = is_sound(&used.mesh, &options.frame);
    let n_unchanged = limits.iter().take_while(|limit| is_sound && limit.is_met_by(&used.mesh)).count();
    let same = (0..n_unchanged).map(|_| unchanged(&input, options, oversample));
    let sizes = Sizes { limits: &limits[n_unchanged..], oversample };
    let lighter = closed_levels(&input, weights, task, &sizes, progress)?;
    let levels = same.chain(lighter.into_iter().map(|closed| closed.into_result().0));
    Ok(levels.map(|simplified| used.widen(simplified)).collect())
}

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
    pub fn of(mesh: &'a TriMesh) -> Result<Self, SimplifyError> {
        if mesh.faces().is_empty() {
            return Err(SimplifyError::Empty);
        }
        let n_before = mesh.positions().len();
        let used: Vec<AtomicBool> = (0..n_before).map(|_| AtomicBool::new(false)).collect();
        let mark = |face: &[u32; 3]| face.iter().for_each(|&v| used[v as usize].store(true, Relaxed));
        mesh.faces().par_iter().with_min_len(PARALLEL).for_each(mark);
        if used.into_iter().all(AtomicBool::into_inner) {
            return Ok(Self { mesh: Cow::Borrowed(mesh), sources: None, n_before });
        }
        let (mesh, sources) = compact(mesh.positions(), mesh.faces().to_vec()).map_err(|_| SimplifyError::Overflow)?;
        Ok(Self { mesh: Cow::Owned(mesh), sources: Some(sources), n_before })
    }

    /// The result with the vertices of the caller's mesh.
    fn widen(&self, mut simplified: Simplified) -> Simplified {
        let Some(sources) = &self.sources else { return simplified };
        simplified.map.iter_mut().for_each(|map| map::widen_vertices(map, sources, self.n_before));
        simplified.source_vertices.iter_mut().flatten().for_each(|v| *v = sources[*v as usize]);
        simplified
    }

    fn widen_derivative(&self, derivative: Derivative) -> Derivative {
        match &self.sources {
            Some(sources) => derivative.within(sources),
            None => derivative,
        }
    }
}
