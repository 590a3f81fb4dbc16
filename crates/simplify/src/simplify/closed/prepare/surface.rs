//! The input as a manifold of unit size, with normals and quadrics.

use std::borrow::Cow;
use std::ops::Range;

use glam::{DMat4, DVec3, Vec3};

use crate::geometry::Quadric;
use crate::geometry::triangle::area_normal;
use crate::mesh::pulse::{PARALLEL, Pulse};
use crate::mesh::thread_ranges::{split_rows, thread_ranges};
use crate::mesh::{Manifold, OneRings, TriMesh, manifold_with};
use crate::parallel;

use super::area_weights::AreaWeights;

/// Weight of the squared distance to the line along a boundary edge.
// Twelve open meshes: the mean distance is 1.0 % smaller at 0.3, with the largest 3 % larger, and 1.5 % larger at 10.
pub const BOUNDARY_WEIGHT: f32 = 3.0;
/// Weight of the plane through a held edge, perpendicular to the surface.
// Twelve meshes with creases: at 0.1 the mean distance is 1.4 % smaller and the largest 3 % larger.
const EDGE_WEIGHT: f32 = 0.3;
/// Least weight of a vertex, the trace of its quadric, over the mean of all.
// At 1e-5 no result of 64 differs.
const LEAST_VERTEX_WEIGHT: f64 = 1e-4;

/// Least cosine at a fold between the normal of one face and the reverse of the other's.
// A thin sheet at ratio 0.05 deviates by 0.14 of the diagonal without the lines along folds, by 0.06 with them.
const LEAST_FOLD_COSINE: f32 = 0.5;

const CHUNK: usize = 1 << 20;

pub struct PreparedSurface<'a> {
    /// Normalised positions; copies of split vertices come last.
    pub positions: Vec<Vec3>,
    pub faces: Cow<'a, [[u32; 3]]>,
    pub rings: OneRings,
    pub normals: Vec<Vec3>,
    /// Plane quadrics, upper triangles; the trace is about area times importance.
    pub quadrics: Vec<[f32; 6]>,
    pub importance: Vec<f32>,
    pub scale: Normalisation,
    pub pulse: Pulse<'a>,
    pub area_weights: AreaWeights,
    copies: Vec<u32>,
}

/// Map between local and normalised coordinates: a shift and a power of two, which round little.
#[derive(Clone, Copy)]
pub struct Normalisation {
    centre: DVec3,
    factor: f64,
}

impl Normalisation {
    fn from_positions(positions: &[[f32; 3]]) -> Self {
        // Minima and maxima are exact, so a parallel reduction gives the same box.
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let wider = |(low, high): (DVec3, DVec3), (l, h): (DVec3, DVec3)| (low.min(l), high.max(h));
        let of_chunk = |_, positions: &[[f32; 3]]| {
            positions.iter().map(|&p| Vec3::from(p).as_dvec3()).fold(none, |all, p| wider(all, (p, p)))
        };
        let (low, high) = parallel::chunks(positions, CHUNK, of_chunk).into_iter().fold(none, wider);
        let diagonal = (high - low).length();
        // A power of two scales without rounding.
        let exponent = if diagonal > 0.0 { -diagonal.log2().round() } else { 0.0 };
        Self { centre: ((low + high) * 0.5).as_vec3().as_dvec3(), factor: exponent.exp2() }
    }

    fn normalise(&self, local: [f32; 3]) -> Vec3 {
        self.to_unit(local).as_vec3()
    }

    pub fn to_unit(self, local: [f32; 3]) -> DVec3 {
        self.exact_to_unit(local.map(f64::from))
    }

    pub fn exact_to_unit(self, local: [f64; 3]) -> DVec3 {
        (DVec3::from(local) - self.centre) * self.factor
    }

    pub fn restore(&self, point: DVec3) -> [f32; 3] {
        self.restore_exactly(point).map(|x| x as f32)
    }

    pub fn to_local(self) -> DMat4 {
        DMat4::from_translation(self.centre) * DMat4::from_scale(DVec3::splat(1.0 / self.factor))
    }

    pub fn restore_exactly(&self, point: DVec3) -> [f64; 3] {
        (point / self.factor + self.centre).to_array()
    }
}

impl<'a> PreparedSurface<'a> {
    pub fn new(mesh: &'a TriMesh, pulse: Pulse<'a>) -> Self {
        Self::at_scale(mesh, Normalisation::from_positions(mesh.positions()), pulse)
    }

    pub fn at_scale(mesh: &'a TriMesh, scale: Normalisation, pulse: Pulse<'a>) -> Self {
        Self::of_manifold(mesh, manifold_with(pulse, mesh.positions(), mesh.faces()), scale, pulse)
    }

    /// Prepares a manifold that was made of the mesh.
    pub fn of_manifold(mesh: &TriMesh, manifold: Manifold<'a>, scale: Normalisation, pulse: Pulse<'a>) -> Self {
        let mut surface = Self::place_manifold(mesh, manifold, scale, pulse);
        surface.sum_faces();
        surface
    }

    fn sum_faces(&mut self) {
        let (normals, mut quadrics) = sum_faces(self.pulse, &self.positions, &self.faces, self.area_weights);
        // Supporting planes in place of lines would lean where the surface is rough.
        for [v, w] in self.edges_with_lines() {
            let line = line_along(self.positions[w as usize] - self.positions[v as usize]);
            [v, w].into_iter().for_each(|end| add(&mut quadrics[end as usize], &line));
        }
        support_weightless(self.pulse, &mut quadrics);
        (self.normals, self.quadrics) = (normals, quadrics);
    }

    /// Lists the edges along which lines hold the surface: boundaries and folds.
    pub fn edges_with_lines(&self) -> Vec<[u32; 2]> {
        // A ghost face has one real edge: the boundary's.
        let mut edges: Vec<[u32; 2]> = self.rings.ghost_faces().into_iter().map(|[w, v, _]| [v, w]).collect();
        edges.extend(parallel::flat_map(0..self.positions.len(), PARALLEL, |v| self.folds_from(v as u32)));
        edges
    }

    /// Lists the folds from a vertex to vertices of higher numbers.
    fn folds_from(&self, vertex: u32) -> impl Iterator<Item = [u32; 2]> {
        let ring = self.rings.ring(vertex);
        // A ghost vertex has no position.
        let place = |i: usize| self.positions.get(ring[i] as usize).copied();
        let folds = folds_around(self.positions[vertex as usize], ring.len(), place).map(|i| ring[i]);
        folds.filter(move |&end| vertex < end).map(move |end| [vertex, end])
    }

    /// Weighs small faces more than their areas if areas around vertices are very different.
    pub fn weigh_small_faces(&mut self) {
        self.area_weights = AreaWeights::new(&self.positions, &self.faces, |v| self.neighbors(v));
        if !self.area_weights.is_plain() {
            self.sum_faces();
        }
    }

    /// Prepares a mesh without normals and quadrics, which a closest point on a surface of consistent winding does not need.
    pub fn without_sums(mesh: &'a TriMesh, pulse: Pulse<'a>) -> Self {
        let manifold = manifold_with(pulse, mesh.positions(), mesh.faces());
        Self::place_manifold(mesh, manifold, Normalisation::from_positions(mesh.positions()), pulse)
    }

    fn place_manifold(mesh: &TriMesh, manifold: Manifold<'a>, scale: Normalisation, pulse: Pulse<'a>) -> Self {
        let Manifold { faces, rings, copies, .. } = manifold;
        pulse.beat(0);
        let mut positions = pulse.map(mesh.positions(), |&p| scale.normalise(p));
        // Copies start at the position of their vertex.
        positions.extend(copies.iter().map(|&v| scale.normalise(mesh.positions()[v as usize])));
        let (normals, quadrics, importance) = (Vec::new(), Vec::new(), Vec::new());
        let area_weights = AreaWeights::default();
        Self { positions, faces, rings, normals, quadrics, importance, scale, pulse, area_weights, copies }
    }

    /// Adds to both ends of each edge a plane through the edge, perpendicular to the surface.
    pub fn support_edges(&mut self, edges: impl Iterator<Item = [u32; 2]>) {
        for edge in edges {
            let plane = self.plane_on(edge, EDGE_WEIGHT);
            edge.into_iter().for_each(|v| add(&mut self.quadrics[v as usize], &plane));
        }
    }

    pub fn plane_on_edge(&self, edge: [u32; 2], end: u32) -> Quadric {
        let weight = EDGE_WEIGHT * self.importance.get(end as usize).copied().unwrap_or(1.0);
        Quadric::with_minimum(self.plane_on(edge, weight), self.positions[edge[0] as usize])
    }

    fn plane_on(&self, [a, b]: [u32; 2], weight: f32) -> [f32; 6] {
        let edge = self.positions[b as usize] - self.positions[a as usize];
        // The plane contains the edge and the mean normal of its ends.
        let across = edge.cross(self.normals[a as usize] + self.normals[b as usize]).normalize_or_zero();
        let area = edge.length_squared();
        outer(across, self.area_weights.factor(area) * weight * area)
    }

    pub fn weigh(&mut self, importance: Vec<f32>) {
        for (quadrics, importance) in self.quadrics.chunks_mut(CHUNK).zip(importance.chunks(CHUNK)) {
            self.pulse.beat(0);
            let weigh = |v: usize, quadric: &mut [f32; 6]| quadric.iter_mut().for_each(|entry| *entry *= importance[v]);
            parallel::change(quadrics, PARALLEL, weigh);
        }
        self.importance = importance;
    }

    /// Returns the area of all faces, at unit size.
    pub fn area(&self) -> f64 {
        let area = |face: &[u32; 3]| 0.5 * f64::from(area_normal(face.map(|v| self.positions[v as usize])).length());
        self.faces.iter().map(area).sum()
    }

    pub fn n_split(&self) -> usize {
        self.copies.len()
    }

    pub fn sources(&self) -> impl Iterator<Item = u32> {
        (0..self.positions.len() as u32).map(|v| self.source(v))
    }

    pub fn source(&self, vertex: u32) -> u32 {
        let n_own = self.positions.len() - self.copies.len();
        if (vertex as usize) < n_own { vertex } else { self.copies[vertex as usize - n_own] }
    }

    pub fn length(&self, of_mesh: f32) -> f32 {
        (f64::from(of_mesh) * self.scale.factor) as f32
    }

    pub fn n_vertices(&self) -> usize {
        self.positions.len()
    }

    pub fn weight(&self, vertex: usize) -> f64 {
        let quadric = self.quadrics[vertex];
        f64::from(quadric[0] + quadric[3] + quadric[5])
    }

    pub fn neighbors(&self, vertex: u32) -> &[u32] {
        let ring = self.rings.ring(vertex);
        match self.rings.ghost(vertex) {
            Some(_) => &ring[..ring.len() - 1],
            None => ring,
        }
    }
}

/// Sums unit vertex normals and plane quadrics, a third of each face per corner.
fn sum_faces(
    pulse: Pulse,
    positions: &[Vec3],
    faces: &[[u32; 3]],
    area_weights: AreaWeights,
) -> (Vec<Vec3>, Vec<[f32; 6]>) {
    let mut normals = vec![Vec3::ZERO; positions.len()];
    let mut quadrics = vec![[0.0; 6]; positions.len()];
    // Each thread owns a range of vertices and scans all faces.
    let shares = thread_ranges(positions.len());
    let sums =
        split_rows(&shares, &mut normals, |v| v + 1).into_iter().zip(split_rows(&shares, &mut quadrics, |v| v + 1));
    parallel::each(shares.iter().zip(sums), |(share, (normals, quadrics))| {
        let pulse = pulse.counting_if(share.start == 0);
        for faces in pulse.chunks(faces) {
            add_faces(positions, (faces, area_weights), share, normals, quadrics);
        }
        for normals in normals.chunks_mut(CHUNK) {
            pulse.beat(0);
            normals.iter_mut().for_each(|n| *n = n.normalize_or_zero());
        }
    });
    (normals, quadrics)
}

fn add_faces(
    positions: &[Vec3],
    (faces, area_weights): (&[[u32; 3]], AreaWeights),
    share: &Range<usize>,
    normals: &mut [Vec3],
    quadrics: &mut [[f32; 6]],
) {
    let n_own = normals.len();
    // Equal lengths let the compiler drop bounds checks.
    let quadrics = &mut quadrics[..n_own];
    let is_whole = n_own == positions.len();
    for face in faces.iter().filter(|face| is_whole || face.iter().any(|&v| share.contains(&(v as usize)))) {
        if let Some((normal, plane)) = plane_of(face.map(|v| positions[v as usize]), area_weights) {
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

#[inline(always)]
pub fn plane_of(corners: [Vec3; 3], area_weights: AreaWeights) -> Option<(Vec3, [f32; 6])> {
    let normal = area_normal(corners);
    let double_area = normal.length();
    let weight = || area_weights.factor(0.5 * double_area) / (6.0 * double_area);
    (double_area > 0.0).then(|| (normal, outer(normal, weight())))
}

/// Returns the quadric of the line along an edge: squared distance times squared edge length and [`BOUNDARY_WEIGHT`].
#[inline(always)]
pub fn line_along(edge: Vec3) -> [f32; 6] {
    // Squared distance from the line: `|e|^2 |x|^2 - (e.x)^2`.
    let mut line = outer(edge, -BOUNDARY_WEIGHT);
    [0, 3, 5].into_iter().for_each(|diagonal| line[diagonal] += BOUNDARY_WEIGHT * edge.length_squared());
    line
}

/// Sums the planes around a vertex and the lines along its boundary edges and folds; `None` in `ring` is a ghost vertex.
#[inline(always)]
pub fn planes_around(
    centre: Vec3,
    ring: impl DoubleEndedIterator<Item = Option<Vec3>> + Clone,
    area_weights: AreaWeights,
) -> [f32; 6] {
    let mut sum = [0.0; 6];
    let mut has_folds = false;
    // The walk starts with the last neighbour, so that every face is visited once.
    let (Some(mut before), mut last) = (ring.clone().next_back(), Vec3::ZERO) else { return sum };
    let mut first = None;
    for here in ring.clone() {
        let mut normal = Vec3::ZERO;
        if let (Some(p), Some(q)) = (before, here)
            && let Some((of_face, plane)) = plane_of([centre, p, q], area_weights)
        {
            add(&mut sum, &plane);
            normal = of_face;
        }
        // Next to a ghost vertex the edge is a boundary.
        if let (Some(end), None) | (None, Some(end)) = (before, here) {
            add(&mut sum, &line_along(end - centre));
        }
        has_folds |= last.dot(normal) < 0.0;
        first = first.or(Some(normal));
        (before, last) = (here, normal);
    }
    has_folds |= first.is_some_and(|first| last.dot(first) < 0.0);
    // Folds are rare, so they are searched only if two faces oppose each other.
    if has_folds {
        let places: Vec<Option<Vec3>> = ring.collect();
        for end in folds_around(centre, places.len(), |i| places[i]).filter_map(|i| places[i]) {
            add(&mut sum, &line_along(end - centre));
        }
    }
    sum
}

/// Finds which of `n` neighbours are along folds, the rims of thin sheets; the planes of opposite faces do not hold these.
///
/// `place(i)` is the position of a neighbour, `None` for a ghost vertex.
pub fn folds_around(centre: Vec3, n: usize, place: impl Fn(usize) -> Option<Vec3>) -> impl Iterator<Item = usize> {
    let normal = move |i: usize| match (place((i + n - 1) % n), place(i % n)) {
        (Some(p), Some(q)) => area_normal([centre, p, q]),
        _ => Vec3::ZERO,
    };
    let is_fold = move |&i: &usize| {
        // Compared without square roots.
        let [one, other] = [normal(i), normal(i + 1)];
        let along = one.dot(other);
        along < 0.0
            && along * along > LEAST_FOLD_COSINE * LEAST_FOLD_COSINE * one.length_squared() * other.length_squared()
    };
    (0..n).filter(is_fold)
}

fn support_weightless(pulse: Pulse, quadrics: &mut [[f32; 6]]) {
    let weight = |q: &[f32; 6]| q[0] + q[3] + q[5];
    // Chunks do not depend on the number of threads.
    let sum = |_, chunk: &[[f32; 6]]| chunk.iter().map(|q| f64::from(weight(q))).sum::<f64>();
    let sums = parallel::chunks(quadrics, PARALLEL, sum);
    pulse.beat(0);
    // Light vertices get the least weight on the diagonal alone: a pull to the vertex in every direction.
    let floor = least_weight(sums.iter().sum(), quadrics.len()) as f32;
    parallel::change(quadrics, PARALLEL, |_, q| {
        if weight(q) < floor {
            [0, 3, 5].into_iter().for_each(|diagonal| q[diagonal] += floor);
        }
    });
}

pub fn least_weight(total: f64, n_vertices: usize) -> f64 {
    (LEAST_VERTEX_WEIGHT * total / n_vertices as f64).max(1e-20)
}

#[inline(always)]
pub fn outer(n: Vec3, weight: f32) -> [f32; 6] {
    let m = n * weight;
    [m.x * n.x, m.x * n.y, m.x * n.z, m.y * n.y, m.y * n.z, m.z * n.z]
}

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
    use crate::simplify::closed::prepare::area_weights::build_rounded_cube;

    fn area(surface: &PreparedSurface) -> f32 {
        surface.faces.iter().map(|f| 0.5 * area_normal(f.map(|v| surface.positions[v as usize])).length()).sum()
    }

    #[test]
    fn quadrics_weigh_the_area_and_normals_are_unit() {
        for mesh in [shapes::wavy_sphere(3, 5.0), shapes::torus(20, 8, 3.0, 1.0), shapes::cuboid([1e-3; 3], 3)] {
            let surface = PreparedSurface::new(&mesh, Pulse::NONE);
            let weight: f64 = (0..surface.n_vertices()).map(|v| surface.weight(v)).sum();
            assert!((weight / f64::from(area(&surface)) - 1.0).abs() < 1e-3);
            assert!(surface.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-5));
        }
    }

    #[test]
    fn the_first_quadrics_are_those_of_later_passes_also_at_folds() {
        // A sheet without thickness: its two sides have centres of their own.
        let rim = (0..12).map(|i| (i as f32 * std::f32::consts::TAU / 12.0).sin_cos()).map(|(y, x)| [x, y, 0.0]);
        let positions = rim.chain([[0.1, 0.0, 0.0], [0.0, 0.1, 0.0]]).collect();
        let sides = (0..12).flat_map(|i| [[i, (i + 1) % 12, 12], [(i + 1) % 12, i, 13]]);
        let sheet = TriMesh::new(positions, sides.collect()).unwrap();
        for mesh in [sheet, shapes::grid(5, 4), shapes::bolt(9), shapes::wavy_sphere(2, 5.0)] {
            let surface = PreparedSurface::new(&mesh, Pulse::NONE);
            for (v, found) in (0..surface.n_vertices() as u32).zip(&surface.quadrics) {
                let place = |&w: &u32| surface.positions.get(w as usize).copied();
                let (centre, ring) = (surface.positions[v as usize], surface.rings.ring(v).iter().map(place));
                let later = planes_around(centre, ring, AreaWeights::default());
                let size = later[0] + later[3] + later[5];
                assert!(found.iter().zip(later).all(|(x, y)| (x - y).abs() <= 1e-4 * size), "{v}: {found:?} {later:?}");
            }
        }
    }

    #[test]
    fn normalised_positions_are_of_unit_size_and_come_back() {
        for (size, shift) in [(1.0, 0.0), (1e-20, 0.0), (1e30, 0.0), (1.0, 300.0)] {
            let unit = shapes::icosphere(2);
            let places = unit.positions().iter().map(|p| p.map(|x| x * size + shift)).collect();
            let mesh = TriMesh::new(places, unit.faces().to_vec()).unwrap();
            let surface = PreparedSurface::new(&mesh, Pulse::NONE);
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
            let surface = PreparedSurface::new(&mesh, Pulse::NONE);
            assert!((0..surface.n_vertices()).all(|v| surface.weight(v) > 0.0));
            assert!(surface.positions.iter().chain(&surface.normals).all(|p| p.is_finite()));
        }
    }

    #[test]
    fn split_vertices_know_where_they_come_from() {
        let mesh = shapes::tetrahedra_sharing_vertex();
        let surface = PreparedSurface::new(&mesh, Pulse::NONE);
        assert_eq!((surface.n_split(), surface.n_vertices()), (1, 8));
        let last = surface.sources().last().unwrap() as usize;
        assert_eq!(surface.positions[7], surface.positions[last]);
    }

    #[test]
    fn faces_of_even_areas_weigh_their_areas() {
        for mesh in [shapes::wavy_sphere(3, 4.0), shapes::cuboid([1.0; 3], 6), shapes::torus(24, 12, 1.0, 0.4)] {
            let mut surface = PreparedSurface::new(&mesh, Pulse::NONE);
            let before = surface.quadrics.clone();
            surface.weigh_small_faces();
            assert!(surface.area_weights.is_plain() && surface.quadrics == before);
        }
    }

    #[test]
    fn small_faces_beside_large_ones_weigh_more_than_their_areas_and_all_together_as_much() {
        let mesh = build_rounded_cube(0.02);
        let mut surface = PreparedSurface::new(&mesh, Pulse::NONE);
        let weights =
            |surface: &PreparedSurface| -> Vec<f64> { (0..surface.n_vertices()).map(|v| surface.weight(v)).collect() };
        let plain = weights(&surface);
        surface.weigh_small_faces();
        let weighed = weights(&surface);
        let total = |weights: &[f64]| weights.iter().sum::<f64>();
        assert!((0.5..2.0).contains(&(total(&weighed) / total(&plain))));
        let lightest = (0..plain.len()).min_by(|&v, &w| plain[v].total_cmp(&plain[w])).unwrap();
        assert!(weighed[lightest] > 10.0 * plain[lightest]);
        // Faces weigh a third of their area's power of 1/4 at each corner.
        let naive = |corners: [Vec3; 3]| (0.5 * area_normal(corners).length()).powf(0.25);
        let of_face = |face: &[u32; 3]| {
            let corners = face.map(|v| surface.positions[v as usize]);
            let (_, plane) = plane_of(corners, surface.area_weights).unwrap();
            (plane[0] + plane[3] + plane[5]) / naive(corners)
        };
        let quotients: Vec<f32> = surface.faces.iter().map(of_face).collect();
        assert!(quotients.iter().all(|quotient| (quotient / quotients[0] - 1.0).abs() < 1e-3));
    }
}
