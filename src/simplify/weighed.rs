//! The closed assembly under a given importance of the vertices: for learning which importance is best.

use std::ops::ControlFlow;

use crate::mesh::{Frame, TriMesh};

use super::closed::{Importance, Limit, Request, simplify_closed};
use super::{OVERSAMPLE, SimplifyError};

/// What an importance leads to.
#[derive(Clone, Debug, PartialEq)]
pub struct Weighed {
    /// The lighter mesh.
    pub mesh: TriMesh,
    /// For each input vertex the output vertex that stands for it, n_input.
    pub vertex_of: Vec<u32>,
}

/// Simplifies `mesh` to `n_vertices` where vertex v counts `importance[v]` times its area.
///
/// # Shapes
/// - `importance`: n_input positive factors; only their ratios matter
///
/// # Errors
/// [`SimplifyError::BadImportance`] where the factors are none, or the mesh has vertices that no face uses;
/// [`SimplifyError::Overflow`] as in [`simplify`](super::simplify).
///
/// ```
/// use neural_mesh::{mesh::shapes, simplify::simplify_weighed};
/// let sphere = shapes::icosphere(4);
/// let north: Vec<f32> = sphere.positions().iter().map(|p| if p[2] > 0.0 { 16.0 } else { 1.0 }).collect();
/// let lighter = simplify_weighed(&sphere, 200, &north, 1).unwrap().mesh;
/// let n_north = lighter.positions().iter().filter(|p| p[2] > 0.0).count();
/// assert!(lighter.positions().len() == 200 && n_north > 110);
/// ```
pub fn simplify_weighed(
    mesh: &TriMesh,
    n_vertices: usize,
    importance: &[f32],
    seed: u64,
) -> Result<Weighed, SimplifyError> {
    let n = mesh.positions().len();
    let mut used = vec![false; n];
    mesh.faces().as_flattened().iter().for_each(|&v| used[v as usize] = true);
    let is_factor = |&x: &f32| x > 0.0 && x.is_finite();
    if n == 0 || importance.len() != n || !importance.iter().all(is_factor) || used.contains(&false) {
        return Err(SimplifyError::BadImportance);
    }
    let request = Request {
        limit: Limit { vertices: n_vertices.max(1), faces: usize::MAX },
        oversample: OVERSAMPLE,
        importance: Importance::Given(importance),
        seed,
        frame: Frame::default(),
        differentiable: false,
    };
    let closed = simplify_closed(mesh, &request, &mut |_| ControlFlow::Continue(()))?;
    let mut vertex_of = closed.vertex_of;
    vertex_of.truncate(n);
    Ok(Weighed { mesh: closed.mesh, vertex_of })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::simplify::{Options, ScoreSource, Target, simplify};

    #[test]
    fn equal_factors_change_nothing() {
        let mesh = shapes::wavy_sphere(4, 8.0);
        let options = Options { seed: 3, ..Options::new(Target::Vertices(150)) };
        let plain = simplify(&mesh, None, &options, &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(plain.report.scores, ScoreSource::Geometry);
        let weighed = simplify_weighed(&mesh, 150, &vec![4.0; mesh.positions().len()], 3).unwrap();
        assert_eq!(weighed.mesh, plain.mesh);
        assert!(weighed.vertex_of.iter().all(|&v| (v as usize) < 150));
    }

    #[test]
    fn what_is_no_importance_is_refused() {
        let mesh = shapes::tetrahedron();
        for bad in [vec![], vec![1.0; 3], vec![1.0, 0.0, 1.0, 1.0], vec![1.0, f32::NAN, 1.0, 1.0]] {
            assert_eq!(simplify_weighed(&mesh, 4, &bad, 0), Err(SimplifyError::BadImportance));
        }
    }
}
