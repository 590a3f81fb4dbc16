//! A mesh with the tree of its faces, for distances from many others.

use super::certified_distance::certified_distance_by_trees;
use super::quick_distance::{face_tree, quick_distance_by_trees};
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
}

impl<'a> MeasuredOriginal<'a> {
    /// Builds the tree.
    pub fn new(mesh: &'a TriMesh) -> Self {
        Self { mesh, tree: face_tree(mesh) }
    }

    /// Returns the original.
    pub fn mesh(&self) -> &'a TriMesh {
        self.mesh
    }

    /// Measures the distance with `n_samples` per surface.
    pub fn quick_distance(&self, simplified: &TriMesh, n_samples: usize, seed: u64) -> Option<QuickDistance> {
        quick_distance_by_trees([self.mesh, simplified], [&self.tree, &face_tree(simplified)], n_samples, seed)
    }

    /// Bounds the distance by at most `most` visits per direction; also returns the number of visits.
    pub fn certified_distance(
        &self,
        simplified: &TriMesh,
        tolerance: &DistanceTolerance,
        most: u64,
    ) -> (Option<CertifiedDistance>, u64) {
        certified_distance_by_trees([self.mesh, simplified], [&self.tree, &face_tree(simplified)], tolerance, most)
    }
}
