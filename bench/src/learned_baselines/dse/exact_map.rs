//! Exact logarithmic maps on the mesh, the targets of the networks.
//!
//! Distances follow Kimmel and Sethian (1998) and Novotni and Klein (2002), steps follow Schmidt, Grimm and Wyvill
//! (2006).

use super::Patch;
use glam::DVec3;
use neural_mesh::linalg::Rows;
use neural_mesh::mesh::pulse::Pulse;
use neural_mesh::mesh::thread_ranges::corner_rows;
use neural_mesh::mesh::{TriMesh, vertex_normals};
use neural_mesh::parallel;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

// The shortest path to a vertex is a detour if it exceeds the vertex's distance in the map by this factor.
const DETOUR: f64 = 1.1;

/// A surface to walk on.
pub struct WalkSurface {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    around: Rows<u32>,
}

#[derive(Clone, Copy)]
struct FrontVertex {
    distance: f64,
    // Position in the map and first tangent axis; `None` until the front has passed the vertex.
    passed: Option<([f64; 2], DVec3)>,
}

struct Front<'a> {
    surface: &'a WalkSurface,
    reached: FxHashMap<u32, FrontVertex>,
    // Vertices by distance, whose bits sort like non-negative numbers.
    waiting: BinaryHeap<Reverse<(u64, u32)>>,
}

impl WalkSurface {
    /// Makes the surface of a mesh.
    pub fn new(mesh: &TriMesh) -> Self {
        let around = corner_rows(Pulse::NONE, mesh.positions().len(), mesh.faces(), |face, _| face);
        let doubles = |rows: &[[f32; 3]]| rows.iter().map(|&row| glam::Vec3::from(row).as_dvec3()).collect();
        let normals: Vec<DVec3> = doubles(&vertex_normals(mesh));
        Self { positions: doubles(mesh.positions()), normals, faces: mesh.faces().to_vec(), around }
    }

    fn faces_around(&self, v: u32) -> impl Iterator<Item = [u32; 3]> {
        self.around.row(v as usize).iter().map(|&face| self.faces[face as usize])
    }

    fn edge_length(&self, a: u32, b: u32) -> f64 {
        self.positions[a as usize].distance(self.positions[b as usize])
    }

    fn first_axis(&self, v: u32) -> DVec3 {
        let normal = self.normals[v as usize];
        if normal == DVec3::ZERO { DVec3::X } else { normal.any_orthonormal_vector() }
    }

    fn transport(&self, axis: DVec3, from: u32, to: u32) -> DVec3 {
        let [n, m] = [from, to].map(|v| self.normals[v as usize]);
        // The axis turns as the normal turns from one end to the other.
        let sum = 1.0 + n.dot(m);
        let carried = if sum > 1e-6 { axis - (n + m) * (m.dot(axis) / sum) } else { axis - m * m.dot(axis) };
        carried.normalize_or(axis)
    }

    fn step(&self, from: u32, axis: DVec3, to: u32) -> [f64; 2] {
        let edge = self.positions[to as usize] - self.positions[from as usize];
        let carried = self.transport(axis, from, to);
        // The step is averaged over the tangent planes of both ends, with the edge's length.
        let seen = |axis: DVec3, v: u32| [axis.dot(edge), self.normals[v as usize].cross(axis).dot(edge)];
        let [a, b] = [seen(axis, from), seen(carried, to)];
        let both = [a[0] + b[0], a[1] + b[1]];
        let length = both[0].hypot(both[1]);
        if length > 0.0 { both.map(|x| x * edge.length() / length) } else { [0.0; 2] }
    }

    /// Returns the `n` wanted vertices nearest to `source` along the surface, with their positions in its logarithmic
    /// map; fewer if its component has fewer.
    ///
    /// # Panics
    /// If `source` does not exist.
    pub fn logarithmic_map(&self, source: u32, n: usize, is_wanted: impl Fn(u32) -> bool) -> Vec<(u32, [f64; 2])> {
        let mut front = Front { surface: self, reached: FxHashMap::default(), waiting: BinaryHeap::new() };
        front.reach(source, 0.0);
        let mut found = Vec::with_capacity(n);
        while found.len() < n {
            let Some(v) = front.pop_nearest() else { break };
            let at = front.pass(v);
            if v != source && is_wanted(v) {
                found.push((v, at));
            }
        }
        found
    }
}

impl Front<'_> {
    fn reach(&mut self, v: u32, distance: f64) {
        let known = self.reached.entry(v).or_insert(FrontVertex { distance: f64::INFINITY, passed: None });
        if known.passed.is_none() && distance < known.distance {
            known.distance = distance;
            self.waiting.push(Reverse((distance.to_bits(), v)));
        }
    }

    fn pop_nearest(&mut self) -> Option<u32> {
        while let Some(Reverse((_, v))) = self.waiting.pop() {
            if self.reached.get(&v).is_some_and(|known| known.passed.is_none()) {
                return Some(v);
            }
        }
        None
    }

    fn passed_vertex(&self, v: u32) -> Option<(f64, [f64; 2], DVec3)> {
        let known = self.reached.get(&v)?;
        known.passed.map(|(at, axis)| (known.distance, at, axis))
    }

    fn pass(&mut self, v: u32) -> [f64; 2] {
        let (at, axis) = self.average_position(v);
        let distance = self.reached.get(&v).map_or(0.0, |known| known.distance);
        self.reached.insert(v, FrontVertex { distance, passed: Some((at, axis)) });
        // Every face at v offers its other corners a path over v, and one through the edge between v and the third
        // corner.
        let faces: Vec<[u32; 3]> = self.surface.faces_around(v).collect();
        for face in faces {
            for i in 0..3 {
                let [a, b, c] = [face[i], face[(i + 1) % 3], face[(i + 2) % 3]];
                if a != v {
                    self.reach(a, self.path_length(a, v, if b == v { c } else { b }));
                }
            }
        }
        let length = at[0].hypot(at[1]);
        // If the path was a detour, the position is moved outward to the path's length.
        if distance > DETOUR * length && length > 0.0 { at.map(|x| x * distance / length) } else { at }
    }

    fn average_position(&self, v: u32) -> ([f64; 2], DVec3) {
        // The position is the mean of what neighbours give, weighted by inverse edge length; the axis comes along the
        // shortest path.
        let (mut sum, mut weights) = ([0.0; 2], 0.0);
        let (mut shortest, mut axis_here) = (f64::INFINITY, self.surface.first_axis(v));
        for p in self.surface.faces_around(v).flatten().filter(|&p| p != v) {
            let Some((distance, at, axis)) = self.passed_vertex(p) else { continue };
            let (step, length) = (self.surface.step(p, axis, v), self.surface.edge_length(p, v));
            let weight = 1.0 / length.max(1e-30);
            (0..2).for_each(|i| sum[i] += weight * (at[i] + step[i]));
            weights += weight;
            if distance + length < shortest {
                (shortest, axis_here) = (distance + length, self.surface.transport(axis, p, v));
            }
        }
        (if weights > 0.0 { sum.map(|x| x / weights) } else { [0.0; 2] }, axis_here)
    }

    fn path_length(&self, to: u32, v: u32, beside: u32) -> f64 {
        let Some((at_v, ..)) = self.passed_vertex(v) else { return f64::INFINITY };
        // The path leads through the vertex `v`, or through the edge from `v` to `beside`.
        let over = at_v + self.surface.edge_length(v, to);
        let Some((at_beside, ..)) = self.passed_vertex(beside) else { return over };
        let [base, a, b] = [[v, beside], [v, to], [beside, to]].map(|[p, q]| self.surface.edge_length(p, q));
        over.min(unfold_distance([at_v, at_beside], base, [a, b]).unwrap_or(f64::INFINITY))
    }
}

/// Returns the distance of a triangle's tip from a source beyond its base, at `distances` from the base's ends.
fn unfold_distance(distances: [f64; 2], base: f64, sides: [f64; 2]) -> Option<f64> {
    let placed = |[p, q]: [f64; 2]| {
        let x = (p * p - q * q + base * base) / (2.0 * base);
        [x, (p * p - x * x).max(0.0).sqrt()]
    };
    let ([x, below], [tip_x, above]) = (placed(distances), placed(sides));
    let crossing = x + (tip_x - x) * below / (below + above);
    let crosses = base > 0.0 && below > 0.0 && above > 0.0 && (0.0..=base).contains(&crossing);
    // The straight line from the source to the tip may miss the base.
    crosses.then(|| (tip_x - x).hypot(above + below))
}

/// Returns the patches of samples with exact maps: each sample with its `kept` nearest others.
///
/// # Shapes
/// - `samples`: n distinct vertices; patches hold indices of samples
/// - returns n patches, shorter in small components
#[cfg(test)]
pub fn exact_patches(mesh: &TriMesh, samples: &[u32], kept: usize) -> Vec<Patch> {
    let all: Vec<u32> = (0..samples.len() as u32).collect();
    exact_patches_around(&WalkSurface::new(mesh), samples, &all, kept)
}

/// Returns the exact patches of the samples `centres`.
pub fn exact_patches_around(surface: &WalkSurface, samples: &[u32], centres: &[u32], kept: usize) -> Vec<Patch> {
    let mut sample_at = vec![u32::MAX; surface.positions.len()];
    samples.iter().zip(0..).for_each(|(&v, sample)| sample_at[v as usize] = sample);
    let patch = |i: usize| {
        let centre = centres[i];
        let is_sample = |v: u32| sample_at[v as usize] != u32::MAX;
        let found = surface.logarithmic_map(samples[centre as usize], kept, is_sample);
        let others = found.into_iter().map(|(v, at)| (sample_at[v as usize], at));
        let (points, map) = std::iter::once((centre, [0.0; 2])).chain(others).unzip();
        Patch { points, map }
    };
    parallel::map(centres.len(), 16, patch)
}

#[cfg(test)]
mod tests {
    use super::super::Turn;
    use super::*;
    use neural_mesh::mesh::shapes;

    fn error(found: &[(u32, [f64; 2])], expected: impl Fn(u32) -> [f64; 2]) -> f64 {
        let turn = Turn::fit(found.iter().map(|&(v, at)| (at, expected(v), 1.0)));
        let off = found.iter().map(|&(v, at)| {
            let (at, expected) = (turn.apply(at), expected(v));
            (at[0] - expected[0]).hypot(at[1] - expected[1]) / expected[0].hypot(expected[1])
        });
        off.fold(0.0, f64::max)
    }

    #[test]
    fn on_a_plane_it_is_exact() {
        let grid = shapes::grid(9, 7);
        let surface = WalkSurface::new(&grid);
        for source in [0, 31, 40] {
            let found = surface.logarithmic_map(source, 1000, |_| true);
            assert_eq!(found.len(), grid.positions().len() - 1);
            let origin = surface.positions[source as usize];
            let axes = (surface.first_axis(0), surface.normals[0].cross(surface.first_axis(0)));
            let expected = |v: u32| {
                let offset = surface.positions[v as usize] - origin;
                [axes.0.dot(offset), axes.1.dot(offset)]
            };
            assert!(error(&found, expected) < 1e-6);
        }
    }

    #[test]
    fn on_a_sphere_it_is_near_the_formula() {
        let sphere = shapes::icosphere(4);
        let surface = WalkSurface::new(&sphere);
        for source in [0, 77, 1234] {
            let n = surface.positions[source as usize].normalize();
            let expected = |v: u32| {
                let p = surface.positions[v as usize].normalize();
                let angle = n.dot(p).clamp(-1.0, 1.0).acos();
                let direction = (p - n * n.dot(p)).normalize() * angle;
                let x = n.any_orthonormal_vector();
                [x.dot(direction), n.cross(x).dot(direction)]
            };
            let found = surface.logarithmic_map(source, 150, |_| true);
            assert!(error(&found, expected) < 0.01, "{}", error(&found, expected));
            // 1000 vertices are two fifths of the sphere.
            let far = surface.logarithmic_map(source, 1000, |_| true);
            assert!(error(&far, expected) < 0.1, "{}", error(&far, expected));
        }
    }

    #[test]
    fn ways_go_around_a_slit() {
        // A plane without the triangles at a part of its middle line; the path leads around the end of the slit.
        let grid = shapes::grid(20, 20);
        let is_cut = |&v: &u32| v / 21 == 10 && v % 21 > 4;
        let faces = grid.faces().iter().filter(|face| !face.iter().any(is_cut)).copied().collect();
        let slit = TriMesh::new(grid.positions().to_vec(), faces).unwrap();
        let (from, to, unit) = (8 * 21 + 14, 12 * 21 + 14, grid.positions()[1][1]);
        let found = WalkSurface::new(&slit).logarithmic_map(from, 1, |v| v == to);
        let length = found[0].1[0].hypot(found[0].1[1]) / f64::from(unit);
        // The path passes the last vertices next to the cut: 2 |(1, 9)| + 2 |(1, 1)|.
        assert!((20.9..21.2).contains(&length), "{length}");
    }

    #[test]
    fn small_components_have_small_patches() {
        let boxes = shapes::many_boxes(2);
        let samples: Vec<u32> = (0..boxes.positions().len() as u32).collect();
        assert_eq!(WalkSurface::new(&boxes).logarithmic_map(0, 3, |v| v % 2 == 1).len(), 3);
        let patches = exact_patches(&boxes, &samples, 1000);
        assert!(patches.iter().all(|patch| patch.points.len() < samples.len()));
    }
}
