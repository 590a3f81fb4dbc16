//! The one pass by itself, from any samples: for measuring ways to sample against each other.

use crate::mesh::TriMesh;

use super::{Samples, closed};

/// The quotient mesh of the regions of `samples`, its vertices placed, with or without sweeps over the regions'
/// borders; one vertex per sample, and a few more where the surface would not be a manifold otherwise.
///
/// `None` where a sample is no vertex of the mesh or appears twice, or the mesh has vertices that no face uses.
///
/// ```
/// use neural_mesh::simplify::{Samples, one_pass};
/// let sphere = neural_mesh::mesh::shapes::icosphere(4);
/// let lighter = one_pass(&sphere, &Samples::Darts { n: 100, seed: 1 }, true).unwrap();
/// assert!((100..130).contains(&lighter.positions().len()));
/// ```
pub fn one_pass(mesh: &TriMesh, samples: &Samples, with_sweeps: bool) -> Option<TriMesh> {
    let mut free = vec![false; mesh.positions().len()];
    mesh.faces().as_flattened().iter().for_each(|&v| free[v as usize] = true);
    let all_used = free.iter().all(|&used| used);
    let distinct = match samples {
        Samples::Darts { .. } => true,
        Samples::Vertices(list) => {
            list.iter().all(|&v| free.get_mut(v as usize).is_some_and(|free| std::mem::replace(free, false)))
        }
    };
    if all_used && distinct && !mesh.faces().is_empty() { closed::one_pass(mesh, samples, with_sweeps) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, topology};

    #[test]
    fn any_samples_of_a_closed_surface_give_a_closed_surface() {
        let mesh = shapes::chain_of_tori(3);
        let n = mesh.positions().len() as u32;
        let spread: Vec<u32> = (0..n).step_by(9).collect();
        for samples in [Samples::Vertices(&[0]), Samples::Vertices(&spread), Samples::Darts { n: 60, seed: 4 }] {
            for with_sweeps in [false, true] {
                let lighter = topology(&one_pass(&mesh, &samples, with_sweeps).unwrap());
                assert!(lighter.is_closed_manifold(), "{samples:?}");
                assert_eq!((lighter.components, lighter.genus), (3, topology(&mesh).genus));
            }
        }
    }

    #[test]
    fn samples_that_are_none_are_refused() {
        let mesh = shapes::tetrahedron();
        assert!(one_pass(&mesh, &Samples::Vertices(&[4]), true).is_none());
        assert!(one_pass(&mesh, &Samples::Vertices(&[1, 1]), true).is_none());
    }
}
