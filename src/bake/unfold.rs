//! The charts of a mesh on a square of texels.

use glam::{DVec2, DVec3};
use neural_mesh_xatlas::unwrap;

use super::BakeError;
use crate::mesh::TriMesh;

/// Texels around each chart: two charts keep twice as many between them, so the first two levels of a mipmap mix none.
const PADDING: u32 = 2;
/// The diagonal that a mesh is given before it is cut: xatlas takes faces below 1e-7 of area for none.
const DIAGONAL: f64 = 100.0;

/// A mesh cut into charts and laid out.
pub(super) struct Charts {
    /// Texels a side.
    pub size: usize,
    /// Places on the square of the corners of each face, in texels from the lower left, n_faces x 3.
    pub corners: Vec<[DVec2; 3]>,
    /// Which of these belong together: corners of one vertex in one chart have one number, n_faces x 3.
    pub vertices: Vec<[u32; 3]>,
    /// Whether a face lies in a chart; those without area do not.
    pub is_laid: Vec<bool>,
    /// Number of charts.
    pub n_charts: usize,
}

impl Charts {
    /// Cuts the mesh and lays it out.
    pub fn of(mesh: &TriMesh, size: usize) -> Result<Self, BakeError> {
        let layout = |positions: &[[f32; 3]]| unwrap(positions, mesh.faces(), size as u32, PADDING);
        let has_area = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| DVec3::from(mesh.positions()[v as usize].map(f64::from)));
            (b - a).cross(c - a).length_squared() > 0.0
        };
        if !mesh.faces().iter().any(has_area) {
            return Err(BakeError::Empty);
        }
        let layout = layout(&scaled(mesh)).ok_or(BakeError::NoRoom(size))?;
        let corner = |vertex: u32| DVec2::from(layout.texels[vertex as usize].map(f64::from));
        let is_laid = |face: &[u32; 3]| face.iter().all(|&vertex| layout.charts[vertex as usize].is_some());
        Ok(Self {
            size,
            corners: layout.faces.iter().map(|face| face.map(corner)).collect(),
            is_laid: layout.faces.iter().map(is_laid).collect(),
            n_charts: layout.n_charts,
            vertices: layout.faces,
        })
    }

    /// A place in texels as texture coordinates, v upwards.
    pub fn uv(&self, at: DVec2) -> [f32; 2] {
        (at / self.size as f64).as_vec2().to_array()
    }
}

/// The positions around the middle of the mesh, of a size that xatlas is made for.
fn scaled(mesh: &TriMesh) -> Vec<[f32; 3]> {
    let all = mesh.positions().iter().map(|p| DVec3::from(p.map(f64::from)));
    let (low, high) =
        all.clone().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| (low.min(p), high.max(p)));
    let (middle, scale) = (0.5 * (low + high), DIAGONAL / (high - low).length());
    all.map(|p| ((p - middle) * scale).as_vec3().to_array()).collect()
}
