//! From the caller's mesh and options to results, whichever assembly makes them.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

use rayon::prelude::*;

use crate::mesh::pulse::Pulse;
use crate::mesh::shares::PARALLEL;
use crate::mesh::{TriMesh, compact};
use crate::model::Weights;

use super::assemblies::{Sizes, Task, closed_levels, paper_result, unchanged};
use super::closed::{Closed, Derivative, is_sound};
use super::input::Input;
use super::limits::{resolve_levels, resolve_limit, resolve_oversample};
use super::map;
use super::options::{Assembly, Listener, Simplified, SimplifyError, Target};
use super::progress::{PAPER, Progress, closed_stages, listened};
use super::symmetric;

/// One result, and how it depends on the positions, if that is asked for.
pub(super) fn run(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    listener: &mut Listener,
) -> Result<(Simplified, Option<Derivative>), SimplifyError> {
    let stages = match task.options.assembly {
        Assembly::Closed => closed_stages(1, task.options.symmetric.is_some()),
        Assembly::Paper => PAPER.to_vec(),
    };
    listened(listener, &stages, |progress| one(input, weights, task, progress))
}

fn one(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    progress: Progress,
) -> Result<(Simplified, Option<Derivative>), SimplifyError> {
    let options = task.options;
    input.check()?;
    if let Some(symmetry) = options.symmetric {
        let levels = symmetric::levels(input, weights, task, symmetry, &[options.target], progress)?;
        return Ok((levels.into_iter().next().ok_or(SimplifyError::Empty)?, None));
    }
    let is_closed = options.assembly == Assembly::Closed;
    if is_closed {
        progress.enter("surface", input.mesh.faces().len())?;
    }
    let used = Used::of(progress.pulse, input.mesh)?;
    let importance = input.importance_of(used.sources.as_deref());
    let input = Input { mesh: &used.mesh, importance: &importance, ..*input };
    let limit = resolve_limit(&used.mesh, options)?;
    let oversample = resolve_oversample(&used.mesh, limit, options)?;
    let is_done = limit.is_met_by(&used.mesh) && (!is_closed || is_sound(&used.mesh, &options.frame));
    let (simplified, derivative) = if is_done {
        (unchanged(progress.pulse, &input, options, oversample), None)
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
    listener: &mut Listener,
) -> Result<Vec<Simplified>, SimplifyError> {
    let stages = closed_stages(targets.len(), task.options.symmetric.is_some());
    listened(listener, &stages, |progress| several(input, weights, task, targets, progress))
}

fn several(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    targets: &[Target],
    progress: Progress,
) -> Result<Vec<Simplified>, SimplifyError> {
    let options = task.options;
    input.check()?;
    if let Some(symmetry) = options.symmetric {
        return symmetric::levels(input, weights, task, symmetry, targets, progress);
    }
    progress.enter("surface", input.mesh.faces().len())?;
    let used = Used::of(progress.pulse, input.mesh)?;
    let importance = input.importance_of(used.sources.as_deref());
    let input = Input { mesh: &used.mesh, importance: &importance, ..*input };
    let limits = resolve_levels(&used.mesh, targets, options)?;
    let oversample = resolve_oversample(&used.mesh, limits[0], options)?;
    // What is as large as the mesh is the mesh, as where there is one target.
    let n_met = limits.iter().take_while(|limit| limit.is_met_by(&used.mesh)).count();
    let n_unchanged = if n_met > 0 && is_sound(&used.mesh, &options.frame) { n_met } else { 0 };
    let same = (0..n_unchanged).map(|_| unchanged(progress.pulse, &input, options, oversample));
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
