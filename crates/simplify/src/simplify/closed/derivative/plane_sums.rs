//! Plane quadrics of the input as a function of positions.

use glam::{DMat3, DVec3};

use super::algebra::{area_normal_backward, outer, trace};
use crate::geometry::triangle::area_normal_f64;
use crate::simplify::closed::prepare::surface::{BOUNDARY_WEIGHT, PreparedSurface, least_weight};

pub(super) struct Planes {
    pub faces: Vec<[u32; 3]>,
    /// Boundaries and folds.
    lines: Vec<[u32; 2]>,
    weightless: Vec<u32>,
    support: f64,
    importance: Vec<f64>,
}

pub(super) struct PlaneSums {
    normals: Vec<DVec3>,
    pub matrices: Vec<DMat3>,
}

impl Planes {
    pub fn new(surface: &PreparedSurface, positions: &[DVec3]) -> Self {
        let lines = surface.edges_with_lines();
        let faces = surface.faces.to_vec();
        // Vertices whose weight is too small without support get it.
        let bare = Self { faces, lines, weightless: Vec::new(), support: 0.0, importance: Vec::new() };
        let weights: Vec<f64> = bare.gather(positions).matrices.iter().map(trace).collect();
        let support = least_weight(weights.iter().sum(), weights.len());
        let weightless = (0..weights.len() as u32).filter(|&v| weights[v as usize] < support).collect();
        let importance = surface.importance.iter().map(|&factor| f64::from(factor)).collect();
        Self { weightless, support, importance, ..bare }
    }

    pub fn gather(&self, positions: &[DVec3]) -> PlaneSums {
        let mut matrices = vec![DMat3::ZERO; positions.len()];
        let corners = |face: &[u32; 3]| face.map(|v| positions[v as usize]);
        let normals: Vec<DVec3> = self.faces.iter().map(|face| area_normal_f64(corners(face))).collect();
        for (face, &normal) in self.faces.iter().zip(&normals) {
            let plane = plane(normal);
            face.iter().for_each(|&v| matrices[v as usize] += plane);
        }
        for &[w, v] in &self.lines {
            let line = line(positions[w as usize] - positions[v as usize]);
            matrices[w as usize] += line;
            matrices[v as usize] += line;
        }
        self.weightless.iter().for_each(|&v| matrices[v as usize] += DMat3::IDENTITY * self.support);
        matrices.iter_mut().zip(&self.importance).for_each(|(matrix, &factor)| *matrix *= factor);
        PlaneSums { normals, matrices }
    }

    /// Converts gradients by the plane matrices to gradients by the positions, and adds them to `to_positions`.
    pub fn backward(&self, positions: &[DVec3], at: &PlaneSums, gradient: &[DMat3], to_positions: &mut [DVec3]) {
        let factor = |v: u32| self.importance.get(v as usize).copied().unwrap_or(1.0);
        let gradient = |v: u32| gradient[v as usize] * factor(v);
        for &[w, v] in &self.lines {
            let edge = positions[w as usize] - positions[v as usize];
            let to_edge = line_backward(edge, &(gradient(w) + gradient(v)));
            to_positions[w as usize] += to_edge;
            to_positions[v as usize] -= to_edge;
        }
        for (face, &normal) in self.faces.iter().zip(&at.normals) {
            let of_planes: DMat3 = face.iter().map(|&v| gradient(v)).sum();
            let to_normal = plane_backward(normal, &of_planes);
            let to_corners = area_normal_backward(face.map(|v| positions[v as usize]), to_normal);
            face.iter().zip(to_corners).for_each(|(&v, to)| to_positions[v as usize] += to);
        }
    }
}

/// Returns a face's plane quadric at each corner, `N N' / (6 |N|)` for the area normal N.
pub(super) fn plane(normal: DVec3) -> DMat3 {
    let double_area = normal.length();
    if double_area > 0.0 { outer(normal, normal) * (1.0 / (6.0 * double_area)) } else { DMat3::ZERO }
}

/// Returns the quadric of the line along a boundary edge, `e'e I - e e'`, weighted.
pub(super) fn line(edge: DVec3) -> DMat3 {
    (DMat3::IDENTITY * edge.length_squared() - outer(edge, edge)) * f64::from(BOUNDARY_WEIGHT)
}

pub(super) fn plane_backward(normal: DVec3, gradient: &DMat3) -> DVec3 {
    let double_area = normal.length();
    if double_area > 0.0 {
        let along = *gradient * normal;
        (along * 2.0 - normal * (normal.dot(along) / (double_area * double_area))) / (6.0 * double_area)
    } else {
        DVec3::ZERO
    }
}

pub(super) fn line_backward(edge: DVec3, gradient: &DMat3) -> DVec3 {
    (edge * trace(gradient) - *gradient * edge) * (2.0 * f64::from(BOUNDARY_WEIGHT))
}
