//! The logarithmic maps that the networks learn: exact ones, on the mesh from which the points were drawn.
//!
//! A front walks over the mesh from the patch's own point, nearest vertex first. Two things are carried along: the distance,
//! through unfolded triangles (Kimmel and Sethian 1998, in the form of Novotni and Klein 2002), and the sum of the steps in
//! tangent planes that are carried along with them (discrete exponential map: Schmidt, Grimm and Wyvill 2006), averaged over
//! all vertices behind the front. On a plane both are exact. The sum gives the place; where the distance is much longer, a
//! hole or a fold lies between, and the place is moved out to it.

use super::Patch;
use glam::DVec3;
use neural_mesh::mesh::{TriMesh, vertex_normals};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Where the way is longer than the sum of its steps by this factor, it went around something. On a sphere both stay closer
/// to each other than that over patches of any usual size.
const DETOUR: f64 = 1.1;

/// A surface on which one walks from vertex to vertex.
pub struct Surface {
    positions: Vec<DVec3>,
    normals: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// Where the faces around each vertex begin in `around`, n + 1.
    begins: Vec<u32>,
    around: Vec<u32>,
}

/// A vertex that the front has reached.
#[derive(Clone, Copy)]
struct Reached {
    distance: f64,
    /// Place in the map and first axis of the tangent plane, once the front has passed.
    passed: Option<([f64; 2], DVec3)>,
}

/// The front of a walk.
struct Front<'a> {
    surface: &'a Surface,
    reached: FxHashMap<u32, Reached>,
    /// By distance, whose bits order numbers that are not negative.
    waiting: BinaryHeap<Reverse<(u64, u32)>>,
}

impl Surface {
    /// The surface of a mesh.
    pub fn new(mesh: &TriMesh) -> Self {
        let n = mesh.positions().len();
        let mut begins = vec![0u32; n + 1];
        mesh.faces().as_flattened().iter().for_each(|&v| begins[v as usize + 1] += 1);
        (0..n).for_each(|v| begins[v + 1] += begins[v]);
        let (mut ends, mut around) = (begins.clone(), vec![0; 3 * mesh.faces().len()]);
        for (face, corners) in mesh.faces().iter().enumerate() {
            for &v in corners {
                around[ends[v as usize] as usize] = face as u32;
                ends[v as usize] += 1;
            }
        }
        let doubles = |rows: &[[f32; 3]]| rows.iter().map(|&row| glam::Vec3::from(row).as_dvec3()).collect();
        let normals: Vec<DVec3> = doubles(&vertex_normals(mesh));
        Self { positions: doubles(mesh.positions()), normals, faces: mesh.faces().to_vec(), begins, around }
    }

    fn faces_around(&self, v: u32) -> impl Iterator<Item = [u32; 3]> {
        let range = self.begins[v as usize] as usize..self.begins[v as usize + 1] as usize;
        self.around[range].iter().map(|&face| self.faces[face as usize])
    }

    fn edge_length(&self, a: u32, b: u32) -> f64 {
        self.positions[a as usize].distance(self.positions[b as usize])
    }

    /// Any unit vector in the tangent plane.
    fn first_axis(&self, v: u32) -> DVec3 {
        let normal = self.normals[v as usize];
        if normal == DVec3::ZERO { DVec3::X } else { normal.any_orthonormal_vector() }
    }

    /// An axis of the tangent plane at `from` as one at `to`: turned as the normals turn.
    fn carried(&self, axis: DVec3, from: u32, to: u32) -> DVec3 {
        let [n, m] = [from, to].map(|v| self.normals[v as usize]);
        let sum = 1.0 + n.dot(m);
        let carried = if sum > 1e-6 { axis - (n + m) * (m.dot(axis) / sum) } else { axis - m * m.dot(axis) };
        carried.normalize_or(axis)
    }

    /// A step along an edge in the tangent planes of both ends, of the edge's length.
    fn step(&self, from: u32, axis: DVec3, to: u32) -> [f64; 2] {
        let edge = self.positions[to as usize] - self.positions[from as usize];
        let carried = self.carried(axis, from, to);
        let seen = |axis: DVec3, v: u32| [axis.dot(edge), self.normals[v as usize].cross(axis).dot(edge)];
        let [a, b] = [seen(axis, from), seen(carried, to)];
        let both = [a[0] + b[0], a[1] + b[1]];
        let length = both[0].hypot(both[1]);
        if length > 0.0 { both.map(|x| x * edge.length() / length) } else { [0.0; 2] }
    }

    /// The `n` wanted vertices that a walk from `source` reaches first, with their places in the logarithmic map at the
    /// source; fewer where its component has fewer. The source is not among them.
    ///
    /// # Panics
    /// When there is no such vertex.
    ///
    /// ```
    /// use neural_mesh_bench::learned_baselines::dse::Surface;
    /// let grid = neural_mesh::mesh::shapes::grid(8, 8);
    /// let nearest = Surface::new(&grid).logarithmic_map(40, 3, |v| v % 2 == 1);
    /// assert_eq!(nearest.len(), 3);
    /// ```
    pub fn logarithmic_map(&self, source: u32, n: usize, is_wanted: impl Fn(u32) -> bool) -> Vec<(u32, [f64; 2])> {
        let mut front = Front { surface: self, reached: FxHashMap::default(), waiting: BinaryHeap::new() };
        front.reach(source, 0.0);
        let mut found = Vec::with_capacity(n);
        while found.len() < n {
            let Some(v) = front.nearest() else { break };
            let at = front.pass(v);
            if v != source && is_wanted(v) {
                found.push((v, at));
            }
        }
        found
    }
}

impl Front<'_> {
    /// Notes down a way to a vertex, where it is the shortest so far.
    fn reach(&mut self, v: u32, distance: f64) {
        let known = self.reached.entry(v).or_insert(Reached { distance: f64::INFINITY, passed: None });
        if known.passed.is_none() && distance < known.distance {
            known.distance = distance;
            self.waiting.push(Reverse((distance.to_bits(), v)));
        }
    }

    /// The nearest vertex that was not passed.
    fn nearest(&mut self) -> Option<u32> {
        while let Some(Reverse((_, v))) = self.waiting.pop() {
            if self.reached.get(&v).is_some_and(|known| known.passed.is_none()) {
                return Some(v);
            }
        }
        None
    }

    /// The distance of a vertex that was passed, with its place and axis.
    fn passed(&self, v: u32) -> Option<(f64, [f64; 2], DVec3)> {
        let known = self.reached.get(&v)?;
        known.passed.map(|(at, axis)| (known.distance, at, axis))
    }

    /// Passes a vertex, reaches those around it, and returns its place: at its distance where that is a detour.
    fn pass(&mut self, v: u32) -> [f64; 2] {
        let (at, axis) = self.placed(v);
        let distance = self.reached.get(&v).map_or(0.0, |known| known.distance);
        self.reached.insert(v, Reached { distance, passed: Some((at, axis)) });
        let faces: Vec<[u32; 3]> = self.surface.faces_around(v).collect();
        for face in faces {
            for i in 0..3 {
                let [a, b, c] = [face[i], face[(i + 1) % 3], face[(i + 2) % 3]];
                if a != v {
                    self.reach(a, self.through(a, v, if b == v { c } else { b }));
                }
            }
        }
        let length = at[0].hypot(at[1]);
        if distance > DETOUR * length && length > 0.0 { at.map(|x| x * distance / length) } else { at }
    }

    /// The mean of what the passed vertices around say, the nearer the more, and the axis of that with the shortest way.
    fn placed(&self, v: u32) -> ([f64; 2], DVec3) {
        let (mut sum, mut weights) = ([0.0; 2], 0.0);
        let (mut shortest, mut axis_here) = (f64::INFINITY, self.surface.first_axis(v));
        for p in self.surface.faces_around(v).flatten().filter(|&p| p != v) {
            let Some((distance, at, axis)) = self.passed(p) else { continue };
            let (step, length) = (self.surface.step(p, axis, v), self.surface.edge_length(p, v));
            let weight = 1.0 / length.max(1e-30);
            (0..2).for_each(|i| sum[i] += weight * (at[i] + step[i]));
            weights += weight;
            if distance + length < shortest {
                (shortest, axis_here) = (distance + length, self.surface.carried(axis, p, v));
            }
        }
        (if weights > 0.0 { sum.map(|x| x / weights) } else { [0.0; 2] }, axis_here)
    }

    /// The shortest way to `to` over the vertex `v` that was passed, or through the edge from it to `beside`.
    fn through(&self, to: u32, v: u32, beside: u32) -> f64 {
        let Some((at_v, ..)) = self.passed(v) else { return f64::INFINITY };
        let over = at_v + self.surface.edge_length(v, to);
        let Some((at_beside, ..)) = self.passed(beside) else { return over };
        let [base, a, b] = [[v, beside], [v, to], [beside, to]].map(|[p, q]| self.surface.edge_length(p, q));
        over.min(unfolded([at_v, at_beside], base, [a, b]).unwrap_or(f64::INFINITY))
    }
}

/// The distance of a triangle's tip from a source that lies `distances` away from the ends of its base, in the plane of the
/// triangle on the other side of the base; `None` where the straight way does not cross the base.
fn unfolded(distances: [f64; 2], base: f64, sides: [f64; 2]) -> Option<f64> {
    let placed = |[p, q]: [f64; 2]| {
        let x = (p * p - q * q + base * base) / (2.0 * base);
        [x, (p * p - x * x).max(0.0).sqrt()]
    };
    let ([x, below], [tip_x, above]) = (placed(distances), placed(sides));
    let crossing = x + (tip_x - x) * below / (below + above);
    let crosses = base > 0.0 && below > 0.0 && above > 0.0 && (0.0..=base).contains(&crossing);
    crosses.then(|| (tip_x - x).hypot(above + below))
}

/// The patches of samples of a mesh, with exact maps: for each sample the `kept` nearest others along the surface.
///
/// # Shapes
/// - `samples`: n vertices of the mesh, each once; patches name samples by their places among them
/// - returns n patches, shorter ones where a component has fewer samples
///
/// ```
/// use neural_mesh_bench::learned_baselines::dse::exact_patches;
/// let sphere = neural_mesh::mesh::shapes::icosphere(3);
/// let patches = exact_patches(&sphere, &[0, 5, 9, 300], 2);
/// assert!(patches.iter().all(|patch| patch.points.len() == 3 && patch.map[0] == [0.0; 2]));
/// ```
pub fn exact_patches(mesh: &TriMesh, samples: &[u32], kept: usize) -> Vec<Patch> {
    let all: Vec<u32> = (0..samples.len() as u32).collect();
    exact_patches_at(&Surface::new(mesh), samples, &all, kept)
}

/// The patches of some of the samples, `centres`.
pub fn exact_patches_at(surface: &Surface, samples: &[u32], centres: &[u32], kept: usize) -> Vec<Patch> {
    let mut sample_at = vec![u32::MAX; surface.positions.len()];
    samples.iter().zip(0..).for_each(|(&v, sample)| sample_at[v as usize] = sample);
    let patch = |&centre: &u32| {
        let is_sample = |v: u32| sample_at[v as usize] != u32::MAX;
        let found = surface.logarithmic_map(samples[centre as usize], kept, is_sample);
        let others = found.into_iter().map(|(v, at)| (sample_at[v as usize], at));
        let (points, map) = std::iter::once((centre, [0.0; 2])).chain(others).unzip();
        Patch { points, map }
    };
    centres.par_iter().map(patch).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Turn;
    use super::*;
    use neural_mesh::mesh::shapes;

    fn error(found: &[(u32, [f64; 2])], expected: impl Fn(u32) -> [f64; 2]) -> f64 {
        let turn = Turn::between(found.iter().map(|&(v, at)| (at, expected(v), 1.0)));
        let off = found.iter().map(|&(v, at)| {
            let (at, expected) = (turn.apply(at), expected(v));
            (at[0] - expected[0]).hypot(at[1] - expected[1]) / expected[0].hypot(expected[1])
        });
        off.fold(0.0, f64::max)
    }

    #[test]
    fn on_a_plane_it_is_exact() {
        let grid = shapes::grid(9, 7);
        let surface = Surface::new(&grid);
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
        let surface = Surface::new(&sphere);
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
            // Two fifths of the sphere.
            let far = surface.logarithmic_map(source, 1000, |_| true);
            assert!(error(&far, expected) < 0.1, "{}", error(&far, expected));
        }
    }

    #[test]
    fn ways_go_around_a_slit() {
        // A plane without the triangles at a part of its middle line: from one side to the other around the end.
        let grid = shapes::grid(20, 20);
        let is_cut = |&v: &u32| v / 21 == 10 && v % 21 > 4;
        let faces = grid.faces().iter().filter(|face| !face.iter().any(is_cut)).copied().collect();
        let slit = TriMesh::new(grid.positions().to_vec(), faces).unwrap();
        let (from, to, unit) = (8 * 21 + 14, 12 * 21 + 14, grid.positions()[1][1]);
        let found = Surface::new(&slit).logarithmic_map(from, 1, |v| v == to);
        let length = found[0].1[0].hypot(found[0].1[1]) / f64::from(unit);
        // Past the last vertices beside the cut: 2 |(1, 9)| + 2 |(1, 1)|.
        assert!((20.9..21.2).contains(&length), "{length}");
    }

    #[test]
    fn small_components_have_small_patches() {
        let boxes = shapes::many_boxes(2);
        let samples: Vec<u32> = (0..boxes.positions().len() as u32).collect();
        let patches = exact_patches(&boxes, &samples, 1000);
        assert!(patches.iter().all(|patch| patch.points.len() < samples.len()));
    }
}
