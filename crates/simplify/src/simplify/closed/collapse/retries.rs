//! Merges that are tried again: those of vertices whose failures may be over.

use super::failed_merges::FailedMerges;
use super::state::{Collapse, REMOVED};

impl Collapse<'_> {
    /// Begins the list of a vertex's failures.
    pub(super) fn begin_failures(&mut self, v: u32) {
        let (since, id) = (self.pass, self.nodes[v as usize].id);
        if let Some(failed) = self.failed.get_mut(id as usize) {
            *failed = FailedMerges { since, ..FailedMerges::NONE };
        }
    }

    /// Notes why a merge of a vertex failed: a turned face, or a ceiling, exceeded by `short_by`.
    pub(super) fn note_failure(&mut self, v: u32, short_by: Option<f32>) {
        self.was_ceiling_met |= short_by.is_some();
        self.was_turn_forbidden |= short_by.is_none();
        let id = self.nodes[v as usize].id;
        if let Some(failed) = self.failed.get_mut(id as usize) {
            failed.add(short_by);
        }
    }

    /// Marks a vertex whose edges have all failed.
    pub(super) fn end_failures(&mut self, v: u32) {
        let id = self.nodes[v as usize].id;
        if let Some(failed) = self.failed.get_mut(id as usize) {
            failed.are_all = true;
        }
    }

    pub(super) fn forget_failures(&mut self) {
        self.failed.fill(FailedMerges::NONE);
    }

    /// Lets every vertex try its merges again whose failures may be over; returns whether there is one.
    pub(super) fn reset_failed_merges(&mut self) -> bool {
        (self.was_turn_forbidden, self.was_ceiling_met) = (false, false);
        let mut may_merge = false;
        for v in 0..self.n_inner as u32 {
            match self.standing_failures(v) {
                Some(failed) => {
                    self.was_turn_forbidden |= failed.was_turn_forbidden;
                    self.was_ceiling_met |= failed.short_by < f32::INFINITY;
                }
                None => {
                    let has_price = self.cheapest.get(v as usize).is_none_or(|edge| edge.price() < f32::INFINITY);
                    let node = &mut self.nodes[v as usize];
                    node.wait = 0.0;
                    may_merge |= node.corner != REMOVED && has_price;
                }
            }
        }
        may_merge
    }

    /// Returns the failures of a vertex all of whose edges would fail again.
    fn standing_failures(&self, v: u32) -> Option<FailedMerges> {
        let node = &self.nodes[v as usize];
        let failed = *self.failed.get(node.id as usize)?;
        let is_unchanged = |w: u32| self.is_ghost(w) || self.nodes[w as usize].changed.is_before(failed.since);
        let stands = node.corner != REMOVED && failed.are_all && failed.short_by > 0.0;
        (stands && is_unchanged(v) && self.neighbors(v).all(is_unchanged)).then_some(failed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::pulse::Pulse;
    use crate::mesh::shapes;
    use crate::simplify::closed::collapse::{Ceiling, Ceilings, CollapseEnd};
    use crate::simplify::closed::prepare::surface::PreparedSurface;
    use crate::simplify::limits::Limit;

    #[test]
    fn only_vertices_that_may_merge_are_tried_again() {
        let sphere = shapes::wavy_sphere(4, 8.0);
        let n = sphere.positions().len();
        let mesh =
            shapes::unite([&sphere, &shapes::place(&shapes::torus(40, 30, 1.0, 0.4), |[x, y, z]| [x + 3.0, y, z])]);
        let surface = PreparedSurface::new(&mesh, Pulse::NONE);
        let of_vertex = (0..surface.n_vertices()).map(|v| u32::from(v >= n)).collect();
        let ceilings = [0.01, 0.02].map(|allowed| Ceiling { allowed, stretch: 1.0 });
        let collapse = Collapse::new(Pulse::NONE, &surface);
        let mut collapse = collapse.with_ceilings(Ceilings::new(of_vertex, ceilings.to_vec(), 1.0));
        let smallest = Limit::from_vertices(4);
        for share in [0.0, 0.015, 0.03, 0.06] {
            if share > 0.0 {
                assert!(collapse.raise_ceilings(share));
            }
            let before = collapse.size();
            assert_eq!(collapse.run(smallest), CollapseEnd::LosesShape);
            assert!(collapse.size() < before, "{share}");
            // What counts as failed for good fails for one that tries everything, too.
            let mut naive = collapse.clone();
            naive.forget_failures();
            assert!(naive.reset_failed_merges());
            assert_eq!((naive.run(smallest), naive.size()), (CollapseEnd::LosesShape, collapse.size()));
            // Without a higher ceiling nothing is tried again.
            assert!(!collapse.clone().raise_ceilings(share));
            assert!(!collapse.clone().raise_ceilings(share * 1.000_001));
        }
    }
}
