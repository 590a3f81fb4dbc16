//! A mesh as a picture shows it: its surface with the colours and the stored normals that it has.

use glam::Vec3;

use super::camera::Camera;
use super::coat::Coat;
use super::corner_normals::CornerNormals;
use super::shade::{Colours, Normals, Shading};
use super::shape::Shape;
use crate::mesh::TriMesh;

/// A mesh as a picture shows it.
#[derive(Clone, Copy, Debug)]
pub struct ShadedMesh<'a> {
    /// The surface.
    pub mesh: &'a TriMesh,
    /// Its colours; plain without them, or where they are of another mesh.
    pub coat: Option<&'a Coat>,
    /// Its stored normals; light falls by its faces without them, or where they are of another mesh.
    pub normals: Option<&'a CornerNormals>,
}

impl<'a> ShadedMesh<'a> {
    /// Takes a mesh without colours and without stored normals.
    ///
    /// ```
    /// use neural_mesh::{mesh::shapes, picture::ShadedMesh};
    /// assert!(ShadedMesh::bare(&shapes::icosphere(1)).coat.is_none());
    /// ```
    pub fn bare(mesh: &'a TriMesh) -> Self {
        Self { mesh, coat: None, normals: None }
    }

    /// Runs `draw` with what shades this mesh, whose vertices the camera sees at `points`.
    pub(super) fn with_shading<T>(
        &self,
        shape: &Shape,
        points: &[Vec3],
        camera: &Camera,
        draw: impl FnOnce(Shading) -> T,
    ) -> T {
        let coat = self.coat.and_then(|coat| coat.on(points, shape.faces));
        let colours = coat.as_ref().map(|coat| move |face, at| coat.colour(face, at));
        let blended = self.normals.and_then(|normals| normals.on(shape, points, camera));
        let normals = blended.as_ref().map(|blended| move |face, at| blended.normal(face, at));
        draw(Shading {
            colours: colours.as_ref().map(|colours| colours as &Colours),
            normals: normals.as_ref().map(|normals| normals as &Normals),
        })
    }
}

impl<'a> From<&'a TriMesh> for ShadedMesh<'a> {
    fn from(mesh: &'a TriMesh) -> Self {
        Self::bare(mesh)
    }
}
