//! Levels of detail: several results from one collapse.

use super::closed::Task;
use super::driver::run_levels;
use super::input::Input;
use super::options::{ClosedOptions, Listener, Simplified, SimplifyError};
use super::size::Size;

/// Simplifies to several targets with one collapse, each no larger than the one before.
///
/// # Errors
/// As [`simplify`](super::simplify); [`SimplifyError::BadTarget`] if a target grows.
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use std::ops::ControlFlow;
/// use neural_mesh::mesh::shapes;
/// use neural_mesh::simplify::{ClosedOptions, Size, simplify_levels_of_detail};
/// let mesh = shapes::icosphere(4);
/// let options = ClosedOptions::default();
/// let sizes = [Size::Ratio(0.5), Size::Ratio(0.25), Size::Vertices(100)];
/// let go_on = &mut |_| ControlFlow::Continue(());
/// let levels = simplify_levels_of_detail(&mesh, &options, &sizes, go_on).unwrap();
/// let sizes: Vec<usize> = levels.iter().map(|level| level.mesh.positions().len()).collect();
/// assert_eq!(sizes, [1281, 640, 100]);
/// ```
pub fn simplify_levels_of_detail<'a>(
    input: impl Into<Input<'a>>,
    options: &ClosedOptions,
    sizes: &[Size],
    progress: &mut Listener,
) -> Result<Vec<Simplified>, SimplifyError> {
    let levels = run_levels(&Task::new(input.into(), options), sizes, progress)?;
    Ok(levels.into_iter().map(|(simplified, _)| simplified).collect())
}

/// Simplifies to the size even where too few vertices are free to keep the shape.
#[doc(hidden)]
pub fn simplify_forcing_size(
    input: &Input,
    options: &ClosedOptions,
    target: Size,
    progress: &mut Listener,
) -> Result<Simplified, SimplifyError> {
    let task = Task { forces_size: true, ..Task::new(*input, options) };
    let levels = run_levels(&task, &[target], progress)?;
    levels.into_iter().next().map(|(simplified, _)| simplified).ok_or(SimplifyError::Empty)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    use crate::mesh::{shapes, topology};
    use crate::simplify::{Options, simplify};

    #[test]
    fn the_first_level_is_what_it_would_be_alone_and_all_are_closed() {
        let mesh = shapes::wavy_sphere(4, 8.0);
        let sizes = [Size::Ratio(0.4), Size::Ratio(0.2), Size::Faces(200), Size::Vertices(40)];
        let go_on = &mut |_| ControlFlow::Continue(());
        let options = ClosedOptions::default();
        let levels = simplify_levels_of_detail(&mesh, &options, &sizes, go_on).unwrap();
        let alone = simplify(&mesh, &Options::new(sizes[0]), go_on).unwrap();
        assert_eq!(levels[0], alone);
        assert!(levels.iter().all(|level| topology(&level.mesh).is_closed_manifold()));
        assert_eq!((levels[2].mesh.faces().len(), levels[3].mesh.positions().len()), (200, 40));
    }

    #[test]
    fn levels_that_grow_are_refused_and_the_whole_stays_the_whole() {
        let mesh = shapes::icosphere(2);
        let simplify = |ratios: [f64; 2]| {
            let go_on = &mut |_| ControlFlow::Continue(());
            let options = ClosedOptions::default();
            simplify_levels_of_detail(&mesh, &options, &ratios.map(Size::Ratio), go_on)
        };
        let levels = simplify([1.0, 0.5]).unwrap();
        assert_eq!((&levels[0].mesh, levels[1].mesh.positions().len()), (&mesh, 81));
        let grown = simplify([0.5, 0.6]);
        assert_eq!(grown.unwrap_err(), SimplifyError::BadTarget(Size::Ratio(0.6)));
    }
}
