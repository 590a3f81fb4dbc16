//! The closed assembly under a given importance, for training.

use crate::mesh::TriMesh;

use super::closed::{ClosedRequest, Task, simplify_to_limit};
use super::input::Input;
use super::limits::Limit;
use super::options::{ClosedOptions, SimplifyError};
use super::progress::Progress;

/// Result of [`simplify_with_importance`].
#[derive(Clone, Debug, PartialEq)]
pub struct WeightedResult {
    /// Simplified mesh.
    pub mesh: TriMesh,
    /// Output vertex of each input vertex.
    pub vertex_of: Vec<u32>,
}

/// Simplifies `mesh` to `n_vertices` with vertices weighted by area times a positive factor each.
///
/// # Errors
/// [`SimplifyError::BadImportance`] if factors are not positive or not one per vertex, or a vertex is on no face;
/// [`SimplifyError::Overflow`].
///
/// ```
/// # use neural_mesh_simplify as neural_mesh;
/// use neural_mesh::{mesh::shapes, simplify::simplify_with_importance};
/// let sphere = shapes::icosphere(4);
/// let north: Vec<f32> = sphere.positions().iter().map(|p| if p[2] > 0.0 { 16.0 } else { 1.0 }).collect();
/// let result = simplify_with_importance(&sphere, 200, &north).unwrap();
/// let simplified = result.mesh;
/// let n_north = simplified.positions().iter().filter(|p| p[2] > 0.0).count();
/// assert!(simplified.positions().len() == 200 && n_north > 110);
/// ```
pub fn simplify_with_importance(
    mesh: &TriMesh,
    n_vertices: usize,
    factors: &[f32],
) -> Result<WeightedResult, SimplifyError> {
    let n = mesh.positions().len();
    let mut used = vec![false; n];
    mesh.faces().as_flattened().iter().for_each(|&v| used[v as usize] = true);
    // Unused vertices would have an importance but no area.
    if n == 0 || !is_importance(factors, n) || used.contains(&false) {
        return Err(SimplifyError::BadImportance);
    }
    let limit = Limit::from_vertices(n_vertices.max(1));
    let options = ClosedOptions { prune: false, ..ClosedOptions::default() };
    let input = Input { importance: factors, ..Input::bare(mesh) };
    let request = ClosedRequest::new(Task::new(input, &options));
    let closed = simplify_to_limit(&request, limit, Progress::SILENT)?;
    Ok(WeightedResult { mesh: closed.simplified.mesh, vertex_of: closed.vertex_of })
}

fn is_importance(factors: &[f32], n_vertices: usize) -> bool {
    factors.len() == n_vertices && factors.iter().all(|&x| x > 0.0 && x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ops::ControlFlow;

    use crate::mesh::shapes;
    use crate::simplify::{ClosedOptions, Options, ScoreSource, Size, simplify};

    #[test]
    fn equal_factors_change_nothing() {
        let mesh = shapes::wavy_sphere(4, 8.0);
        let even = ClosedOptions { scores: ScoreSource::Geometry, ..ClosedOptions::default() };
        let options = Options::with_closed(Size::Vertices(150), even);
        let plain = simplify(&mesh, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(plain.report.scores, ScoreSource::Geometry);
        let fours = vec![4.0; mesh.positions().len()];
        let weighed = simplify_with_importance(&mesh, 150, &fours).unwrap();
        assert_eq!(weighed.mesh, plain.mesh);
        assert!(weighed.vertex_of.iter().all(|&v| (v as usize) < 150));
    }

    #[test]
    fn what_is_no_importance_is_refused() {
        let mesh = shapes::tetrahedron();
        for bad in [vec![], vec![1.0; 3], vec![1.0, 0.0, 1.0, 1.0], vec![1.0, f32::NAN, 1.0, 1.0]] {
            assert_eq!(simplify_with_importance(&mesh, 4, &bad), Err(SimplifyError::BadImportance));
        }
    }
}
