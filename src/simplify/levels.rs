//! Levels of detail: several results from one collapse.

use crate::model::Weights;

use super::assemblies::Task;
use super::driver::run_levels;
use super::input::Input;
use super::options::{Listener, Options, Simplified, SimplifyError, Target};

/// Simplifies to the target of `options` and to `further` targets, each no larger than the one before.
///
/// # Errors
/// As [`simplify_input`](super::simplify_input); [`SimplifyError::BadTarget`] if a target grows, or with the paper's
/// assembly.
///
/// ```
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::shapes;
/// use neural_mesh::simplify::{Input, Options, Target, simplify_levels_of_detail};
/// let mesh = shapes::icosphere(4);
/// let options = Options::new(Target::Ratio(0.5));
/// let further = [Target::Ratio(0.25), Target::Vertices(100)];
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let levels = simplify_levels_of_detail(&Input::bare(&mesh), None, &options, &further, go_on).unwrap();
/// let sizes: Vec<usize> = levels.iter().map(|level| level.mesh.positions().len()).collect();
/// assert_eq!(sizes, [1281, 640, 100]);
/// ```
pub fn simplify_levels_of_detail(
    input: &Input,
    weights: Option<&Weights>,
    options: &Options,
    further: &[Target],
    progress: &mut Listener,
) -> Result<Vec<Simplified>, SimplifyError> {
    let targets: Vec<Target> = [options.target].iter().chain(further).copied().collect();
    simplify_task_levels(input, weights, &Task::new(options), &targets, progress)
}

/// Simplifies to each of these sizes with one collapse; ignores the target of `options`.
pub(crate) fn simplify_to_sizes(
    input: &Input,
    weights: Option<&Weights>,
    options: &Options,
    targets: &[Target],
    progress: &mut Listener,
) -> Result<Vec<Simplified>, SimplifyError> {
    simplify_task_levels(input, weights, &Task::new(options), targets, progress)
}

fn simplify_task_levels(
    input: &Input,
    weights: Option<&Weights>,
    task: &Task,
    targets: &[Target],
    progress: &mut Listener,
) -> Result<Vec<Simplified>, SimplifyError> {
    let levels = run_levels(input, weights, task, targets, progress)?;
    Ok(levels.into_iter().map(|(simplified, _)| simplified).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    use crate::mesh::{shapes, topology};
    use crate::simplify::simplify;

    #[test]
    fn the_first_level_is_what_it_would_be_alone_and_all_are_closed() {
        let mesh = shapes::wavy_sphere(4, 8.0);
        let options = Options::new(Target::Ratio(0.4));
        let further = [Target::Ratio(0.2), Target::Faces(200), Target::Vertices(40)];
        let go_on = &mut |_| ControlFlow::Continue(());
        let levels = simplify_levels_of_detail(&Input::bare(&mesh), None, &options, &further, go_on).unwrap();
        let alone = simplify(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(levels[0], alone);
        assert!(levels.iter().all(|level| topology(&level.mesh).is_closed_manifold()));
        assert_eq!((levels[2].mesh.faces().len(), levels[3].mesh.positions().len()), (200, 40));
    }

    #[test]
    fn levels_that_grow_are_refused_and_the_whole_stays_the_whole() {
        let mesh = shapes::icosphere(2);
        let go_on = &mut |_| ControlFlow::Continue(());
        let whole = Options::new(Target::Ratio(1.0));
        let levels =
            simplify_levels_of_detail(&Input::bare(&mesh), None, &whole, &[Target::Ratio(0.5)], go_on).unwrap();
        assert_eq!((&levels[0].mesh, levels[1].mesh.positions().len()), (&mesh, 81));
        let half = Options::new(Target::Ratio(0.5));
        let grown = simplify_levels_of_detail(&Input::bare(&mesh), None, &half, &[Target::Ratio(0.6)], go_on);
        assert_eq!(grown.unwrap_err(), SimplifyError::BadTarget(Target::Ratio(0.6)));
    }
}
