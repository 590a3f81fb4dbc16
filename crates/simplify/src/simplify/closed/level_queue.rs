//! Sizes that are asked for in turn, and what takes their results.

use crate::mesh::TriMesh;
use crate::simplify::limits::Limit;
use crate::simplify::options::SimplifyError;

use super::result::ClosedResult;

/// A size to make.
#[derive(Clone, Copy)]
pub struct NextLevel {
    pub limit: Limit,
    /// True if no other follows, so that nothing has to be kept.
    pub is_last: bool,
    /// True if only estimates of the distance at sizes on the way are wanted.
    pub is_estimate: bool,
}

/// Sizes that are asked for in turn, each by the results before.
pub trait LevelQueue {
    /// Returns the size to make next, if any.
    fn next(&self) -> Option<NextLevel>;

    /// Takes the result of that size, and may ask for another.
    ///
    /// # Errors
    /// Those of what takes it.
    fn take(&mut self, result: ClosedResult) -> Result<(), SimplifyError>;

    /// Takes estimates in place of a result: numbers of vertices, and the largest distance then, in the mesh's unit.
    ///
    /// None where the collapse makes none.
    fn take_estimates(&mut self, _estimates: &[(usize, f64)]) {}

    /// Returns whether a size may be larger than the one before.
    fn may_grow(&self) -> bool {
        false
    }

    /// Returns the smallest size that may be asked for.
    fn least(&self) -> usize;
}

/// Given sizes, in falling order.
pub struct LimitList<'a> {
    limits: &'a [Limit],
    pub results: Vec<ClosedResult>,
}

impl<'a> LimitList<'a> {
    pub fn new(limits: &'a [Limit]) -> Self {
        Self { limits, results: Vec::with_capacity(limits.len()) }
    }
}

impl LevelQueue for LimitList<'_> {
    fn next(&self) -> Option<NextLevel> {
        let &limit = self.limits.get(self.results.len())?;
        Some(NextLevel { limit, is_last: self.results.len() + 1 == self.limits.len(), is_estimate: false })
    }

    fn take(&mut self, result: ClosedResult) -> Result<(), SimplifyError> {
        self.results.push(result);
        Ok(())
    }

    fn least(&self) -> usize {
        self.limits.iter().map(|limit| limit.size()).min().unwrap_or(0)
    }
}

/// A queue whose results are changed before it takes them.
pub struct ChangedResults<'a, F> {
    queue: &'a mut dyn LevelQueue,
    change: F,
    whole: Option<&'a TriMesh>,
}

impl<'a, F: FnMut(&mut ClosedResult)> ChangedResults<'a, F> {
    pub fn new(queue: &'a mut dyn LevelQueue, change: F) -> Self {
        Self { queue, change, whole: None }
    }

    /// Merges nothing at sizes at or above that of a mesh.
    // Repairs of an unsound mesh split vertices; none is then merged away to make up for them.
    pub fn keeping_whole(self, mesh: &'a TriMesh) -> Self {
        Self { whole: Some(mesh), ..self }
    }
}

impl<F: FnMut(&mut ClosedResult)> LevelQueue for ChangedResults<'_, F> {
    fn next(&self) -> Option<NextLevel> {
        let next = self.queue.next()?;
        let is_met = self.whole.is_some_and(|mesh| next.limit.is_met_by(mesh));
        Some(NextLevel { limit: if is_met { Limit::NONE } else { next.limit }, ..next })
    }

    fn take(&mut self, mut result: ClosedResult) -> Result<(), SimplifyError> {
        (self.change)(&mut result);
        self.queue.take(result)
    }

    fn take_estimates(&mut self, estimates: &[(usize, f64)]) {
        self.queue.take_estimates(estimates);
    }

    fn may_grow(&self) -> bool {
        self.queue.may_grow()
    }

    fn least(&self) -> usize {
        self.queue.least()
    }
}
