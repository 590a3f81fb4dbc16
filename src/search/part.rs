//! One of several runs as its listener hears it: as a part of the whole search.

use std::ops::ControlFlow;

use crate::simplify::{Event, Listener};

/// Hears of one run after `n_before` others, of `n_most`: its share of the whole is one of so many equal ones.
pub(super) fn part_of(
    listener: &mut Listener,
    n_before: usize,
    n_most: usize,
) -> impl FnMut(Event) -> ControlFlow<()> + Send {
    move |event| listener(Event { total: (n_before as f32 + event.total) / n_most as f32, ..event })
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
