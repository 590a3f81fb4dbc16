//! Everything that is said of a simplified mesh against its original, as one flat list of named figures.
//!
//! The order and the names of the figures are fixed, so that they can be columns of a table. What a figure is made of
//! stands in the files of `metrics`; here they are put together and named.

mod figure;
mod judging;
mod on_surface;
mod original;
mod shape;

use crate::mesh::{TriMesh, topology};
use crate::metrics::Surface;

pub use figure::Figure;
pub use judging::Judging;
pub use original::Original;

/// Measures a simplified mesh against its original: always the same figures in the same order.
///
/// ```
/// use neural_mesh::{mesh::shapes, metrics::{Judging, Original, compare}};
/// let mut judging = Judging::default();
/// judging.samples = 1000;
/// let original = Original::new(&shapes::icosphere(3), &judging);
/// let figures = compare(&original, &shapes::icosphere(2));
/// let distance = figures.iter().find(|figure| figure.name == "distance_mean").unwrap();
/// assert!(distance.value.unwrap() < 1.0 && distance.unit == "% of diagonal");
/// ```
pub fn compare(original: &Original, simplified: &TriMesh) -> Vec<Figure> {
    let simplified = &original.scaled(simplified);
    // Other places than the original's, so that equal surfaces are not measured at the very same points.
    let surface = Surface::new(simplified, original.judging.samples, original.judging.seed.wrapping_add(1));
    let found = topology(simplified);
    let mut figures = Vec::new();
    figures.extend(shape::sizes(simplified));
    figures.extend(on_surface::figures(original, simplified, &surface));
    figures.extend(shape::edges(original, simplified, &found));
    figures.extend(shape::topology(original, simplified, &surface, &found));
    figures.extend(shape::triangles(simplified));
    figures
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    const JUDGING: Judging = Judging { samples: 3000, seed: 0 };

    fn compared(original: &TriMesh, simplified: &TriMesh) -> Vec<Figure> {
        compare(&Original::new(original, &JUDGING), simplified)
    }

    fn value(figures: &[Figure], name: &str) -> Option<f64> {
        figures.iter().find(|figure| figure.name == name).unwrap().value
    }

    #[test]
    fn a_mesh_differs_from_itself_in_nothing() {
        let bolt = shapes::bolt(32);
        let figures = compared(&bolt, &bolt);
        let zero = [
            "distance_max",
            "normal_error",
            "normal_error_signed",
            "normal_angle",
            "curvature_error",
            "turned_faces",
            "edges_without_two_faces",
            "open_edges",
            "area_change",
            "volume_change",
            "components_added",
            "genus_added",
        ];
        for name in zero {
            let value = value(&figures, name).unwrap();
            assert!(value.abs() < 1e-6, "{name} {value}");
        }
    }

    #[test]
    fn coarser_spheres_are_farther_in_every_respect() {
        let sphere = shapes::icosphere(4);
        let figures = [3, 2, 1].map(|level| compared(&sphere, &shapes::icosphere(level)));
        let growing = [
            "chamfer",
            "distance_mean",
            "distance_rms",
            "distance_max",
            "normal_error",
            "normal_angle",
            "curvature_error",
        ];
        for name in growing {
            let values = figures.each_ref().map(|figures| value(figures, name).unwrap());
            assert!(values.is_sorted_by(|a, b| a < b), "{name} {values:?}");
        }
    }

    #[test]
    fn names_are_unique_and_the_same_for_every_mesh() {
        let sphere = shapes::icosphere(2);
        let names = |figures: Vec<Figure>| figures.into_iter().map(|figure| figure.name).collect::<Vec<_>>();
        let all = names(compared(&sphere, &sphere));
        let mut unique = all.clone();
        unique.sort_unstable();
        unique.dedup();
        assert_eq!(unique.len(), all.len());
        let points = TriMesh::new(vec![[1.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
        for odd in [TriMesh::default(), points, shapes::klein_bottle(12, 8), shapes::tetrahedra_sharing_edge()] {
            assert_eq!(names(compared(&sphere, &odd)), all);
            assert_eq!(names(compared(&odd, &sphere)), all);
            assert_eq!(names(compared(&odd, &odd)), all);
        }
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
