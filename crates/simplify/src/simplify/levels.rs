//! Levels of detail: several results from one collapse.

use super::closed::Task;
use super::driver::{run_in_turn, run_levels};
use super::input::Input;
use super::options::{ClosedOptions, Listener, Simplified, SimplifyError};
use super::size::Size;
use super::turns::{ChooseSize, NextSize};

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

/// Simplifies to one size after the other, each chosen by the result before, larger or smaller.
///
/// Sizes of bare meshes begin where one collapse to a small size was on its way.
///
/// # Errors
/// As [`simplify`](super::simplify).
#[doc(hidden)]
pub fn simplify_in_turn(
    input: &Input,
    options: &ClosedOptions,
    first: NextSize,
    progress: &mut Listener,
    choose: &mut ChooseSize,
) -> Result<(), SimplifyError> {
    run_in_turn(&Task::new(*input, options), first, progress, choose)
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
    use crate::simplify::{Options, Turn, simplify};

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
    fn sizes_in_turn_go_down_and_up_by_either_collapse() {
        let mesh = shapes::wavy_sphere(5, 8.0);
        let by_kernel = ClosedOptions::default();
        // Shapes that are held are not for the kernel.
        let by_merges = ClosedOptions { hold_shape: Some(1.0), ..by_kernel.clone() };
        for options in [by_kernel, by_merges] {
            let asked = [64, 900, 300, 700, 3000, 3000, 100, 20_000, 80];
            let (mut sizes, mut n_estimates) = (Vec::new(), None);
            let size = |i: usize| NextSize { n_vertices: asked[i], is_estimate: i == 0 };
            let mut choose = |turn: Turn| {
                match turn {
                    Turn::Estimates(estimates) => {
                        assert!(estimates.is_sorted_by(|a, b| a.0 > b.0 && a.1 <= b.1), "{estimates:?}");
                        n_estimates = Some(estimates.len());
                    }
                    Turn::Result(result) => {
                        assert!(topology(&result.mesh).is_closed_manifold());
                        sizes.push(result.mesh.positions().len());
                    }
                }
                (sizes.len() + 1 < asked.len()).then(|| size(sizes.len() + 1))
            };
            let mut next = Some(size(0));
            let input = Input::bare(&mesh);
            // A run ends before sizes that it has no way to.
            while let Some(first) = next.take() {
                let mut choose = |turn: Turn| {
                    next = choose(turn);
                    next
                };
                simplify_in_turn(&input, &options, first, &mut |_| ControlFlow::Continue(()), &mut choose).unwrap();
            }
            let n = mesh.positions().len();
            assert_eq!(sizes, [900, 300, 700, 3000, 3000, 100, n, 80]);
            assert_eq!(n_estimates.unwrap() > 3, options.hold_shape.is_none());
        }
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
