//! Charts of a mesh on a square of texels.

use glam::{DVec2, Vec3};
use neural_mesh_xatlas::unwrap;

use super::BakeError;
use crate::geometry::extent;
use crate::geometry::triangle::corners_f64;
use crate::mesh::TriMesh;

/// Free texels around each chart, so that the first two mipmap levels do not mix charts.
const PADDING: u32 = 2;
/// Diagonal to which a mesh is scaled; xatlas ignores faces with less area than 1e-7.
const DIAGONAL: f64 = 100.0;

pub(super) struct Charts {
    pub size: usize,
    // Corners of each face, in texels from the lower left, n_faces x 3.
    pub corners: Vec<[DVec2; 3]>,
    // Numbers of the corners: one for each vertex and chart, n_faces x 3.
    pub vertices: Vec<[u32; 3]>,
    // False for faces without area.
    pub is_in_chart: Vec<bool>,
    pub n_charts: usize,
}

impl Charts {
    pub fn unfold(mesh: &TriMesh, size: usize) -> Result<Self, BakeError> {
        let layout = |positions: &[[f32; 3]]| unwrap(positions, mesh.faces(), size as u32, PADDING);
        let has_area = |face: &[u32; 3]| {
            let [a, b, c] = corners_f64(face.map(|v| mesh.positions()[v as usize]));
            (b - a).cross(c - a).length_squared() > 0.0
        };
        // Without any area, xatlas returns no chart.
        if !mesh.faces().iter().any(has_area) {
            return Err(BakeError::Empty);
        }
        let layout = layout(&scale_for_xatlas(mesh)).ok_or(BakeError::NoRoom(size))?;
        let corner = |vertex: u32| DVec2::from(layout.texels[vertex as usize].map(f64::from));
        let is_in_chart = |face: &[u32; 3]| face.iter().all(|&vertex| layout.charts[vertex as usize].is_some());
        Ok(Self {
            size,
            corners: layout.faces.iter().map(|face| face.map(corner)).collect(),
            is_in_chart: layout.faces.iter().map(is_in_chart).collect(),
            n_charts: layout.n_charts,
            vertices: layout.faces,
        })
    }

    pub fn uv(&self, at: DVec2) -> [f32; 2] {
        (at / self.size as f64).as_vec2().to_array()
    }
}

fn scale_for_xatlas(mesh: &TriMesh) -> Vec<[f32; 3]> {
    let all = mesh.positions().iter().map(|p| Vec3::from(*p).as_dvec3());
    let (low, high) = extent(all.clone());
    let (middle, scale) = (0.5 * (low + high), DIAGONAL / (high - low).length());
    all.map(|p| ((p - middle) * scale).as_vec3().to_array()).collect()
}
