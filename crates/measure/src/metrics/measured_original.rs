//! A mesh with the tree of its faces, for distances from many others.

use std::sync::OnceLock;

use super::certified_distance::certified_distance_by_trees;
use super::quick_distance::{FixedPoints, face_tree, largest_beyond_by_trees, quick_distance_by_trees};
use super::{CertifiedDistance, DistanceTolerance, QuickDistance};
use crate::mesh::TriMesh;
use crate::spatial::FaceTree;

/// An original whose tree is built once; each distance is that of the function of the same name.
///
/// ```
/// # use neural_mesh_measure as neural_mesh;
/// use neural_mesh::{mesh::shapes, metrics::{MeasuredOriginal, quick_distance}};
/// let (fine, coarse) = (shapes::icosphere(3), shapes::icosphere(1));
/// let original = MeasuredOriginal::new(&fine);
/// assert_eq!(original.quick_distance(&coarse, 1000, 0), quick_distance(&fine, &coarse, 1000, 0));
/// ```
pub struct MeasuredOriginal<'a> {
    mesh: &'a TriMesh,
    tree: FaceTree<'a>,
    /// Its points, from the first time that they are needed.
    points: OnceLock<FixedPoints>,
}

impl<'a> MeasuredOriginal<'a> {
    /// Builds the tree.
    pub fn new(mesh: &'a TriMesh) -> Self {
        Self { mesh, tree: face_tree(mesh), points: OnceLock::new() }
    }

    /// Returns the original.
    pub fn mesh(&self) -> &'a TriMesh {
        self.mesh
    }

    /// Measures the distance with `n_samples` per surface.
    pub fn quick_distance(&self, simplified: &TriMesh, n_samples: usize, seed: u64) -> Option<QuickDistance> {
        quick_distance_by_trees([self.mesh, simplified], [&self.tree, &face_tree(simplified)], n_samples, seed)
    }

    /// Returns the largest distance found from vertices of both meshes and `n_samples` of the simplified one, or 0 if none is
    /// beyond `least`.
    ///
    /// ```
    /// # use neural_mesh_measure as neural_mesh;
    /// use neural_mesh::{mesh::shapes, metrics::MeasuredOriginal};
    /// let (fine, coarse) = (shapes::icosphere(3), shapes::icosphere(1));
    /// let original = MeasuredOriginal::new(&fine);
    /// let found = original.largest_beyond(&coarse, 1000, 0.01);
    /// assert!(found > 0.05 && original.largest_beyond(&coarse, 1000, 2.0 * found) == 0.0);
    /// ```
    pub fn largest_beyond(&self, simplified: &TriMesh, n_samples: usize, least: f64) -> f64 {
        if self.mesh.faces().is_empty() || simplified.faces().is_empty() {
            return 0.0;
        }
        let points = self.points.get_or_init(|| FixedPoints::new(self.mesh, self.tree.order()));
        let (meshes, trees) = ([self.mesh, simplified], [&self.tree, &face_tree(simplified)]);
        largest_beyond_by_trees(meshes, trees, points, (n_samples, least))
    }

    /// Bounds the distance, of which `lower` is known, by at most `most` visits per direction; also returns their number.
    pub fn certified_distance(
        &self,
        simplified: &TriMesh,
        (tolerance, lower): (&DistanceTolerance, f64),
        most: u64,
    ) -> (Option<CertifiedDistance>, u64) {
        let trees = [&self.tree, &face_tree(simplified)];
        certified_distance_by_trees([self.mesh, simplified], trees, (tolerance, lower), most)
    }
}
