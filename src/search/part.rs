//! Runs of a search as its listener hears them: nobody knows ahead how many there will be.

use std::ops::ControlFlow;

use crate::simplify::{Event, Listener, SimplifyError};

/// After so many runs half of the search is said to be done. So a search of three to eight equal runs is said to be at 0.41 to 0.65 of
/// its way when half of its time is over.
const HALF: f32 = 2.2;

/// How far a search is.
pub(super) struct Search<'a, 'b> {
    listener: &'a mut Listener<'b>,
    /// Runs that are over, with all that follows each.
    n_over: usize,
    /// The share of a run, of its time with what follows it.
    of_run: f32,
}

impl<'a, 'b> Search<'a, 'b> {
    /// Of runs that take so large a share of the time, beside what looks at their results.
    pub fn new(listener: &'a mut Listener<'b>, of_run: f32) -> Self {
        Self { listener, n_over: 0, of_run }
    }

    /// The listener to the next run.
    pub fn run(&mut self) -> impl FnMut(Event) -> ControlFlow<()> + Send {
        let before = self.n_over as f32;
        self.n_over += 1;
        let (listener, of_run) = (&mut *self.listener, self.of_run);
        move |event| listener(Event { total: done(before + of_run * event.total), ..event })
    }

    /// What a run has made is looked at.
    ///
    /// # Errors
    /// [`SimplifyError::Interrupted`] where the listener asks to stop.
    pub fn look(&mut self, stage: &'static str) -> Result<(), SimplifyError> {
        let total = done(self.n_over as f32 - 1.0 + self.of_run);
        match (self.listener)(Event { stage, done: 0.0, total }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(SimplifyError::Interrupted),
        }
    }
}

fn done(n_runs: f32) -> f32 {
    n_runs / (n_runs + HALF)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::search::{simplify_to_error, simplify_to_size};
    use crate::simplify::{Input, Options, Simplified, SimplifyError, Target};

    #[test]
    fn the_share_of_a_search_that_is_done_never_falls() {
        let (mesh, options) = (shapes::wavy_sphere(3, 5.0), Options::new(Target::Ratio(1.0)));
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
                simplify_to_error(&input, None, &options, 0.05, &mut hear).unwrap();
            } else {
                let bytes_of = |result: &Simplified| Ok::<_, SimplifyError>(26 * result.mesh.faces().len());
                simplify_to_size(&input, None, &options, 9000, &bytes_of, &mut hear).unwrap();
            }
            assert!(n_runs > 1 && last > 0.0, "{n_runs}");
        }
    }
}
