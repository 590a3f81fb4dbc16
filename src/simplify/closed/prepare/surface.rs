//! The input as the closed assembly works on it: a manifold of unit size with normals and quadrics.

use std::borrow::Cow;
use std::ops::Range;

use glam::{DMat4, DVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::Quadric;
use crate::geometry::triangle::area_normal;
use crate::mesh::pulse::{PARALLEL, Pulse};
use crate::mesh::thread_ranges::{split_rows, thread_ranges};
use crate::mesh::{Manifold, OneRings, TriMesh, manifold_with};

/// How much a boundary counts against the surface: weight of the squared distance from the line along a boundary edge
/// at either end, over the edge's squared length. Twelve open training meshes at ratios 0.05 and 0.2: the mean distance
/// is 1.0 % nearer at 0.3, where the largest is 3 % farther, and 1.5 % farther at 10.
pub const BOUNDARY_WEIGHT: f32 = 3.0;
/// How much an edge that stays counts against the surface: weight of the plane that stands on it. Twelve training
/// meshes with creases: at 0.1 the mean distance is 1.4 % nearer and the largest 3 % farther, at 1 they are 0.9 % and
/// 14 % farther. Twelve with textures: at 0.1 the mean distance is 3.2 % nearer and texture coordinates 0.4 % farther,
/// at 1 both are 4.5 % farther.
const EDGE_WEIGHT: f32 = 0.3;
/// Weight of a vertex over the mean below which it gets as much along each axis. It makes the empty quadrics of faces
/// without area regular: at 1e-5 no result of 64 of training meshes differs, at 1e-3 four do.
const LIGHT: f64 = 1e-4;

/// Least cosine between a face's normal and the opposite of its neighbour's at a fold. A sheet of a thousandth of its
/// width, to 0.05: without folds the result lies 0.14 of the diagonal off, with them less than 0.06.
const FOLD: f32 = 0.5;

/// Normals that are made unit vectors, and quadrics that are weighed, between two beats: at a few nanoseconds each, about five
/// milliseconds.
const TOGETHER: usize = 1 << 20;

/// An oriented manifold of unit size with what every later stage asks of its vertices.
pub struct Surface<'a> {
    /// Normalised positions, n_vertices x 3; vertices split off by the manifold stand last.
    pub positions: Vec<Vec3>,
    /// Faces, n_faces x 3; the mesh's own where the manifold changed none.
    pub faces: Cow<'a, [[u32; 3]]>,
    /// Neighbours in order.
    pub rings: OneRings,
    /// Unit normals at the vertices, n_vertices x 3; zero where the faces have none.
    pub normals: Vec<Vec3>,
    /// Plane quadrics of each vertex about its own position, upper triangles; the trace is about its area, times its
    /// importance.
    pub quadrics: Vec<[f32; 6]>,
    /// By how much more than its area each vertex counts, n_vertices; empty where all count alike.
    pub importance: Vec<f32>,
    /// From normalised to local coordinates.
    pub scale: Normalisation,
    /// Who listens to what is done with it.
    pub pulse: Pulse<'a>,
    /// For the vertices that were split off where sheets met, the vertices they are copies of.
    copies: Vec<u32>,
}

/// The map between local and normalised coordinates: a shift and a power of two, so that little is rounded.
#[derive(Clone, Copy)]
pub struct Normalisation {
    centre: DVec3,
    factor: f64,
}

impl Normalisation {
    fn of(positions: &[[f32; 3]]) -> Self {
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = positions
            .par_iter()
            .with_min_len(PARALLEL)
            .map(|&p| DVec3::from(p.map(f64::from)))
            .map(|p| (p, p))
            .reduce(|| none, |(low, high), (l, h)| (low.min(l), high.max(h)));
        let diagonal = (high - low).length();
        let exponent = if diagonal > 0.0 { -diagonal.log2().round() } else { 0.0 };
        Self { centre: ((low + high) * 0.5).as_vec3().as_dvec3(), factor: exponent.exp2() }
    }

    fn normalise(&self, local: [f32; 3]) -> Vec3 {
        self.to_unit(local).as_vec3()
    }

    /// The normalised coordinates of a local point, not rounded.
    pub fn to_unit(self, local: [f32; 3]) -> DVec3 {
        self.exact_to_unit(local.map(f64::from))
    }

    /// The normalised coordinates of a local point in double precision.
    pub fn exact_to_unit(self, local: [f64; 3]) -> DVec3 {
        (DVec3::from(local) - self.centre) * self.factor
    }

    /// The local coordinates of a normalised point.
    pub fn restore(&self, point: DVec3) -> [f32; 3] {
        self.restore_exactly(point).map(|x| x as f32)
    }

    /// Returns the transform from normalised to local coordinates.
    pub fn to_local(self) -> DMat4 {
        DMat4::from_translation(self.centre) * DMat4::from_scale(DVec3::splat(1.0 / self.factor))
    }

    /// The local coordinates of a normalised point in double precision.
    pub fn restore_exactly(&self, point: DVec3) -> [f64; 3] {
        (point / self.factor + self.centre).to_array()
    }
}

impl<'a> Surface<'a> {
    /// Takes the mesh apart into a manifold, normalises it and gathers normals and quadrics.
    pub fn new(mesh: &'a TriMesh, pulse: Pulse<'a>) -> Self {
        Self::at_scale(mesh, Normalisation::of(mesh.positions()), pulse)
    }

    /// Makes the surface of a part of a mesh with the normalisation of the whole.
    pub fn at_scale(mesh: &'a TriMesh, scale: Normalisation, pulse: Pulse<'a>) -> Self {
        let Manifold { faces, rings, copies, .. } = manifold_with(pulse, mesh.positions(), mesh.faces());
        pulse.beat(0);
        let mut positions = pulse.map(mesh.positions(), |&p| scale.normalise(p));
        positions.extend(copies.iter().map(|&v| scale.normalise(mesh.positions()[v as usize])));
        let (normals, mut quadrics) = face_sums(pulse, &positions, &faces);
        add_boundary_lines(&positions, &rings, &mut quadrics);
        support_weightless(pulse, &mut quadrics);
        Self { positions, faces, rings, normals, quadrics, importance: Vec::new(), scale, pulse, copies }
    }

    /// Stands a plane on each of these edges, so that their curves keep their places.
    pub fn support_edges(&mut self, edges: impl Iterator<Item = [u32; 2]>) {
        for edge in edges {
            let plane = self.plane_on(edge, EDGE_WEIGHT);
            edge.into_iter().for_each(|v| add(&mut self.quadrics[v as usize], &plane));
        }
    }

    /// The plane that stands on a kept edge, as it counts for one of its ends.
    pub fn plane_on_edge(&self, edge: [u32; 2], end: u32) -> Quadric {
        let weight = EDGE_WEIGHT * self.importance.get(end as usize).copied().unwrap_or(1.0);
        Quadric::around(self.plane_on(edge, weight), self.positions[edge[0] as usize])
    }

    /// The plane that stands on an edge, `weight` times its squared length, an upper triangle.
    fn plane_on(&self, [a, b]: [u32; 2], weight: f32) -> [f32; 6] {
        let edge = self.positions[b as usize] - self.positions[a as usize];
        let across = edge.cross(self.normals[a as usize] + self.normals[b as usize]).normalize_or_zero();
        outer(across, weight * edge.length_squared())
    }

    /// The quadric of the line along an edge of a boundary, an upper triangle.
    pub fn line_along_boundary(&self, [a, b]: [u32; 2]) -> [f32; 6] {
        line_along(self.positions[b as usize] - self.positions[a as usize])
    }

    /// Lets every vertex count by as much more, n_vertices positive factors.
    pub fn weigh(&mut self, importance: Vec<f32>) {
        let weigh = |(quadric, factor): (&mut [f32; 6], &f32)| quadric.iter_mut().for_each(|entry| *entry *= factor);
        for (quadrics, importance) in self.quadrics.chunks_mut(TOGETHER).zip(importance.chunks(TOGETHER)) {
            self.pulse.beat(0);
            quadrics.par_iter_mut().zip(importance).with_min_len(PARALLEL).for_each(weigh);
        }
        self.importance = importance;
    }

    /// Vertices that were split off where sheets met.
    pub fn n_split(&self) -> usize {
        self.copies.len()
    }

    /// For each vertex the vertex of the mesh it stands for.
    pub fn sources(&self) -> impl Iterator<Item = u32> {
        (0..self.positions.len() as u32).map(|v| self.source(v))
    }

    /// The vertex of the mesh that `vertex` stands for.
    pub fn source(&self, vertex: u32) -> u32 {
        let n_own = self.positions.len() - self.copies.len();
        if (vertex as usize) < n_own { vertex } else { self.copies[vertex as usize - n_own] }
    }

    /// A length of the mesh, on this surface.
    pub fn length(&self, of_mesh: f32) -> f32 {
        (f64::from(of_mesh) * self.scale.factor) as f32
    }

    /// Number of vertices.
    pub fn n_vertices(&self) -> usize {
        self.positions.len()
    }

    /// The weight of a vertex: its area, and what boundaries add, times its importance.
    pub fn weight(&self, vertex: usize) -> f64 {
        let quadric = self.quadrics[vertex];
        f64::from(quadric[0] + quadric[3] + quadric[5])
    }

    /// The neighbours of `vertex` without the ghost vertex of a boundary.
    pub fn neighbors(&self, vertex: u32) -> &[u32] {
        let ring = self.rings.ring(vertex);
        match self.rings.ghost(vertex) {
            Some(_) => &ring[..ring.len() - 1],
            None => ring,
        }
    }
}

/// Unit vertex normals and plane quadrics, a third of every face to each corner, in one pass over the faces per thread.
///
/// Every vertex adds its faces up in their order, whichever thread it belongs to.
fn face_sums(pulse: Pulse, positions: &[Vec3], faces: &[[u32; 3]]) -> (Vec<Vec3>, Vec<[f32; 6]>) {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    let mut quadrics = vec![[0.0; 6]; positions.len()];
    let shares = thread_ranges(positions.len());
    let sums =
        split_rows(&shares, &mut normals, |v| v + 1).into_iter().zip(split_rows(&shares, &mut quadrics, |v| v + 1));
    let parts: Vec<_> = shares.iter().zip(sums).collect();
    parts.into_par_iter().for_each(|(share, (normals, quadrics))| {
        let pulse = pulse.counting_if(share.start == 0);
        for faces in pulse.chunks(faces) {
            add_faces(positions, faces, share, normals, quadrics);
        }
        for normals in normals.chunks_mut(TOGETHER) {
            pulse.beat(0);
            normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        }
    });
    (normals, quadrics)
}

/// Adds the faces to the sums of the vertices in `share`, `share.len()` each.
fn add_faces(
    positions: &[Vec3],
    faces: &[[u32; 3]],
    share: &Range<usize>,
    normals: &mut [Vec3],
    quadrics: &mut [[f32; 6]],
) {
    let n_own = normals.len();
    let quadrics = &mut quadrics[..n_own];
    let is_whole = n_own == positions.len();
    for face in faces.iter().filter(|face| is_whole || face.iter().any(|&v| share.contains(&(v as usize)))) {
        if let Some((normal, plane)) = plane_of(face.map(|v| positions[v as usize])) {
            for &v in face {
                let v = (v as usize).wrapping_sub(share.start);
                if v < n_own {
                    normals[v] += normal;
                    add(&mut quadrics[v], &plane);
                }
            }
        }
    }
}

/// The area normal of a face, and the quadric of its plane for each of its corners: a third of its area; `None` where it has
/// no area.
#[inline(always)]
pub fn plane_of(corners: [Vec3; 3]) -> Option<(Vec3, [f32; 6])> {
    let normal = area_normal(corners);
    let double_area = normal.length();
    (double_area > 0.0).then(|| (normal, outer(normal, 1.0 / (6.0 * double_area))))
}

/// Lines along the boundary edges, so that a boundary keeps its curve; planes that stand on them would do where the surface is
/// smooth, but lean over where it is rough.
fn add_boundary_lines(positions: &[Vec3], rings: &OneRings, quadrics: &mut [[f32; 6]]) {
    if rings.n_ghosts() == 0 {
        return;
    }
    for [w, v, _] in rings.ghost_faces() {
        let line = line_along(positions[w as usize] - positions[v as usize]);
        [v, w].into_iter().for_each(|end| add(&mut quadrics[end as usize], &line));
    }
}

/// The weighted squared distance from the line along a boundary edge or a fold, an upper triangle.
#[inline(always)]
pub fn line_along(edge: Vec3) -> [f32; 6] {
    let mut line = outer(edge, -BOUNDARY_WEIGHT);
    [0, 3, 5].into_iter().for_each(|diagonal| line[diagonal] += BOUNDARY_WEIGHT * edge.length_squared());
    line
}

/// A neighbour in the ring of a vertex.
#[derive(Clone, Copy)]
pub enum Neighbour {
    /// The ghost vertex of a boundary.
    Ghost,
    /// One at this place.
    At(Vec3),
    /// One at this place along the cut of a half, which is no boundary.
    AlongCut(Vec3),
}

impl Neighbour {
    fn position(self) -> Option<Vec3> {
        match self {
            Self::Ghost => None,
            Self::At(p) | Self::AlongCut(p) => Some(p),
        }
    }
}

/// The planes of the faces around a vertex with these neighbours in order, and the lines along its boundary edges and its folds:
/// an upper triangle, about the vertex. What [`Surface::new`] gathers, for one vertex of a surface that may have grown thin.
#[inline(always)]
pub fn planes_around(centre: Vec3, ring: impl DoubleEndedIterator<Item = Neighbour> + Clone) -> [f32; 6] {
    let mut sum = [0.0; 6];
    let mut has_folds = false;
    let (Some(mut before), mut last) = (ring.clone().next_back(), Vec3::ZERO) else { return sum };
    let mut first = None;
    for here in ring.clone() {
        let mut normal = Vec3::ZERO;
        if let (Some(p), Some(q)) = (before.position(), here.position())
            && let Some((of_face, plane)) = plane_of([centre, p, q])
        {
            add(&mut sum, &plane);
            normal = of_face;
        }
        if let (Neighbour::At(end), Neighbour::Ghost) | (Neighbour::Ghost, Neighbour::At(end)) = (before, here) {
            add(&mut sum, &line_along(end - centre));
        }
        has_folds |= last.dot(normal) < 0.0;
        first = first.or(Some(normal));
        (before, last) = (here, normal);
    }
    has_folds |= first.is_some_and(|first| last.dot(first) < 0.0);
    if has_folds {
        let places: Vec<Option<Vec3>> = ring.map(Neighbour::position).collect();
        for end in folds_around(centre, places.iter().copied()).filter_map(|i| places[i]) {
            add(&mut sum, &line_along(end - centre));
        }
    }
    sum
}

/// Which edges to these neighbours in order are folds, where a part has become so thin that its rim has no faces of its own: the
/// faces on either side look opposite ways, and say nothing of where the rim is.
pub fn folds_around(centre: Vec3, ring: impl Iterator<Item = Option<Vec3>>) -> impl Iterator<Item = usize> {
    let places: Vec<Option<Vec3>> = ring.collect();
    let n = places.len();
    let normal = |i: usize| match (places[(i + n - 1) % n], places[i % n]) {
        (Some(p), Some(q)) => area_normal([centre, p, q]),
        _ => Vec3::ZERO,
    };
    let normals: Vec<Vec3> = (0..n).map(normal).collect();
    let is_fold = move |&i: &usize| {
        let [one, other] = [normals[i], normals[(i + 1) % n]];
        let along = one.dot(other);
        along < 0.0 && along * along > FOLD * FOLD * one.length_squared() * other.length_squared()
    };
    (0..n).filter(is_fold)
}

/// Gives vertices without area a small weight in all directions, so that no quadric is empty.
fn support_weightless(pulse: Pulse, quadrics: &mut [[f32; 6]]) {
    let weight = |q: &[f32; 6]| q[0] + q[3] + q[5];
    // In chunks that do not depend on the threads.
    let sum = |chunk: &[[f32; 6]]| chunk.iter().map(|q| f64::from(weight(q))).sum();
    let sums: Vec<f64> = quadrics.par_chunks(PARALLEL).map(sum).collect();
    pulse.beat(0);
    let floor = least_weight(sums.iter().sum(), quadrics.len()) as f32;
    let too_light = quadrics.par_iter_mut().with_min_len(PARALLEL).filter(|q| weight(q) < floor);
    too_light.for_each(|q| [0, 3, 5].into_iter().for_each(|diagonal| q[diagonal] += floor));
}

/// Below this weight a vertex of a surface with so much weight on so many vertices gets as much along each axis.
pub fn least_weight(total: f64, n_vertices: usize) -> f64 {
    (LIGHT * total / n_vertices as f64).max(1e-20)
}

/// Upper triangle of `weight n n'`.
#[inline(always)]
pub fn outer(n: Vec3, weight: f32) -> [f32; 6] {
    let m = n * weight;
    [m.x * n.x, m.x * n.y, m.x * n.z, m.y * n.y, m.y * n.z, m.z * n.z]
}

/// Adds an upper triangle to another.
#[inline(always)]
pub fn add(sum: &mut [f32; 6], other: &[f32; 6]) {
    for (s, o) in sum.iter_mut().zip(other) {
        *s += o;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn area(surface: &Surface) -> f32 {
        surface.faces.iter().map(|f| 0.5 * area_normal(f.map(|v| surface.positions[v as usize])).length()).sum()
    }

    #[test]
    fn quadrics_weigh_the_area_and_normals_are_unit() {
        for mesh in [shapes::wavy_sphere(3, 5.0), shapes::torus(20, 8, 3.0, 1.0), shapes::cuboid([1e-3; 3], 3)] {
            let surface = Surface::new(&mesh, Pulse::NONE);
            let weight: f64 = (0..surface.n_vertices()).map(|v| surface.weight(v)).sum();
            assert!((weight / f64::from(area(&surface)) - 1.0).abs() < 1e-3);
            assert!(surface.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
        }
    }

    #[test]
    fn normalised_positions_are_of_unit_size_and_come_back() {
        for (size, shift) in [(1.0, 0.0), (1e-20, 0.0), (1e30, 0.0), (1.0, 300.0)] {
            let unit = shapes::icosphere(2);
            let places = unit.positions().iter().map(|p| p.map(|x| x * size + shift)).collect();
            let mesh = TriMesh::new(places, unit.faces().to_vec()).unwrap();
            let surface = Surface::new(&mesh, Pulse::NONE);
            assert!(surface.positions.iter().all(|p| (0.2..0.8).contains(&p.length())));
            let near = |p: f32, q: f32| (p - q).abs() <= 4.0 * f32::EPSILON * (size + shift);
            for (p, local) in surface.positions.iter().zip(mesh.positions()) {
                let back = surface.scale.restore(p.as_dvec3());
                assert!(back.iter().zip(local).all(|(&p, &q)| near(p, q)), "{back:?} {local:?}");
            }
        }
    }

    #[test]
    fn faces_without_area_leave_no_empty_quadric() {
        let unit = shapes::cuboid([1.0; 3], 2);
        for flat in [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]] {
            let places = unit.positions().iter().map(|p| std::array::from_fn(|k| p[k] * flat[k])).collect();
            let mesh = TriMesh::new(places, unit.faces().to_vec()).unwrap();
            let surface = Surface::new(&mesh, Pulse::NONE);
            assert!((0..surface.n_vertices()).all(|v| surface.weight(v) > 0.0));
            assert!(surface.positions.iter().chain(&surface.normals).all(|p| p.is_finite()));
        }
    }

    #[test]
    fn split_vertices_know_where_they_come_from() {
        let mesh = shapes::tetrahedra_sharing_vertex();
        let surface = Surface::new(&mesh, Pulse::NONE);
        assert_eq!((surface.n_split(), surface.n_vertices()), (1, 8));
        let last = surface.sources().last().unwrap() as usize;
        assert_eq!(surface.positions[7], surface.positions[last]);
    }
}
