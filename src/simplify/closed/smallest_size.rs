//! Repeats a collapse that cannot reach its limit, to a size above its smallest: its last merges do most harm.

use crate::mesh::TriMesh;
use crate::simplify::limits::Limit;
use crate::simplify::options::SimplifyError;
use crate::simplify::progress::Progress;

use super::collapse::{Collapse, CollapseEnd};
use super::deviation_check::distance;
use super::original::Original;
use super::output::Output;
use super::request::ClosedRequest;
use super::{CollapseBase, start};

/// Vertices kept above the smallest size, over those of this size or over those merged, whichever are fewer.
// FLIP errors of four scenes are 0.62 times those at the smallest size, at 0.05 0.79 times, at 0.2 0.46 times.
const MARGIN: f64 = 0.1;
/// Mean distance at unit size below which the last merges did no harm.
const NEGLIGIBLE: f64 = 1e-5;

/// Returns whether a collapse ended at its smallest size, above its limit, and with a loss.
pub fn is_lossy_end(request: &ClosedRequest, end: CollapseEnd, original: &Original, output: &Output) -> bool {
    end == CollapseEnd::LosesShape && !request.forces_size && distance(original, output) > NEGLIGIBLE
}

/// Returns the collapse to the smallest size that keeps shapes well, of at most `most` vertices, and its base.
pub fn repeat_above_smallest<'a, 'p: 'a>(
    mesh: &'a TriMesh,
    request: &ClosedRequest<'a>,
    (base, mut ended): (CollapseBase<'a>, Collapse<'p>),
    most: usize,
    progress: Progress<'p>,
) -> Result<(CollapseBase<'a>, Collapse<'p>), SimplifyError> {
    let n_left = ended.size().0;
    let n_merged = base.original.surface.n_vertices().saturating_sub(n_left);
    let size = n_left + (MARGIN * n_left.min(n_merged) as f64) as usize;
    let limit = Limit::from_vertices(size.min(most));
    let (base, mut collapse) = match ended.take_copy() {
        Some(copy) if copy.size().0 >= limit.vertices => (base, copy),
        // Memory is freed before the collapse is repeated.
        _ => {
            drop((base, ended));
            start(mesh, request, limit, progress.without_stages())?
        }
    };
    collapse.run(limit);
    Ok((base, collapse))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Attributes, shapes};
    use crate::simplify::closed::{Levels, Task, simplify_levels};
    use crate::simplify::input::Input;
    use crate::simplify::options::{ClosedOptions, Outcome};

    fn three_spheres() -> TriMesh {
        let sphere = shapes::wavy_sphere(4, 10.0);
        let n = sphere.positions().len() as u32;
        let positions =
            (0..3).flat_map(|i| sphere.positions().iter().map(move |&[x, y, z]| [x + 3.0 * i as f32, y, z]));
        let faces = (0..3).flat_map(|i| sphere.faces().iter().map(move |face| face.map(|v| v + i * n)));
        TriMesh::new(positions.collect(), faces.collect()).unwrap()
    }

    fn simplify(mesh: &TriMesh, limits: &[usize], task: Task) -> Vec<usize> {
        let attributes = Attributes { groups: vec![0; mesh.faces().len()], ..Attributes::default() };
        let options = ClosedOptions { prune: false, ..ClosedOptions::default() };
        let input = Input { attributes: &attributes, ..Input::bare(mesh) };
        let request = ClosedRequest::new(&input, &Task { options: &options, ..task });
        let limits: Vec<Limit> = limits.iter().map(|&n| Limit::from_vertices(n)).collect();
        let levels = simplify_levels(mesh, &request, Levels::new(&limits), Progress::SILENT).unwrap();
        let size = |(closed, limit): (&crate::simplify::closed::ClosedResult, &Limit)| {
            let (report, n) = (&closed.simplified.report, closed.simplified.mesh.positions().len());
            assert_eq!(report.outcome == Outcome::Reached, n <= limit.vertices);
            assert_eq!(report.components_keep_shape, n > limit.vertices);
            n
        };
        levels.results.iter().zip(&limits).map(size).collect()
    }

    #[test]
    fn a_size_out_of_reach_gives_a_tenth_more_than_the_smallest_and_levels_never_grow() {
        let (mesh, options) = (three_spheres(), ClosedOptions::default());
        let task = Task::new(&options, None);
        let smallest = simplify(&mesh, &[12], Task { forces_size: true, ..task })[0];
        let with_margin = smallest + smallest / 10;
        assert!(smallest > 12 && with_margin < mesh.positions().len() / 4);
        for is_differentiable in [false, true] {
            let task = Task { differentiable: is_differentiable, ..task };
            assert_eq!(simplify(&mesh, &[12], task), [with_margin]);
        }
        // The smallest size depends a little on the sizes before.
        let levels = simplify(&mesh, &[2000, 12, 12, 1], task);
        assert!(levels[0] == 2000 && levels[1].abs_diff(with_margin) < with_margin / 10, "{levels:?} {with_margin}");
        assert_eq!(levels[1..], [levels[1]; 3]);
        let between = smallest + smallest / 20;
        let levels = simplify(&mesh, &[between, 12], task);
        assert!(levels[0] == between && levels[1] <= between, "{levels:?}");
    }
}
