//! Limits of a collapse that are lifted step by step, because its size is out of reach within them.

use super::constraints::Constraints;
use super::state::Collapse;

impl Collapse<'_> {
    pub fn has_ceilings(&self) -> bool {
        !self.ceilings.left.is_empty()
    }

    /// Raises all lower ceilings to a share of the scene's diagonal; returns whether a merge may be allowed now.
    pub fn raise_ceilings(&mut self, share: f64) -> bool {
        let risen_by = self.ceilings.raise_to(share);
        let failed = self.failed.iter_mut().zip(&self.ceilings.component_of_vertex);
        failed.for_each(|(failed, &component)| failed.raise_ceiling(risen_by[component as usize]));
        self.retry_failed_merges()
    }

    /// Lets vertices leave the curves that held them; returns false if nothing was held.
    pub fn soften_curves(&mut self) -> bool {
        let is_changed = self.constraints.as_mut().is_some_and(Constraints::soften_curves);
        if is_changed {
            self.forget_failures();
            self.retry_failed_merges();
            // Edges across the curves had no price so far.
            self.cheapest.clear();
        }
        is_changed
    }

    /// Lets faces turn by up to `least_cosine`.
    pub fn allow_turns(&mut self, least_cosine: f32) {
        self.least_cosine = least_cosine;
        self.forget_failures();
        self.retry_failed_merges();
    }

    /// Lets failed merges be tried again; those that are recorded from now on come after all before.
    fn retry_failed_merges(&mut self) -> bool {
        if let Some(recording) = &mut self.recording {
            let last = recording.keys.iter().copied().fold(0.0, f32::max);
            recording.keys.fill(last);
        }
        self.reset_failed_merges()
    }
}
