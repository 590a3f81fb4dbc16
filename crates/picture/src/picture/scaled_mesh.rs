//! Meshes in the unit ball.

use glam::{DVec3, Vec3};

use crate::geometry::triangle::area_normal;
use crate::mesh::TriMesh;
use crate::parallel;

pub struct ScaledMesh<'a> {
    // Index among the meshes of the picture.
    pub number: usize,
    // Vertex positions: n_vertices.
    pub points: Vec<Vec3>,
    // Vertex indices of the faces, n_faces x 3.
    pub faces: &'a [[u32; 3]],
}

impl ScaledMesh<'_> {
    /// Returns the normal of each face, with twice its area as length, n_faces.
    pub fn area_normals(&self) -> Vec<Vec3> {
        let normal = |face: usize| area_normal(self.faces[face].map(|v| self.points[v as usize]));
        parallel::map(self.faces.len(), 1024, normal)
    }
}

pub struct PictureFrame {
    middle: DVec3,
    scale: f64,
}

impl PictureFrame {
    pub fn from_meshes(meshes: &[&TriMesh]) -> Self {
        let all = || meshes.iter().flat_map(|mesh| mesh.positions()).map(|&p| Vec3::from(p).as_dvec3());
        let low = all().reduce(DVec3::min).unwrap_or_default();
        let high = all().reduce(DVec3::max).unwrap_or_default();
        let radius = 0.5 * (high - low).length();
        Self { middle: 0.5 * (low + high), scale: if radius > 0.0 { 1.0 / radius } else { 0.0 } }
    }

    pub fn place(&self, point: DVec3) -> Vec3 {
        ((point - self.middle) * self.scale).as_vec3()
    }

    pub fn shapes<'a>(&self, meshes: &[&'a TriMesh]) -> Vec<ScaledMesh<'a>> {
        let shape = |(number, mesh): (usize, &&'a TriMesh)| {
            let place = |p: &[f32; 3]| self.place(Vec3::from(*p).as_dvec3());
            ScaledMesh { number, points: mesh.positions().iter().map(place).collect(), faces: mesh.faces() }
        };
        meshes.iter().enumerate().map(shape).collect()
    }
}

pub fn scale_meshes<'a>(meshes: &[&'a TriMesh]) -> Vec<ScaledMesh<'a>> {
    PictureFrame::from_meshes(meshes).shapes(meshes)
}
