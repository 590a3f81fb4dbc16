//! The closed assembly under a given importance, for training.

use crate::mesh::TriMesh;

use super::closed::{ClosedRequest, Importance, Levels, Task, simplify_levels};
use super::input::Input;
use super::limits::Limit;
use super::options::{ClosedOptions, Refinements, SimplifyError};
use super::progress::Progress;

/// Result of [`simplify_with_importance`].
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedResult {
    /// Simplified mesh.
    pub mesh: TriMesh,
    /// Output vertex of each input vertex.
    pub vertex_of: Vec<u32>,
}

/// Simplifies `mesh` to `n_vertices` with vertices weighted by area times importance.
///
/// # Errors
/// [`SimplifyError::BadImportance`] if factors are not positive or not one per vertex, or a vertex is on no face;
/// [`SimplifyError::Overflow`].
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::shapes, simplify::{Importance, Refinements, simplify_with_importance}};
/// let sphere = shapes::icosphere(4);
/// let north: Vec<f32> = sphere.positions().iter().map(|p| if p[2] > 0.0 { 16.0 } else { 1.0 }).collect();
/// let result = simplify_with_importance(&sphere, 200, Importance::Given(&north), &Refinements::default()).unwrap();
/// let simplified = result.mesh;
/// let n_north = simplified.positions().iter().filter(|p| p[2] > 0.0).count();
/// assert!(simplified.positions().len() == 200 && n_north > 110);
/// ```
pub fn simplify_with_importance(
    mesh: &TriMesh,
    n_vertices: usize,
    importance: Importance,
    refinements: &Refinements,
) -> Result<WeightedResult, SimplifyError> {
    let n = mesh.positions().len();
    let mut used = vec![false; n];
    mesh.faces().as_flattened().iter().for_each(|&v| used[v as usize] = true);
    // Unused vertices would have an importance but no area.
    if n == 0 || !is_importance(importance, n) || used.contains(&false) {
        return Err(SimplifyError::BadImportance);
    }
    let limit = Limit::from_vertices(n_vertices.max(1));
    let options = ClosedOptions { prune: false, ..ClosedOptions::default() };
    let planned = ClosedRequest::new(&Input::bare(mesh), &Task::new(&options, None));
    let request = ClosedRequest { importance, refinements: *refinements, ..planned };
    let levels = simplify_levels(mesh, &request, Levels::new(&[limit]), Progress::SILENT)?;
    let closed = levels.results.into_iter().next().ok_or(SimplifyError::Empty)?;
    Ok(WeightedResult { mesh: closed.simplified.mesh, vertex_of: closed.vertex_of })
}

fn is_importance(importance: Importance, n_vertices: usize) -> bool {
    match importance {
        Importance::Even | Importance::Bending | Importance::Network(_) => true,
        Importance::Given(factors) => factors.len() == n_vertices && factors.iter().all(|&x| x > 0.0 && x.is_finite()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    use crate::mesh::{shapes, topology};
    use crate::model::Weights;
    use crate::simplify::{ClosedOptions, Options, ScoreSource, Target, simplify};

    #[test]
    fn equal_factors_change_nothing() {
        let mesh = shapes::wavy_sphere(4, 8.0);
        let even = ClosedOptions { scores: ScoreSource::Geometry, ..ClosedOptions::default() };
        let options = Options::with_closed(Target::Vertices(150), even);
        let plain = simplify(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(plain.report.scores, ScoreSource::Geometry);
        let fours = vec![4.0; mesh.positions().len()];
        let weighed = simplify_with_importance(&mesh, 150, Importance::Given(&fours), &Refinements::default()).unwrap();
        assert_eq!(weighed.mesh, plain.mesh);
        assert!(weighed.vertex_of.iter().all(|&v| (v as usize) < 150));
    }

    #[test]
    fn the_network_weighs_as_in_the_pipeline() {
        let (mesh, weights) = (shapes::wavy_sphere(4, 8.0), Weights::random(1));
        let by_network = ClosedOptions { scores: ScoreSource::Network, ..ClosedOptions::default() };
        let options = Options::with_closed(Target::Vertices(150), by_network);
        let plain = simplify(&mesh, Some(&weights), &options, &mut |_| ControlFlow::Continue(())).unwrap();
        let weighed =
            simplify_with_importance(&mesh, 150, Importance::Network(&weights), &Refinements::default()).unwrap();
        assert_eq!(weighed.mesh, plain.mesh);
    }

    #[test]
    fn every_part_changes_the_result_and_none_is_needed_for_a_closed_one() {
        let mesh = shapes::wavy_sphere(4, 8.0);
        let result = |refinements| simplify_with_importance(&mesh, 100, Importance::Even, &refinements).unwrap().mesh;
        let all = Refinements::default();
        let whole = result(all);
        let without = [Refinements { flips: false, ..all }, Refinements { fit: false, ..all }];
        for refinements in without {
            let mesh = result(refinements);
            assert_ne!(mesh, whole, "{refinements:?}");
            assert!(topology(&mesh).is_closed_manifold() && mesh.positions().len() == 100, "{refinements:?}");
        }
    }

    #[test]
    fn what_is_no_importance_is_refused() {
        let mesh = shapes::tetrahedron();
        for bad in [vec![], vec![1.0; 3], vec![1.0, 0.0, 1.0, 1.0], vec![1.0, f32::NAN, 1.0, 1.0]] {
            assert_eq!(
                simplify_with_importance(&mesh, 4, Importance::Given(&bad), &Refinements::default()),
                Err(SimplifyError::BadImportance)
            );
        }
    }
}
