//! All figures of a simplified mesh: those of the library, and among them those along the surface.

use neural_mesh::mesh::{TriMesh, topology};
use neural_mesh::metrics::{CompareOptions, Figure, ReferenceMesh, compare};

use super::figures::AlongSurface;

/// Eigenpairs of the Laplacian that the paper compares, at most.
const EIGENPAIRS: usize = 200;
/// The figure after which those along the surface stand, in every table that was ever written.
const BEFORE: &str = "curvature_error";

/// What is measured along the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AlongJudging {
    /// Eigenpairs of the Laplacian, at most; 0 leaves out LE and biharmonic distances, which cost more than all other
    /// figures. [`Judge::eigenpairs`] says how many are compared.
    pub eigenpairs: usize,
    /// Whether distances along the surface are measured.
    pub geodesics: bool,
    /// Vertex of the original from which distances along the surface are measured; by default, or where no face uses it,
    /// the one farthest from the middle of the bounding box.
    pub source: Option<u32>,
}

impl AlongJudging {
    /// Nothing.
    pub const NONE: Self = Self { eigenpairs: 0, geodesics: false, source: None };
}

impl Default for AlongJudging {
    fn default() -> Self {
        Self { eigenpairs: EIGENPAIRS, geodesics: true, source: None }
    }
}

/// An original, made ready once to judge many simplified meshes.
pub struct Judge {
    original: ReferenceMesh,
    along: AlongSurface,
}

impl Judge {
    /// Draws the samples, builds the trees, and solves for what is asked for.
    pub fn new(mesh: &TriMesh, judging: &CompareOptions, along: &AlongJudging) -> Self {
        let original = ReferenceMesh::new(mesh, judging);
        let found = topology(mesh);
        let n_vertices = found.vertices - found.unreferenced_vertices;
        Self { along: AlongSurface::new(&original.to_unit_size(mesh), along, n_vertices), original }
    }

    /// Returns how many eigenpairs are compared with a mesh that was asked to have so many vertices: as many as [`AlongJudging`]
    /// allows, at most a quarter of the vertices asked for and of the original's in use, and those that the solver found.
    pub fn eigenpairs(&self, n_asked: usize) -> usize {
        self.along.eigenpairs(n_asked)
    }

    /// Measures a simplified mesh, which was asked to have `n_asked` vertices: always the same figures in the same order.
    ///
    /// What it was asked for decides how many eigenpairs are compared, so that methods that were asked for the same are judged by
    /// the same number, also those that lost vertices.
    ///
    /// ```
    /// use neural_mesh::{mesh::shapes, metrics::CompareOptions};
    /// use neural_mesh_bench::along_surface::{AlongJudging, Judge};
    /// let judge = Judge::new(&shapes::icosphere(3), &CompareOptions::default(), &AlongJudging::default());
    /// let figures = judge.figures(&shapes::icosphere(2), 162);
    /// let error = figures.iter().find(|figure| figure.name == "geodesic_error").unwrap();
    /// assert!(error.value.unwrap() < 5.0);
    /// ```
    pub fn figures(&self, simplified: &TriMesh, n_asked: usize) -> Vec<Figure> {
        let mut figures = compare(&self.original, simplified);
        let at = figures.iter().position(|figure| figure.name == BEFORE).map_or(figures.len(), |at| at + 1);
        figures.splice(at..at, self.along.figures(&self.original.to_unit_size(simplified), n_asked));
        figures
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use neural_mesh::mesh::shapes;

    pub const ALONG: AlongJudging = AlongJudging { eigenpairs: 20, geodesics: true, source: None };

    pub fn with(original: &TriMesh, along: &AlongJudging) -> Judge {
        let mut judging = CompareOptions::default();
        judging.samples = 3000;
        Judge::new(original, &judging, along)
    }

    pub fn compared(original: &TriMesh, simplified: &TriMesh) -> Vec<Figure> {
        with(original, &ALONG).figures(simplified, simplified.positions().len())
    }

    pub fn value(figures: &[Figure], name: &str) -> Option<f64> {
        figures.iter().find(|figure| figure.name == name).unwrap().value
    }

    #[test]
    fn names_are_the_same_for_every_mesh_and_in_the_order_of_the_tables() {
        let sphere = shapes::icosphere(2);
        let names = |figures: Vec<Figure>| figures.into_iter().map(|figure| figure.name).collect::<Vec<_>>();
        let all = names(compared(&sphere, &sphere));
        let along = ["laplacian_functions", "laplacian_span", "laplacian_values", "geodesic_error", "biharmonic_error"];
        let at = all.iter().position(|name| *name == along[0]).unwrap();
        assert_eq!((all[at - 1], &all[at..at + 5], all[at + 5]), (BEFORE, &along[..], "edges_without_two_faces"));
        let points = TriMesh::new(vec![[1.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
        for odd in [TriMesh::default(), points, shapes::klein_bottle(12, 8), shapes::tetrahedra_sharing_edge()] {
            assert_eq!(names(compared(&sphere, &odd)), all);
            assert_eq!(names(compared(&odd, &sphere)), all);
            assert_eq!(names(compared(&odd, &odd)), all);
        }
        assert_eq!(names(with(&sphere, &AlongJudging::NONE).figures(&sphere, 42)), all);
    }

    #[test]
    fn figures_do_not_depend_on_the_unit() {
        let [fine, coarse] = [3, 2].map(shapes::icosphere);
        let scaled = |mesh: &TriMesh, by: f32| {
            let positions = mesh.positions().iter().map(|p| p.map(|x| by * x)).collect();
            TriMesh::new(positions, mesh.faces().to_vec()).unwrap()
        };
        let usual = compared(&fine, &coarse);
        for power in [-100, 90] {
            let by = 2f32.powi(power);
            assert_eq!(compared(&scaled(&fine, by), &scaled(&coarse, by)), usual);
        }
    }

    #[test]
    fn threads_do_not_change_a_bit() {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| compared(&shapes::bolt(40), &shapes::bolt(24)))
        };
        assert_eq!(on(1), on(3));
    }
}
