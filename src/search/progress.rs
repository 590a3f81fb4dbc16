//! Progress of a search with an unknown number of runs.

use std::ops::ControlFlow;

use crate::simplify::{Event, Listener, SimplifyError};

/// Number of runs after which the progress of a search is 0.5.
// Halfway through searches of three to eight equal runs, the progress is then 0.41 to 0.65.
const HALF: f32 = 2.2;

pub(super) struct Search<'a, 'b> {
    listener: &'a mut Listener<'b>,
    /// Number of runs begun.
    n_over: usize,
    /// Share of a run's progress that simplification takes; the check takes the rest.
    of_run: f32,
}

impl<'a, 'b> Search<'a, 'b> {
    pub fn new(listener: &'a mut Listener<'b>, of_run: f32) -> Self {
        Self { listener, n_over: 0, of_run }
    }

    /// Returns the listener for the next run.
    pub fn run(&mut self) -> impl FnMut(Event) -> ControlFlow<()> + Send {
        let before = self.n_over as f32;
        self.n_over += 1;
        let (listener, of_run) = (&mut *self.listener, self.of_run);
        move |event| listener(Event { total: share_done(before + of_run * event.total), ..event })
    }

    /// Announces to the listener that the check of a run's results begins.
    ///
    /// # Errors
    /// [`SimplifyError::Interrupted`] if the listener ends the search.
    pub fn look(&mut self, stage: &'static str) -> Result<(), SimplifyError> {
        let total = share_done(self.n_over as f32 - 1.0 + self.of_run);
        match (self.listener)(Event { stage, done: 0.0, total }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(SimplifyError::Interrupted),
        }
    }
}

fn share_done(n_runs: f32) -> f32 {
    n_runs / (n_runs + HALF)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::search::{simplify_to_error, simplify_to_size};
    use crate::simplify::{Assembly, ClosedOptions, Input, Simplified, SimplifyError};

    #[test]
    fn the_share_of_a_search_that_is_done_never_falls() {
        let (mesh, options) = (shapes::wavy_sphere(3, 5.0), ClosedOptions::default());
        let assembly = Assembly::Closed(options.clone());
        let input = Input::bare(&mesh);
        for by_error in [true, false] {
            let (mut last, mut n_runs) = (0.0, 0);
            let mut hear = |event: Event| {
                assert!((last..=1.0).contains(&event.total), "{last} {event:?}");
                n_runs += usize::from(event.stage == "collapse" && event.done == 0.0);
                last = event.total;
                ControlFlow::Continue(())
            };
            if by_error {
                simplify_to_error(&input, &options, 0.05, &mut hear).unwrap();
            } else {
                let bytes_of = |result: &Simplified| Ok::<_, SimplifyError>(26 * result.mesh.faces().len());
                simplify_to_size(&input, &assembly, 9000, &bytes_of, &mut hear).unwrap();
            }
            assert!(n_runs > 1 && last > 0.0, "{n_runs}");
        }
    }
}
