//! Mesh to be drawn, with its colours and stored normals.

use glam::Vec3;

use super::camera::Camera;
use super::corner_normals::CornerNormals;
use super::scaled_mesh::ScaledMesh;
use super::shade::{Paint, Shading};
use super::surface_materials::DecodedMaterials;
use crate::mesh::TriMesh;

/// Mesh to be drawn.
#[derive(Clone, Copy, Debug)]
pub struct ShadedMesh<'a> {
    /// Surface.
    pub mesh: &'a TriMesh,
    /// Colours of the surface.
    pub materials: Option<&'a DecodedMaterials>,
    /// Stored normals; otherwise face normals are drawn.
    pub normals: Option<&'a CornerNormals>,
}

impl<'a> ShadedMesh<'a> {
    /// Takes a mesh without colours and stored normals.
    ///
    /// ```
    /// # use neural_mesh_picture as neural_mesh;
    /// use neural_mesh::{mesh::shapes, picture::ShadedMesh};
    /// assert!(ShadedMesh::bare(&shapes::icosphere(1)).materials.is_none());
    /// ```
    pub fn bare(mesh: &'a TriMesh) -> Self {
        Self { mesh, materials: None, normals: None }
    }

    pub(super) fn shading<'b>(&'b self, shape: &'b ScaledMesh, points: &'b [Vec3], camera: &'b Camera) -> Shading<'b> {
        let materials = self.materials.and_then(|materials| materials.place_on(points, shape.faces));
        Shading {
            paint: materials.map(Paint::Materials),
            normals: self.normals.and_then(|normals| normals.place_on(shape, points, camera)),
        }
    }
}

impl<'a> From<&'a TriMesh> for ShadedMesh<'a> {
    fn from(mesh: &'a TriMesh) -> Self {
        Self::bare(mesh)
    }
}
