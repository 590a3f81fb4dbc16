//! A surface to be overlaid: its triangles, their neighbours, and what is made of them when it is first needed.

use std::cell::{OnceCell, RefCell};

use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;

use crate::geometry::triangle::area_normal_f64;
use crate::mesh::TriMesh;
use crate::mesh::half_edges::{NO_TWIN, twins};
use crate::spatial::NearestOnTriangles;

/// Distance beyond a plane that does not count, as a share of the edge's length.
const TOLERANCE: f64 = 1e-7;

/// A surface with the neighbours of its faces.
pub struct OverlaySurface {
    pub(super) triangles: Vec<[DVec3; 3]>,
    /// Unit normals; zero for faces without area.
    pub(super) normals: Vec<DVec3>,
    pub(super) twins: Vec<u32>,
    // Made when it is first needed.
    tree: OnceCell<NearestOnTriangles>,
    // Results at corners, which many triangles share: at the middle of a fan, all faces are equally close, and tested.
    at_corners: RefCell<FxHashMap<[u64; 3], (u32, f64)>>,
}

/// Plane through an edge, which parts what lies over its two faces.
#[derive(Clone, Copy)]
pub struct EdgePlane {
    /// Unit normal, towards the half-edge's own face.
    pub normal: DVec3,
    pub offset: f64,
    pub slack: f64,
}

impl OverlaySurface {
    pub fn new(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Self {
        let point = |v: u32| Vec3::from(positions[v as usize]).as_dvec3();
        let triangles: Vec<[DVec3; 3]> = faces.iter().map(|face| face.map(point)).collect();
        let normals = triangles.iter().map(|&corners| area_normal_f64(corners).normalize_or_zero()).collect();
        let twins = twins(positions.len(), faces);
        Self { triangles, normals, twins, tree: OnceCell::new(), at_corners: RefCell::default() }
    }

    pub fn from_mesh(mesh: &TriMesh) -> Self {
        Self::new(mesh.positions(), mesh.faces())
    }

    /// Returns the cutting plane of a half-edge.
    pub fn plane(&self, half_edge: u32) -> EdgePlane {
        let (face, corner) = (half_edge as usize / 3, half_edge as usize % 3);
        let [a, b] = [corner, (corner + 1) % 3].map(|k| self.triangles[face][k]);
        // Both sides of an edge are cut by the plane through it along the mean normal.
        let other = match self.twins[half_edge as usize] {
            NO_TWIN => DVec3::ZERO,
            twin => self.normals[twin as usize / 3],
        };
        let normal = (self.normals[face] + other).cross(b - a).normalize_or_zero();
        EdgePlane { normal, offset: normal.dot(a), slack: TOLERANCE * a.distance(b) }
    }

    /// Returns the closest face and its distance.
    pub fn nearest(&self, p: DVec3) -> (u32, f64) {
        let single = |corners: &[DVec3; 3]| corners.map(|p| p.as_vec3().to_array());
        let build = || NearestOnTriangles::new(&self.triangles.iter().map(single).collect::<Vec<_>>());
        let hit = self.tree.get_or_init(build).nearest(p);
        hit.map_or((0, f64::INFINITY), |hit| (hit.triangle, hit.distance2.sqrt()))
    }

    /// Returns the closest face and its distance, of a triangle's corners and of its centroid.
    pub fn nearest_samples(&self, triangle: &[DVec3; 3]) -> [(u32, f64); 4] {
        let [a, b, c] = triangle.map(|p| self.nearest_at_corner(p));
        [a, b, c, self.nearest(centroid(triangle))]
    }

    fn nearest_at_corner(&self, p: DVec3) -> (u32, f64) {
        *self.at_corners.borrow_mut().entry(p.to_array().map(f64::to_bits)).or_insert_with(|| self.nearest(p))
    }

    /// Returns the largest coordinate.
    pub fn reach(&self) -> f64 {
        self.triangles.as_flattened().iter().fold(0.0, |most, p| most.max(p.abs().max_element()))
    }
}

pub fn centroid([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (a + b + c) / 3.0
}

pub fn largest_distance(hits: &[(u32, f64)]) -> f64 {
    hits.iter().fold(0.0, |most, (_, distance)| most.max(*distance))
}
