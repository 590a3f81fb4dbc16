//! The original beneath some vertices of the result: where it is nearest to a point, which way it looks there, and points
//! of it.
//!
//! The regions of the vertices say which part of the original that is. Distances are to its faces: on parts with long faces
//! the next vertex of the original is often far away, and its normal that of another side.

use glam::Vec3;
use rustc_hash::FxHashMap;

use crate::geometry::triangle::nearest_point;

use super::nearest::{normal_at, sides};
use super::prepare::surface::Surface;

/// Points of the original that stand for the region of a vertex, at most.
const POINTS: usize = 8;

/// Regions of the original by the vertices of the result that they became.
pub(super) struct Beneath {
    regions: FxHashMap<u32, Region>,
}

/// The original in one region.
#[derive(Default)]
struct Region {
    /// Some of its vertices and of the centroids of its faces.
    points: Vec<Vec3>,
    /// The faces with a corner in it that have an area.
    faces: Vec<Face>,
}

/// A face of the original.
struct Face {
    corners: [Vec3; 3],
    /// Not of unit length.
    normal: Vec3,
    /// The least and the largest coordinates.
    bounds: [Vec3; 2],
}

/// The nearest point of the original.
#[derive(Clone, Copy)]
pub(super) struct Foot {
    /// Where it lies.
    pub point: Vec3,
    /// The normal of its face, not of unit length.
    pub normal: Vec3,
    /// How far away it is.
    pub distance: f32,
}

impl Beneath {
    /// The regions of the wanted vertices of the result; `vertex_of` names the output vertex of each input vertex.
    pub fn new(surface: &Surface, vertex_of: &[u32], wanted: &[bool]) -> Self {
        let mut regions: FxHashMap<u32, Region> = FxHashMap::default();
        for (v, &output) in (0u32..).zip(vertex_of).filter(|(_, output)| wanted[**output as usize]) {
            let region = regions.entry(output).or_default();
            region.points.push(surface.positions[v as usize]);
            // A face is noted once for each region, at the first of its corners there.
            let is_first = |w: &u32| *w > v || vertex_of[*w as usize] != output;
            for [p, q] in sides(surface, v).filter(|side| side.iter().all(is_first)) {
                let corners = [v, p, q].map(|w| surface.positions[w as usize]);
                let face = Face::new(corners, normal_at(surface, v, corners));
                region.points.push(face.centroid());
                // One without an area looks nowhere, and its edges are those of others.
                region.faces.extend(Some(face).filter(|face| face.normal != Vec3::ZERO));
            }
        }
        regions.values_mut().for_each(Region::thin_out);
        Self { regions }
    }

    /// Whether the region of a vertex is known.
    pub fn has(&self, vertex: u32) -> bool {
        self.regions.contains_key(&vertex)
    }

    /// Points of the original in the regions of these vertices.
    pub fn points(&self, vertices: &[u32]) -> impl Iterator<Item = Vec3> {
        self.regions_of(vertices).flat_map(|region| &region.points).copied()
    }

    /// The point of the original in the regions of these vertices that lies nearest to `point`.
    pub fn foot(&self, point: Vec3, vertices: &[u32]) -> Foot {
        let mut foot = Foot { point, normal: Vec3::ZERO, distance: f32::INFINITY };
        for face in self.regions_of(vertices).flat_map(|region| &region.faces) {
            if face.may_be_within(foot.distance, point) {
                let there = nearest_point(point, face.corners);
                let distance = there.distance(point);
                if distance < foot.distance {
                    foot = Foot { point: there, normal: face.normal, distance };
                }
            }
        }
        foot
    }

    fn regions_of(&self, vertices: &[u32]) -> impl Iterator<Item = &Region> {
        vertices.iter().filter_map(|v| self.regions.get(v))
    }
}

impl Region {
    /// Leaves no more than [`POINTS`] points, evenly.
    fn thin_out(&mut self) {
        let step = self.points.len().div_ceil(POINTS).max(1);
        self.points = self.points.iter().copied().step_by(step).collect();
    }
}

impl Face {
    fn new(corners: [Vec3; 3], normal: Vec3) -> Self {
        let [a, b, c] = corners;
        Self { corners, normal, bounds: [a.min(b).min(c), a.max(b).max(c)] }
    }

    fn centroid(&self) -> Vec3 {
        (self.corners[0] + self.corners[1] + self.corners[2]) / 3.0
    }

    /// Whether box and plane let the face be nearer to a point than that.
    fn may_be_within(&self, distance: f32, point: Vec3) -> bool {
        let [low, high] = self.bounds;
        let outside = (low - point).max(point - high).max(Vec3::ZERO).length_squared();
        let height = self.normal.dot(point - self.corners[0]);
        let squared = distance * distance;
        // Rounding may add a little to the height.
        outside < squared && height * height <= squared * 1.001 * self.normal.length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn the_foot_is_the_nearest_point_of_all_faces_in_the_regions() {
        let mesh = shapes::wavy_sphere(3, 4.0);
        let surface = Surface::new(&mesh);
        let n = surface.n_vertices();
        let vertex_of: Vec<u32> = (0..n as u32).map(|v| v % 7).collect();
        let beneath = Beneath::new(&surface, &vertex_of, &[true, true, false, true, false, false, false]);
        assert!(beneath.has(3) && !beneath.has(2));
        let near = [0, 3];
        let corners = |face: &[u32; 3]| face.map(|v| surface.positions[v as usize]);
        for v in (0..n).step_by(41) {
            let point = surface.positions[v] * 1.03;
            let inside = |face: &&[u32; 3]| face.iter().any(|&v| near.contains(&vertex_of[v as usize]));
            let to = |face: &[u32; 3]| nearest_point(point, corners(face)).distance(point);
            let naive = surface.faces.iter().filter(inside).map(to).fold(f32::INFINITY, f32::min);
            let foot = beneath.foot(point, &near);
            assert!((foot.distance - naive).abs() < 1e-5 * naive && foot.point.distance(point) == foot.distance);
            assert!(foot.normal.dot(point) > 0.0);
        }
        let points: Vec<Vec3> = beneath.points(&near).collect();
        assert!(!points.is_empty() && points.len() <= 2 * POINTS);
    }
}
