//! All error figures of a simplified mesh.

use neural_mesh::mesh::{TriMesh, topology};
use neural_mesh::metrics::{CompareOptions, Figure, ReferenceMesh, compare};

use super::figures::IntrinsicFigures;

/// Largest number of eigenpairs that the paper compares.
pub const EIGENPAIRS: usize = 200;

// Name of the figure after which those along the surface are inserted.
const BEFORE: &str = "curvature_error";

/// An original, prepared to judge simplified meshes.
pub struct Judge {
    original: ReferenceMesh,
    along: IntrinsicFigures,
}

impl Judge {
    /// Prepares an original for comparisons, those along the surface by at most `n_pairs` eigenpairs.
    pub fn new(mesh: &TriMesh, options: &CompareOptions, n_pairs: Option<usize>) -> Self {
        let original = ReferenceMesh::new(mesh, options);
        let found = topology(mesh);
        let n_vertices = found.vertices - found.unreferenced_vertices;
        Self { along: IntrinsicFigures::new(&original.to_unit_size(mesh), n_pairs, n_vertices), original }
    }

    /// Measures a simplified mesh made for a target of `n_target` vertices; figures come in a fixed order.
    pub fn figures(&self, simplified: &TriMesh, n_target: usize) -> Vec<Figure> {
        // The requested vertices set the number of eigenpairs, so that a result with fewer vertices is not compared by
        // fewer.
        let mut figures = compare(&self.original, simplified);
        let at = figures.iter().position(|figure| figure.name == BEFORE).map_or(figures.len(), |at| at + 1);
        figures.splice(at..at, self.along.figures(&self.original.to_unit_size(simplified), n_target));
        figures
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::test_values::run_on_threads;
    use neural_mesh::mesh::shapes;

    fn judge_of(original: &TriMesh, n_pairs: Option<usize>) -> Judge {
        let mut options = CompareOptions::default();
        options.samples = 3000;
        Judge::new(original, &options, n_pairs)
    }

    fn compare_meshes(original: &TriMesh, simplified: &TriMesh) -> Vec<Figure> {
        judge_of(original, Some(20)).figures(simplified, simplified.positions().len())
    }

    fn value(figures: &[Figure], name: &str) -> Option<f64> {
        figures.iter().find(|figure| figure.name == name).unwrap().value
    }

    #[test]
    fn names_are_the_same_for_every_mesh_and_in_the_order_of_the_tables() {
        let sphere = shapes::icosphere(2);
        let names = |figures: Vec<Figure>| figures.into_iter().map(|figure| figure.name).collect::<Vec<_>>();
        let all = names(compare_meshes(&sphere, &sphere));
        let along = ["laplacian_functions", "geodesic_error", "biharmonic_error"];
        let at = all.iter().position(|name| *name == along[0]).unwrap();
        assert_eq!((all[at - 1], &all[at..at + 3], all[at + 3]), (BEFORE, &along[..], "edges_without_two_faces"));
        let points = TriMesh::new(vec![[1.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
        for odd in [TriMesh::default(), points, shapes::klein_bottle(12, 8), shapes::tetrahedra_sharing_edge()] {
            for (original, simplified) in [(&sphere, &odd), (&odd, &sphere), (&odd, &odd)] {
                assert_eq!(names(compare_meshes(original, simplified)), all);
            }
        }
        assert_eq!(names(judge_of(&sphere, None).figures(&sphere, 42)), all);
    }

    #[test]
    fn figures_do_not_depend_on_the_unit() {
        let [fine, coarse] = [3, 2].map(shapes::icosphere);
        let scaled = |mesh: &TriMesh, by: f32| shapes::place(mesh, |p| p.map(|x| by * x));
        let usual = compare_meshes(&fine, &coarse);
        for power in [-100, 90] {
            let by = 2f32.powi(power);
            assert_eq!(compare_meshes(&scaled(&fine, by), &scaled(&coarse, by)), usual);
        }
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let on_threads = |n| run_on_threads(n, || compare_meshes(&shapes::bolt(40), &shapes::bolt(24)));
        assert_eq!(on_threads(1), on_threads(3));
    }

    const NAMES: [&str; 3] = ["laplacian_functions", "geodesic_error", "biharmonic_error"];

    #[test]
    fn a_mesh_differs_from_itself_in_nothing() {
        let bolt = shapes::bolt(32);
        let figures = compare_meshes(&bolt, &bolt);
        for name in NAMES {
            let value = value(&figures, name).unwrap();
            assert!(value.abs() < 1e-6, "{name} {value}");
        }
    }

    #[test]
    fn coarser_spheres_are_farther() {
        let sphere = shapes::icosphere(4);
        let figures = [3, 2, 1].map(|level| compare_meshes(&sphere, &shapes::icosphere(level)));
        for name in NAMES {
            let values = figures.each_ref().map(|figures| value(figures, name).unwrap());
            assert!(values.is_sorted_by(|a, b| a < b), "{name} {values:?}");
        }
    }

    // A result that lost half of the sphere is still compared by the number of eigenfunctions of a whole result.
    #[test]
    fn lost_vertices_do_not_make_the_spectrum_better() {
        let sphere = shapes::icosphere(4);
        let judge = judge_of(&sphere, Some(100));
        let coarse = shapes::icosphere(2);
        let few = |n: usize| TriMesh::new(coarse.positions().to_vec(), coarse.faces()[..n].to_vec()).unwrap();
        let errors = [320, 160, 20, 1].map(|n| {
            let figures = judge.figures(&few(n), coarse.positions().len());
            value(&figures, "laplacian_functions").unwrap()
        });
        assert!(errors[..3].is_sorted_by(|a, b| a < b), "{errors:?}");
        // A single face has three vertices, so only three of the 40 eigenfunctions.
        assert!(errors[3] > 1.8, "{errors:?}");
        assert_eq!((judge.along.n_pairs(162), judge.along.n_pairs(100_000)), (40, 100));
    }
}
