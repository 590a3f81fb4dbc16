//! The regions of the samples: what they sum up to, and the sweeps that move their borders.
//!
//! The sweeps are the discrete Voronoi clustering of Valette and Chassery (2004) with the quadric energy: a
//! vertex goes to a neighbouring region where that lowers the sum of the two regions' errors, each at its own
//! best placement. Most vertices stay, which is seen without placing anything anew: by the rule of Hartigan (1975), what
//! a vertex costs where regions stand counts more in the one that it leaves than in the one that it would join.

use std::ops::{AddAssign, SubAssign};

use glam::{DVec3, Vec3, Vec4};

use crate::geometry::Quadric;
use crate::mesh::shares::add_to_rows;

use super::darts::Assignment;
use super::surface::Surface;

/// Weight of the distance to the region's vertices against that to its planes; keeps every minimum unique.
const SWEEP_PULL: f32 = 1e-3;

/// Weighted sums over the vertices of a region.
#[derive(Clone, Copy, Default)]
pub(super) struct Sum {
    /// The planes.
    pub planes: Quadric,
    /// The weights: areas times importance.
    pub weight: f64,
    /// Weighted sum of the positions.
    pub position: DVec3,
    /// Weighted sum of the squared positions.
    pub squared: f64,
    /// Weighted sum of the normals.
    pub normal: DVec3,
}

impl Sum {
    /// The sum over one vertex.
    pub fn of(surface: &Surface, v: usize) -> Self {
        let weight = surface.weight(v);
        let p = surface.positions[v].as_dvec3();
        Self {
            planes: Quadric::around(surface.quadrics[v], surface.positions[v]),
            weight,
            position: p * weight,
            squared: p.length_squared() * weight,
            normal: surface.normals[v].as_dvec3() * weight,
        }
    }

    /// The planes, and the distances to the vertices with `pull` times their weight.
    pub fn quadric(&self, pull: f64) -> Quadric {
        let mut sum = self.planes;
        [0, 3, 5].into_iter().for_each(|diagonal| sum.a[diagonal] += pull * self.weight);
        sum.b += self.position * pull;
        sum.c += self.squared * pull;
        sum
    }

    /// The mean of the vertices.
    pub fn mean(&self) -> DVec3 {
        self.position / self.weight
    }

    /// Mean squared distance of the vertices from their mean.
    pub fn variance(&self) -> f64 {
        (self.squared / self.weight - self.mean().length_squared()).max(0.0)
    }
}

impl AddAssign for Sum {
    fn add_assign(&mut self, other: Self) {
        self.planes += other.planes;
        self.weight += other.weight;
        self.position += other.position;
        self.squared += other.squared;
        self.normal += other.normal;
    }
}

impl SubAssign for Sum {
    fn sub_assign(&mut self, other: Self) {
        self.planes -= other.planes;
        self.weight -= other.weight;
        self.position -= other.position;
        self.squared -= other.squared;
        self.normal -= other.normal;
    }
}

/// The sums of all regions.
pub(super) fn sums(surface: &Surface, assignment: &Assignment) -> Vec<Sum> {
    let mut sums = vec![Sum::default(); assignment.n_regions];
    add_to_rows(&mut sums, &assignment.region, |sum, v| *sum += Sum::of(surface, v));
    sums
}

/// Moves border vertices between regions while that lowers their errors, at most `n_sweeps` times over the vertices that
/// are due, and keeps the sums of the regions in step.
///
/// Regions stay discs: a vertex moves only where it is a simple point of both regions.
pub(super) fn sweep(
    surface: &Surface,
    assignment: &mut Assignment,
    sums: &mut [Sum],
    n_sweeps: usize,
    mut due: Vec<bool>,
) {
    let (centres, errors) =
        sums.iter().map(|&sum| Region::new(sum)).map(|region| (region.centre, region.error)).unzip();
    let mut state = Sweep { surface, region: &mut assignment.region, sums, centres, errors };
    for _ in 0..n_sweeps {
        let mut next = vec![false; surface.n_vertices()];
        for v in 0..surface.n_vertices() as u32 {
            if due[v as usize] && state.improve(v) {
                next[v as usize] = true;
                surface.neighbors(v).iter().for_each(|&w| next[w as usize] = true);
            }
        }
        due = next;
    }
}

/// A region with its vertex.
struct Region {
    sum: Sum,
    /// Where its vertex would go, and its weight; not a number where nothing says.
    centre: Vec4,
    error: f64,
}

impl Region {
    fn new(sum: Sum) -> Self {
        let (x, error) = sum.quadric(f64::from(SWEEP_PULL)).minimum().unwrap_or((DVec3::NAN, 0.0));
        Self { sum, centre: x.as_vec3().extend(sum.weight as f32), error }
    }
}

struct Sweep<'a> {
    surface: &'a Surface<'a>,
    region: &'a mut Vec<u32>,
    sums: &'a mut [Sum],
    centres: Vec<Vec4>,
    errors: Vec<f64>,
}

impl Sweep<'_> {
    /// Moves `v` to the region where it costs least, if that is another than its own.
    fn improve(&mut self, v: u32) -> bool {
        let own = self.region[v as usize];
        let vertex = Vertex::of(self.surface, v);
        let (cost, label) = self.cheapest(&vertex, v, own);
        let is_less = cost < vertex.cost(self.centres[own as usize], -1.0);
        if !is_less {
            return false;
        }
        if !self.touches_once(v, own) || !self.touches_once(v, label) {
            return false;
        }
        let moved = Sum::of(self.surface, v as usize);
        let (mut without, mut with) = (self.sums[own as usize], self.sums[label as usize]);
        without -= moved;
        with += moved;
        let (without, with) = (Region::new(without), Region::new(with));
        let before = self.errors[own as usize] + self.errors[label as usize];
        let pays = without.error + with.error < before;
        if !pays {
            return false;
        }
        for (r, region) in [(own, without), (label, with)] {
            let r = r as usize;
            (self.sums[r], self.centres[r], self.errors[r]) = (region.sum, region.centre, region.error);
        }
        self.region[v as usize] = label;
        true
    }

    /// The neighbouring region that `v` would cost least in, and that cost.
    fn cheapest(&self, vertex: &Vertex, v: u32, own: u32) -> (f32, u32) {
        let mut best = (f32::INFINITY, own);
        for label in self.surface.neighbors(v).iter().map(|&w| self.region[w as usize]) {
            let cost = vertex.cost(self.centres[label as usize], 1.0);
            best = if label != own && cost < best.0 { (cost, label) } else { best };
        }
        best
    }

    /// Whether the neighbours of `v` with this label follow one another.
    fn touches_once(&self, v: u32, label: u32) -> bool {
        let has = |w: u32| self.region.get(w as usize).is_some_and(|&there| there == label);
        let ring = self.surface.rings.ring(v);
        let mut before = ring.last().is_some_and(|&w| has(w));
        let mut n_begins = 0;
        for &w in ring {
            let here = has(w);
            n_begins += u32::from(here && !before);
            before = here;
        }
        n_begins == 1
    }
}

/// A vertex as the regions see it.
struct Vertex {
    quadric: [f32; 6],
    position: Vec3,
    weight: f32,
}

impl Vertex {
    fn of(surface: &Surface, v: u32) -> Self {
        let mut quadric = surface.quadrics[v as usize];
        let weight = quadric[0] + quadric[3] + quadric[5];
        [0, 3, 5].into_iter().for_each(|diagonal| quadric[diagonal] += SWEEP_PULL * weight);
        Self { quadric, position: surface.positions[v as usize], weight }
    }

    /// What the vertex adds to the error of a region that it joins (1) or belongs to (-1): its planes' distance from the
    /// region's vertex, less what that vertex gives way.
    fn cost(&self, centre: Vec4, sign: f32) -> f32 {
        let [xx, xy, xz, yy, yz, zz] = self.quadric;
        let Vec3 { x, y, z } = centre.truncate() - self.position;
        let distance = x * (xx * x + 2.0 * (xy * y + xz * z)) + y * (yy * y + 2.0 * yz * z) + zz * z * z;
        distance * centre.w / (centre.w + sign * self.weight).max(f32::MIN_POSITIVE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::simplify::closed::darts::throw_darts;
    use crate::simplify::closed::edge_lengths::EdgeLengths;
    use std::collections::HashSet;

    fn total_energy(surface: &Surface, assignment: &Assignment) -> f64 {
        let energy = |sum: &Sum| sum.quadric(f64::from(SWEEP_PULL)).minimum().map_or(0.0, |(_, energy)| energy);
        sums(surface, assignment).iter().map(energy).sum()
    }

    /// The naive twin of the simple-point test: a region of a closed surface is a disc.
    fn is_disc(surface: &Surface, assignment: &Assignment, region: u32) -> bool {
        let inside = |v: u32| assignment.region[v as usize] == region;
        let vertices: Vec<u32> = (0..surface.n_vertices() as u32).filter(|&v| inside(v)).collect();
        let mut edges = HashSet::new();
        let mut n_faces = 0;
        for &[a, b, c] in surface.faces.iter() {
            let within = |&[u, v]: &[u32; 2]| inside(u) && inside(v);
            edges.extend([[a, b], [b, c], [c, a]].into_iter().filter(within).map(|[u, v]| [u.min(v), u.max(v)]));
            n_faces += i64::from([a, b, c].into_iter().all(inside));
        }
        let mut reached = HashSet::from([vertices[0]]);
        let mut pending = vec![vertices[0]];
        while let Some(v) = pending.pop() {
            let joined = surface.neighbors(v).iter().filter(|&&w| inside(w));
            pending.extend(joined.filter(|&&w| reached.insert(w)));
        }
        reached.len() == vertices.len() && vertices.len() as i64 - edges.len() as i64 + n_faces == 1
    }

    #[test]
    fn sweeps_lower_the_energy_and_keep_discs() {
        for (mesh, n) in [(shapes::wavy_sphere(3, 10.0), 60), (shapes::torus(32, 12, 1.0, 0.3), 40)] {
            let surface = Surface::new(&mesh);
            let lengths = EdgeLengths::new(&surface);
            for seed in 0..3 {
                let mut assignment = throw_darts(&surface, &lengths, n, seed);
                let discs = |a: &Assignment| -> Vec<bool> {
                    (0..a.n_regions as u32).map(|r| is_disc(&surface, a, r)).collect()
                };
                let (before, discs_before) = (total_energy(&surface, &assignment), discs(&assignment));
                let mut before_and_after = sums(&surface, &assignment);
                sweep(&surface, &mut assignment, &mut before_and_after, 2, vec![true; surface.n_vertices()]);
                let after = total_energy(&surface, &assignment);
                assert!(after < 0.9 * before, "{before} {after}");
                let still: Vec<bool> = discs(&assignment);
                assert!(discs_before.iter().zip(still).all(|(before, after)| !before || after));
            }
        }
    }
}
