//! A mesh prepared for measuring.

use glam::{DVec3, Vec3};

use crate::geometry::triangle::{area_normal_f64, corners_f64};
use crate::mesh::TriMesh;
use crate::mesh::surface_samples::surface_samples;
use crate::spatial::NearestOnTriangles;

/// A surface with samples, normals and a search tree.
pub struct Surface {
    /// Samples spread by area, n_samples.
    pub samples: Vec<DVec3>,
    /// Vertices used by faces.
    pub vertices: Vec<DVec3>,
    /// Face of each sample, n_samples.
    pub sample_faces: Vec<u32>,
    /// Unit normal of each face, n_faces; zero without area.
    pub normals: Vec<DVec3>,
    /// Tree for closest points; triangles are faces.
    pub nearest: NearestOnTriangles,
    /// Area in squared units.
    pub area: f64,
    /// Diagonal of the bounding box.
    pub diagonal: f64,
}

impl Surface {
    /// Draws the samples and builds the tree.
    pub fn new(mesh: &TriMesh, n_samples: usize, seed: u64) -> Self {
        let samples = surface_samples(mesh, n_samples, seed);
        Self {
            samples: samples.iter().map(|sample| sample.point(mesh)).collect(),
            vertices: used_vertices(mesh),
            sample_faces: samples.iter().map(|sample| sample.face).collect(),
            normals: triangles(mesh).into_iter().map(|corners| normal(corners).normalize_or_zero()).collect(),
            nearest: NearestOnTriangles::new(&triangles(mesh)),
            area: triangles(mesh).into_iter().map(|corners| 0.5 * normal(corners).length()).sum(),
            diagonal: diagonal(mesh),
        }
    }
}

pub(super) fn triangles(mesh: &TriMesh) -> Vec<[[f32; 3]; 3]> {
    mesh.faces().iter().map(|face| face.map(|v| mesh.positions()[v as usize])).collect()
}

fn normal(corners: [[f32; 3]; 3]) -> DVec3 {
    area_normal_f64(corners_f64(corners))
}

fn used_vertices(mesh: &TriMesh) -> Vec<DVec3> {
    let mut is_used = vec![false; mesh.positions().len()];
    mesh.faces().as_flattened().iter().for_each(|&v| is_used[v as usize] = true);
    let used = mesh.positions().iter().zip(is_used).filter(|(_, is_used)| *is_used);
    used.map(|(p, _)| Vec3::from(*p).as_dvec3()).collect()
}

fn diagonal(mesh: &TriMesh) -> f64 {
    let corners =
        || mesh.faces().iter().flatten().map(|&v| DVec3::from_array(mesh.positions()[v as usize].map(f64::from)));
    let low = corners().reduce(DVec3::min).unwrap_or_default();
    let high = corners().reduce(DVec3::max).unwrap_or_default();
    low.distance(high)
}
