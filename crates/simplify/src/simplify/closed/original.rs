//! The input of the closed assembly, with searches for closest points.
//!
//! A search starts from the region of an output vertex, the input vertices merged into it. So no search tree is needed.

use std::borrow::Cow;

use glam::Vec3;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::geometry::nearest_on_triangle::nearest_weights_f64;
use crate::geometry::triangle::{area_normal, nearest_point};
use crate::mesh::{Attributes, Role, TriMesh, sides};

use super::faces_around::FacesAround;
use super::pins::Pins;
use super::prepare::feature_edges::FeatureEdges;
use super::prepare::surface::PreparedSurface;

// Sample points per region in foldover repair. Nineteen meshes: 4 or 16 change the largest distance by 0.7 %.
const POINTS_PER_REGION: usize = 8;
/// Largest squared distance, over the smallest so far, at which the search visits a face's neighbours.
// Texture errors are 1.3 % larger at 1, 0.2 % smaller at 3.
const SEARCH_SLACK: f32 = 1.5;
/// Largest number of faces whose neighbours the search visits.
// Each step scans all visited faces.
const MOST_STEPS: usize = 256;
const NO_FACE: u32 = u32::MAX;

pub struct Original<'a> {
    pub mesh: &'a TriMesh,
    pub surface: PreparedSurface<'a>,
    pub features: FeatureEdges,
    pub pins: Pins,
    /// Attributes to carry; normals follow the faces that the surface winds the other way than the mesh.
    pub attributes: Option<Cow<'a, Attributes>>,
}

impl<'a> Original<'a> {
    #[cfg(test)]
    pub fn bare(mesh: &'a TriMesh) -> Self {
        let (features, pins) = (FeatureEdges::default(), Pins::default());
        let surface = PreparedSurface::new(mesh, crate::mesh::pulse::Pulse::NONE);
        Self { mesh, surface, features, pins, attributes: None }
    }

    /// Finds the nearest surface vertex in the region of each wanted output vertex.
    pub fn nearest_in_regions(&self, positions: &[Vec3], vertex_of: &[u32], wanted: &[bool]) -> Vec<u32> {
        let mut best = vec![(f32::INFINITY, 0); positions.len()];
        // One pass over all vertices: each competes for the output vertex of its region.
        for numbers in self.surface.pulse.ranges(0..vertex_of.len()) {
            let outputs = numbers.clone().zip(&vertex_of[numbers]);
            for (v, &output) in outputs.filter(|(_, output)| wanted[**output as usize]) {
                let distance = self.surface.positions[v].distance_squared(positions[output as usize]);
                if distance < best[output as usize].0 {
                    best[output as usize] = (distance, v as u32);
                }
            }
        }
        best.into_iter().map(|(_, v)| v).collect()
    }

    /// Finds the closest point on the faces around one vertex: the end of a walk from `start` to ever nearer
    /// neighbours.
    pub fn closest_point_from(&self, point: Vec3, start: u32) -> ClosestPoint {
        // The walk ends at a local minimum, which is good enough near the surface.
        self.closest_point_around(point, self.walk_to_nearest(point, start)).0
    }

    /// Finds the closest point as [`Self::closest_point_from`] does, and walks on to ever nearer faces; a point at most
    /// `near` away suffices.
    // The nearest vertex of a long face can be far away.
    pub fn closest_point_over_faces(&self, point: Vec3, start: u32, near: f32) -> ClosestPoint {
        let (mut closest, mut face) = self.closest_point_around(point, self.walk_to_nearest(point, start));
        if closest.distance <= near {
            return closest;
        }
        loop {
            let around = face.map(|v| self.closest_point_around(point, v));
            let nearest = around.into_iter().min_by(|a, b| a.0.distance.total_cmp(&b.0.distance));
            match nearest {
                Some(nearer) if nearer.0.distance < closest.distance => (closest, face) = nearer,
                _ => return closest,
            }
        }
    }

    /// Returns the closest point on the faces around a vertex, and its face.
    fn closest_point_around(&self, point: Vec3, v: u32) -> (ClosestPoint, [u32; 3]) {
        let mut closest = (ClosestPoint { point, normal: Vec3::ZERO, distance: f32::INFINITY }, [v; 3]);
        for [p, q] in self.opposite_edges(v) {
            let corners = [v, p, q].map(|w| self.surface.positions[w as usize]);
            let there = nearest_point(point, corners);
            let distance = there.distance(point);
            if distance < closest.0.distance {
                closest = (ClosestPoint { point: there, normal: self.face_normal_at(v, corners), distance }, [v, p, q]);
            }
        }
        closest
    }

    fn walk_to_nearest(&self, point: Vec3, start: u32) -> u32 {
        let distance = |v: u32| self.surface.positions[v as usize].distance_squared(point);
        let (mut v, mut least) = (start, distance(start));
        loop {
            let before = v;
            for &w in self.surface.neighbors(v) {
                let distance = distance(w);
                if distance < least {
                    (v, least) = (w, distance);
                }
            }
            if v == before {
                return v;
            }
        }
    }

    /// Lists the other two corners of each face around a vertex.
    fn opposite_edges(&self, v: u32) -> impl Iterator<Item = [u32; 2]> {
        // At a boundary the ring is open: its last and first neighbours share no face.
        let ring = self.surface.neighbors(v);
        let n_faces = if self.surface.rings.ghost(v).is_none() { ring.len() } else { ring.len() - 1 };
        (0..n_faces).map(|i| [ring[i], ring[if i + 1 == ring.len() { 0 } else { i + 1 }]])
    }

    /// Returns the area normal of a face; without consistent winding, on the side of the normal at `v`.
    fn face_normal_at(&self, v: u32, corners: [Vec3; 3]) -> Vec3 {
        let normal = area_normal(corners);
        // Only surfaces without a consistent winding need the vertex normal.
        let is_opposed = !self.surface.rings.is_oriented() && normal.dot(self.surface.normals[v as usize]) < 0.0;
        if is_opposed { -normal } else { normal }
    }

    /// Collects the regions of the wanted output vertices; `vertex_of` maps surface vertices to output vertices.
    pub fn collect_regions(&self, vertex_of: &[u32], wanted: &[bool]) -> Regions {
        let mut regions: FxHashMap<u32, Region> = FxHashMap::default();
        let wanted = |v: &u32| wanted[vertex_of[*v as usize] as usize];
        let numbers = self.surface.pulse.ranges(0..vertex_of.len());
        for v in numbers.flat_map(|numbers| numbers.start as u32..numbers.end as u32).filter(wanted) {
            let output = vertex_of[v as usize];
            let region = regions.entry(output).or_default();
            region.points.push(self.surface.positions[v as usize]);
            // A face is recorded once per region, at its first corner there.
            let is_first = |w: &u32| *w > v || vertex_of[*w as usize] != output;
            for [p, q] in self.opposite_edges(v).filter(|side| side.iter().all(is_first)) {
                let corners = [v, p, q].map(|w| self.surface.positions[w as usize]);
                let face = RegionFace::new(corners, self.face_normal_at(v, corners));
                region.points.push(face.centroid());
                // Degenerate faces have no normal, and their edges belong to other faces.
                region.faces.extend(Some(face).filter(|face| face.normal != Vec3::ZERO));
            }
        }
        regions.values_mut().for_each(Region::thin_out);
        Regions(regions)
    }

    pub fn seam_bounded_search(&self) -> SeamBoundedSearch<'_> {
        let surface = &self.surface;
        let around = FacesAround::new(surface.pulse, surface.n_vertices(), &surface.faces);
        let face_along = |[u, v]: [u32; 2]| around.face_along(u, v).unwrap_or(NO_FACE);
        let faces_across = |&[a, b, c]: &[u32; 3]| [[b, a], [c, b], [a, c]].map(face_along);
        let across = surface.pulse.counting_if(false).map(&surface.faces, faces_across);
        let search = SeamBoundedSearch { surface, orders: self.corner_orders(), across, seams: Vec::new() };
        search.with_seams(self.features.edges.iter().copied())
    }

    /// Returns the attributes with normals that follow the faces which the surface winds the other way than the mesh.
    pub fn turn_normals<'b>(&self, attributes: &'b Attributes) -> Cow<'b, Attributes> {
        if attributes.channel(Role::Normal).is_none() || matches!(self.surface.faces, Cow::Borrowed(_)) {
            return Cow::Borrowed(attributes);
        }
        let orders = (0u32..).zip(self.corner_orders());
        let reversed = orders.filter(|(_, [first, second, _])| *second != (first + 1) % 3).map(|(face, _)| face);
        let reversed: Vec<u32> = reversed.collect();
        if reversed.is_empty() {
            return Cow::Borrowed(attributes);
        }
        let normal = |f: u32| area_normal(self.surface.faces[f as usize].map(|v| self.surface.positions[v as usize]));
        let mut turned = attributes.clone();
        turned.turn_normals(reversed.into_iter().map(|face| (face, normal(face).as_dvec3())));
        Cow::Owned(turned)
    }

    /// Returns the mesh corner at each surface corner; mesh and surface may wind a face differently.
    pub fn corner_orders(&self) -> Vec<[u8; 3]> {
        let order = |(corners, before): (&[u32; 3], &[u32; 3])| {
            corners.map(|v| before.iter().position(|&w| w == self.surface.source(v)).unwrap_or(0) as u8)
        };
        self.surface.faces.iter().zip(self.mesh.faces()).map(order).collect()
    }
}

// Regions hold faces, because the nearest vertex of a long face can be far away.
pub struct Regions(FxHashMap<u32, Region>);

impl Regions {
    pub fn contains(&self, vertex: u32) -> bool {
        self.0.contains_key(&vertex)
    }

    pub fn points(&self, vertices: &[u32]) -> impl Iterator<Item = Vec3> {
        self.select(vertices).flat_map(|region| &region.points).copied()
    }

    pub fn closest_point(&self, point: Vec3, vertices: &[u32]) -> ClosestPoint {
        let mut closest = ClosestPoint { point, normal: Vec3::ZERO, distance: f32::INFINITY };
        for face in self.select(vertices).flat_map(|region| &region.faces) {
            // Box and plane reject most faces before the exact distance.
            if face.may_be_within(closest.distance, point) {
                let there = nearest_point(point, face.corners);
                let distance = there.distance(point);
                if distance < closest.distance {
                    closest = ClosestPoint { point: there, normal: face.normal, distance };
                }
            }
        }
        closest
    }

    fn select(&self, vertices: &[u32]) -> impl Iterator<Item = &Region> {
        vertices.iter().filter_map(|v| self.0.get(v))
    }
}

#[derive(Clone, Copy)]
pub struct ClosestPoint {
    pub point: Vec3,
    pub normal: Vec3,
    pub distance: f32,
}

#[derive(Default)]
struct Region {
    points: Vec<Vec3>,
    faces: Vec<RegionFace>,
}

struct RegionFace {
    corners: [Vec3; 3],
    normal: Vec3,
    bounds: [Vec3; 2],
}

impl Region {
    fn thin_out(&mut self) {
        let step = self.points.len().div_ceil(POINTS_PER_REGION).max(1);
        self.points = self.points.iter().copied().step_by(step).collect();
    }
}

impl RegionFace {
    fn new(corners: [Vec3; 3], normal: Vec3) -> Self {
        let [a, b, c] = corners;
        Self { corners, normal, bounds: [a.min(b).min(c), a.max(b).max(c)] }
    }

    fn centroid(&self) -> Vec3 {
        (self.corners[0] + self.corners[1] + self.corners[2]) / 3.0
    }

    fn may_be_within(&self, distance: f32, point: Vec3) -> bool {
        let [low, high] = self.bounds;
        // Both tests are lower bounds of the squared distance.
        let outside = (low - point).max(point - high).max(Vec3::ZERO).length_squared();
        let height = self.normal.dot(point - self.corners[0]);
        let squared = distance * distance;
        // The factor absorbs rounding of the height.
        outside < squared && height * height <= squared * 1.001 * self.normal.length_squared()
    }
}

/// Point of the original: a face, and barycentric weights in the order of its mesh corners.
#[derive(Clone, Copy)]
pub struct SurfacePoint {
    pub face: u32,
    pub weights: [f32; 3],
}

/// Search for closest points that does not cross seams.
pub struct SeamBoundedSearch<'a> {
    surface: &'a PreparedSurface<'a>,
    orders: Vec<[u8; 3]>,
    /// Face across each side of each face, or [`NO_FACE`]: a search visits a face many times.
    across: Vec<[u32; 3]>,
    /// Marks the sides of each face that are seams.
    seams: Vec<[bool; 3]>,
}

impl SeamBoundedSearch<'_> {
    /// Bounds the search by other edges, given by their vertices in rising order.
    pub fn with_seams(self, seams: impl Iterator<Item = [u32; 2]>) -> Self {
        let edges: FxHashSet<[u32; 2]> = seams.collect();
        let are_seams = |&face: &[u32; 3]| sides(face).map(|side| edges.contains(&side));
        let seams = self.surface.pulse.counting_if(false).map(&self.surface.faces, are_seams);
        Self { seams, ..self }
    }

    /// Finds the closest point by a best-first search from the faces `starts`.
    pub fn closest_point(&self, p: Vec3, starts: &[u32]) -> SurfacePoint {
        // Few faces are visited, so a list is faster than a set.
        let mut visited: Vec<u32> = Vec::new();
        let mut open: Vec<(f32, SurfacePoint)> = Vec::new();
        let mut best =
            (f32::INFINITY, SurfacePoint { face: starts.first().copied().unwrap_or(0), weights: [1.0 / 3.0; 3] });
        let mut visit = |face: u32, open: &mut Vec<(f32, SurfacePoint)>, best: &mut (f32, SurfacePoint)| {
            if !visited.contains(&face) {
                visited.push(face);
                let here = self.nearest(p, face);
                open.push(here);
                if here.0 < best.0 {
                    *best = here;
                }
            }
        };
        starts.iter().for_each(|&face| visit(face, &mut open, &mut best));
        // Faces slightly farther than the best are expanded too, since one corner can be nearest on several faces.
        for _ in 0..MOST_STEPS {
            // Best-first: always continue from the nearest open face.
            let nearest = (0..open.len()).min_by(|&i, &j| open[i].0.total_cmp(&open[j].0));
            let Some(next) = nearest else { break };
            let (distance, surface_point) = open.swap_remove(next);
            // Zero cannot improve, and distances that are not numbers cannot be compared.
            if best.0 == 0.0 || distance.is_nan() || distance > SEARCH_SLACK * best.0 {
                break;
            }
            self.adjacent_faces(surface_point.face).for_each(|face| visit(face, &mut open, &mut best));
        }
        best.1
    }

    fn nearest(&self, p: Vec3, face: u32) -> (f32, SurfacePoint) {
        let corners = self.surface.faces[face as usize].map(|v| self.surface.positions[v as usize]);
        // In double precision, since thin faces would give arbitrary weights.
        let weights = nearest_weights_f64(p.as_dvec3(), corners.map(Vec3::as_dvec3)).map(|w| w as f32);
        let point = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        let mut of_mesh = [0.0; 3];
        self.orders[face as usize].iter().zip(weights).for_each(|(&corner, w)| of_mesh[corner as usize] = w);
        (point.distance_squared(p), SurfacePoint { face, weights: of_mesh })
    }

    fn adjacent_faces(&self, face: u32) -> impl Iterator<Item = u32> {
        let sides = self.across[face as usize].into_iter().zip(self.seams[face as usize]);
        sides.filter(|(next, is_seam)| !is_seam && *next != NO_FACE).map(|(next, _)| next)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn the_closest_point_is_the_nearest_point_of_all_faces_in_the_regions() {
        let mesh = shapes::wavy_sphere(3, 4.0);
        let original = Original::bare(&mesh);
        let surface = &original.surface;
        let n = surface.n_vertices();
        let vertex_of: Vec<u32> = (0..n as u32).map(|v| v % 7).collect();
        let regions = original.collect_regions(&vertex_of, &[true, true, false, true, false, false, false]);
        assert!(regions.contains(3) && !regions.contains(2));
        let near = [0, 3];
        let corners = |face: &[u32; 3]| face.map(|v| surface.positions[v as usize]);
        for v in (0..n).step_by(41) {
            let point = surface.positions[v] * 1.03;
            let inside = |face: &&[u32; 3]| face.iter().any(|&v| near.contains(&vertex_of[v as usize]));
            let to = |face: &[u32; 3]| nearest_point(point, corners(face)).distance(point);
            let naive = surface.faces.iter().filter(inside).map(to).fold(f32::INFINITY, f32::min);
            let closest = regions.closest_point(point, &near);
            assert!(
                (closest.distance - naive).abs() < 1e-5 * naive && closest.point.distance(point) == closest.distance
            );
            assert!(closest.normal.dot(point) > 0.0);
        }
        let points: Vec<Vec3> = regions.points(&near).collect();
        assert!(!points.is_empty() && points.len() <= 2 * POINTS_PER_REGION);
    }

    #[test]
    fn normals_are_those_of_the_naive_search() {
        let mesh = shapes::wavy_sphere(3, 4.0);
        let original = Original::bare(&mesh);
        let surface = &original.surface;
        for v in (0..surface.n_vertices() as u32).step_by(37) {
            let corners = |f: &[u32; 3]| f.map(|v| surface.positions[v as usize]);
            let face = surface.faces.iter().find(|face| face.contains(&v)).unwrap();
            let centroid = corners(face).iter().sum::<Vec3>() / 3.0;
            let start = surface.neighbors(surface.neighbors(v)[0])[0];
            let (found, naive) = (original.closest_point_from(centroid, start).normal, area_normal(corners(face)));
            assert!(found.distance(naive) <= 1e-3 * naive.length(), "{found} {naive}");
        }
    }
}
