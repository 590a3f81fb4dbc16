//! States of a collapse on its way to a size, from which larger sizes go on.

use crate::simplify::limits::Limit;

use super::collapse::Collapse;

/// Size at which the collapse is kept on its way to a size, over that size.
// Sizes that a search asks for after the first are seldom larger than this.
const KEPT_FACTOR: f64 = 3.0;

/// Kept states, the smallest last; none unless sizes may grow.
pub struct KeptWay<'a> {
    may_grow: bool,
    kept: Vec<Collapse<'a>>,
}

impl<'a> KeptWay<'a> {
    pub fn new(may_grow: bool) -> Self {
        Self { may_grow, kept: Vec::new() }
    }

    /// Goes a part of the way to a size and keeps the state there.
    pub fn go_part(&mut self, collapse: &mut Collapse<'a>, limit: Limit) {
        let part = limit.scale(KEPT_FACTOR);
        if self.may_grow && collapse.merges_to(part) > 0 {
            collapse.run(part);
            self.kept.push(collapse.clone());
        }
    }

    /// Returns the smallest kept state above a size.
    pub fn go_back(&mut self, limit: Limit) -> Option<Collapse<'a>> {
        while self.kept.last().is_some_and(|kept| kept.merges_to(limit) == 0) {
            self.kept.pop();
        }
        self.kept.last().cloned()
    }
}
