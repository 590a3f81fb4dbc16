//! Compares a simplified mesh with its original.

mod compare_options;
mod figure;
mod mesh_figures;
mod reference_mesh;
mod surface_figures;

use crate::mesh::{TriMesh, topology};
use crate::metrics::Surface;

pub use compare_options::CompareOptions;
pub use figure::Figure;
pub use reference_mesh::ReferenceMesh;

/// Measures a simplified mesh against its original; the names and order of the figures never change.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::shapes, metrics::{CompareOptions, ReferenceMesh, compare}};
/// let mut options = CompareOptions::default();
/// options.samples = 1000;
/// let original = ReferenceMesh::new(&shapes::icosphere(3), &options);
/// let figures = compare(&original, &shapes::icosphere(2));
/// let distance = figures.iter().find(|figure| figure.name == "distance_mean").unwrap();
/// assert!(distance.value.unwrap() < 1.0 && distance.unit == "% of diagonal");
/// ```
pub fn compare(original: &ReferenceMesh, simplified: &TriMesh) -> Vec<Figure> {
    let simplified = &original.to_unit_size(simplified);
    // A different seed, so that equal surfaces are not measured at identical points.
    let surface = Surface::new(simplified, original.options.samples, original.options.seed.wrapping_add(1));
    let found = topology(simplified);
    let mut figures = Vec::new();
    figures.extend(mesh_figures::sizes(simplified));
    figures.extend(surface_figures::figures(original, simplified, &surface));
    figures.extend(mesh_figures::edges(original, simplified, &found));
    figures.extend(mesh_figures::topology(original, simplified, &surface, &found));
    figures.extend(mesh_figures::triangles(simplified));
    figures
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    const OPTIONS: CompareOptions = CompareOptions { samples: 3000, seed: 0 };

    fn compare_meshes(original: &TriMesh, simplified: &TriMesh) -> Vec<Figure> {
        compare(&ReferenceMesh::new(original, &OPTIONS), simplified)
    }

    fn value(figures: &[Figure], name: &str) -> Option<f64> {
        figures.iter().find(|figure| figure.name == name).unwrap().value
    }

    #[test]
    fn a_mesh_differs_from_itself_in_nothing() {
        let bolt = shapes::bolt(32);
        let figures = compare_meshes(&bolt, &bolt);
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
        let figures = [3, 2, 1].map(|level| compare_meshes(&sphere, &shapes::icosphere(level)));
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
        let all = names(compare_meshes(&sphere, &sphere));
        let mut unique = all.clone();
        unique.sort_unstable();
        unique.dedup();
        assert_eq!(unique.len(), all.len());
        let points = TriMesh::new(vec![[1.0; 3]; 3], vec![[0, 1, 2]]).unwrap();
        for odd in [TriMesh::default(), points, shapes::klein_bottle(12, 8), shapes::tetrahedra_sharing_edge()] {
            assert_eq!(names(compare_meshes(&sphere, &odd)), all);
            assert_eq!(names(compare_meshes(&odd, &sphere)), all);
            assert_eq!(names(compare_meshes(&odd, &odd)), all);
        }
    }

    #[test]
    fn figures_do_not_depend_on_the_unit() {
        let [fine, coarse] = [3, 2].map(shapes::icosphere);
        let scale = |mesh: &TriMesh, by: f32| shapes::place(mesh, |p| p.map(|x| by * x));
        let usual = compare_meshes(&fine, &coarse);
        for power in [-100, 90] {
            let by = 2f32.powi(power);
            assert_eq!(compare_meshes(&scale(&fine, by), &scale(&coarse, by)), usual);
        }
    }
}
