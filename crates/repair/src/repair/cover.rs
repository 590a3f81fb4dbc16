//! Triangulates one loop of edges in space, without new vertices.
//!
//! Short loops: dynamic programming in O(n^3) minimises the largest bend, then the area (Barequet and Sharir 1995,
//! "Filling gaps in the boundary of a polyhedron"; Liepa 2003, "Filling holes in meshes", Sec. 3). Longer flat loops
//! are triangulated in their plane. From others, short and flat ears are clipped first.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::DVec3;

use crate::geometry::polygon::triangulate;
use crate::geometry::triangle::area_normal_f64;

/// Step to which bends (1 minus the cosine) are rounded; within a step, area decides.
const BEND_STEP: f64 = 1.0 / 256.0;
/// Penalty, above any bend, of a new edge that the mesh already has.
const KNOWN_EDGE: f64 = 4.0;
/// Largest distance of a flat loop's vertices from its plane, relative to the loop's size.
const FLAT: f64 = 0.05;

pub(super) struct Outline<'a> {
    /// Vertices, n x 3.
    pub points: Vec<DVec3>,
    /// Unit normals, or zero, of the faces at the loop's edges, n x 3; edge `i` starts at vertex `i`.
    pub normals: Vec<DVec3>,
    /// Returns whether the mesh has an edge between two vertices.
    pub is_edge: &'a (dyn Fn(u32, u32) -> bool + Sync),
}

/// Triangulates a loop into n - 2 triangles wound against it; optimally up to `n_best` edges.
pub(super) fn cover(outline: &Outline, n_best: usize) -> Vec<[u32; 3]> {
    let n = outline.points.len() as u32;
    if n as usize <= n_best.max(3) {
        return best_cover(outline, &(0..n).collect::<Vec<_>>(), &outline.normals);
    }
    if is_flat(&outline.points) {
        // Triangles are wound against the loop.
        let reversed: Vec<[f64; 3]> = outline.points.iter().rev().map(|p| p.to_array()).collect();
        return triangulate(&reversed).into_iter().map(|triangle| triangle.map(|i| n - 1 - i)).collect();
    }
    LoopEars::new(outline).clip(n_best.max(3))
}

fn is_flat(points: &[DVec3]) -> bool {
    let middle = points.iter().sum::<DVec3>() / points.len() as f64;
    let spokes = || points.iter().map(|&p| p - middle);
    let size = spokes().map(DVec3::length).fold(0.0, f64::max);
    let normal: DVec3 = spokes().zip(spokes().cycle().skip(1)).map(|(p, q)| p.cross(q)).sum();
    let normal = normal.normalize_or_zero();
    normal != DVec3::ZERO && spokes().all(|p| p.dot(normal).abs() <= FLAT * size)
}

/// Returns the normal over three vertices in loop order, wound against the loop, with twice the area as length.
fn normal_over([a, b, c]: [DVec3; 3]) -> DVec3 {
    area_normal_f64([a, c, b])
}

fn bend(a: DVec3, b: DVec3) -> f64 {
    1.0 - a.dot(b)
}

/// The cost of a sub-loop's best triangulation, and the triangle at its closing edge.
#[derive(Clone, Copy)]
struct PartialCover {
    bend: f64,
    area: f64,
    third: u32,
    normal: DVec3,
}

/// Triangulates a ring with the least bend, then least area; `normals` are those of the faces at its edges.
fn best_cover(outline: &Outline, ring: &[u32], normals: &[DVec3]) -> Vec<[u32; 3]> {
    let n = ring.len();
    let points: Vec<DVec3> = ring.iter().map(|&i| outline.points[i as usize]).collect();
    let edge = |i: usize| PartialCover { bend: 0.0, area: 0.0, third: u32::MAX, normal: normals[i] };
    let mut covers = vec![edge(0); n * n];
    (0..n - 1).for_each(|i| covers[i * n + i + 1] = edge(i));
    // Shorter sub-loops first: each is an edge, a triangle and two shorter ones.
    for span in 2..n {
        for i in 0..n - span {
            let k = i + span;
            let mut least = PartialCover { bend: f64::INFINITY, area: f64::INFINITY, ..edge(0) };
            let is_all = span == n - 1;
            // The last edge closes the loop and exists in any case.
            let known = if !is_all && (outline.is_edge)(ring[i], ring[k]) { KNOWN_EDGE } else { 0.0 };
            for j in i + 1..k {
                let (left, right) = (&covers[i * n + j], &covers[j * n + k]);
                let normal = normal_over([points[i], points[j], points[k]]);
                let area = left.area + right.area + normal.length();
                let normal = normal.normalize_or_zero();
                let here = bend(normal, left.normal).max(bend(normal, right.normal));
                let here = if is_all { here.max(bend(normal, normals[n - 1])) } else { here };
                // Rounding lets area decide among bends that look alike.
                let here = (here / BEND_STEP).round() * BEND_STEP + known;
                let bend = here.max(left.bend).max(right.bend);
                if (bend, area) < (least.bend, least.area) {
                    least = PartialCover { bend, area, third: j as u32, normal };
                }
            }
            covers[i * n + k] = least;
        }
    }
    collect_triangles(n, ring, &covers)
}

fn collect_triangles(n: usize, ring: &[u32], covers: &[PartialCover]) -> Vec<[u32; 3]> {
    let mut triangles = Vec::with_capacity(n - 2);
    let mut left = vec![(0, n - 1)];
    while let Some((i, k)) = left.pop() {
        if k - i < 2 {
            continue;
        }
        // With infinite areas no triangle is better than none; then any will do.
        let third = covers[i * n + k].third as usize;
        let j = if (i + 1..k).contains(&third) { third } else { i + 1 };
        triangles.push([ring[i], ring[k], ring[j]]);
        left.extend([(i, j), (j, k)]);
    }
    triangles
}

struct LoopEars<'a> {
    outline: &'a Outline<'a>,
    next: Vec<u32>,
    previous: Vec<u32>,
    normals: Vec<DVec3>,
    changes: Vec<u32>,
}

impl<'a> LoopEars<'a> {
    fn new(outline: &'a Outline<'a>) -> Self {
        let n = outline.points.len() as u32;
        let next = (1..n).chain([0]).collect();
        let previous = [n - 1].into_iter().chain(0..n - 1).collect();
        Self { outline, next, previous, normals: outline.normals.clone(), changes: vec![0; n as usize] }
    }

    fn ear(&self, vertex: u32) -> [u32; 3] {
        [self.previous[vertex as usize], vertex, self.next[vertex as usize]]
    }

    fn normal(&self, vertex: u32) -> DVec3 {
        normal_over(self.ear(vertex).map(|i| self.outline.points[i as usize])).normalize_or_zero()
    }

    /// Returns an ear's cost as sortable bits: the new edge's squared length, increased by bend.
    fn cost(&self, vertex: u32) -> u64 {
        let [before, _, after] = self.ear(vertex);
        let normal = self.normal(vertex);
        let [one, other] = [before, vertex].map(|i| bend(normal, self.normals[i as usize]));
        let known = if (self.outline.is_edge)(before, after) { KNOWN_EDGE } else { 0.0 };
        let length2 = self.outline.points[before as usize].distance_squared(self.outline.points[after as usize]);
        let bent = one.max(other) + known;
        (length2 * (1.0 + bent * bent * bent * bent)).to_bits()
    }

    fn clip(mut self, n_best: usize) -> Vec<[u32; 3]> {
        let mut n_left = self.next.len();
        let mut queue: BinaryHeap<Reverse<(u64, u32, u32)>> =
            (0..n_left as u32).map(|vertex| Reverse((self.cost(vertex), vertex, 0))).collect();
        let mut triangles = Vec::with_capacity(n_left - 2);
        while let Some(Reverse((_, vertex, change))) = queue.pop().filter(|_| n_left > n_best) {
            // Outdated entry: a neighbour was clipped since.
            if self.changes[vertex as usize] != change {
                continue;
            }
            let [before, _, after] = self.ear(vertex);
            triangles.push([before, after, vertex]);
            // The clipped triangle is now the face across the new edge.
            self.normals[before as usize] = self.normal(vertex);
            self.next[before as usize] = after;
            self.previous[after as usize] = before;
            self.changes[vertex as usize] = u32::MAX;
            n_left -= 1;
            for changed in [before, after] {
                self.changes[changed as usize] += 1;
                queue.push(Reverse((self.cost(changed), changed, self.changes[changed as usize])));
            }
        }
        // The remaining ring is short enough for the optimum.
        let ring: Vec<u32> = (0..self.next.len() as u32).filter(|&v| self.changes[v as usize] != u32::MAX).collect();
        let normals: Vec<DVec3> = ring.iter().map(|&v| self.normals[v as usize]).collect();
        triangles.extend(best_cover(self.outline, &ring, &normals));
        triangles
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BEST: usize = 64;

    fn outline(points: Vec<DVec3>) -> Outline<'static> {
        let normals = vec![DVec3::ZERO; points.len()];
        Outline { points, normals, is_edge: &|_, _| false }
    }

    fn is_cover(n: u32, triangles: &[[u32; 3]]) -> bool {
        let mut sides: Vec<[u32; 2]> = triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        sides.extend((0..n).map(|i| [i, (i + 1) % n]));
        let mut turned: Vec<[u32; 2]> = sides.iter().map(|&[a, b]| [b, a]).collect();
        sides.sort_unstable();
        turned.sort_unstable();
        triangles.len() as u32 == n - 2 && sides == turned && sides.windows(2).all(|pair| pair[0] != pair[1])
    }

    fn area(points: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
        triangles.iter().map(|t| 0.5 * area_normal_f64(t.map(|i| points[i as usize])).length()).sum()
    }

    fn naive(outline: &Outline, i: usize, k: usize) -> (f64, f64, DVec3) {
        let n = outline.points.len();
        if k == i + 1 {
            return (0.0, 0.0, outline.normals[i]);
        }
        let cover_with = |j: usize| {
            let (left, right) = (naive(outline, i, j), naive(outline, j, k));
            let normal = area_normal_f64([outline.points[i], outline.points[k], outline.points[j]]);
            let unit = normal.normalize_or_zero();
            let mut here = bend(unit, left.2).max(bend(unit, right.2));
            if k - i == n - 1 {
                here = here.max(bend(unit, outline.normals[n - 1]));
            }
            let here = (here / BEND_STEP).round() * BEND_STEP;
            (here.max(left.0).max(right.0), left.1 + right.1 + normal.length(), unit)
        };
        (i + 1..k).map(cover_with).min_by(|a, b| (a.0, a.1).partial_cmp(&(b.0, b.1)).unwrap()).unwrap()
    }

    fn largest_bend(outline: &Outline, triangles: &[[u32; 3]]) -> f64 {
        let n = outline.points.len() as u32;
        let normal = |t: &[u32; 3]| area_normal_f64(t.map(|i| outline.points[i as usize])).normalize_or_zero();
        let sides = |t: &[u32; 3]| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
        let mut most = 0.0f64;
        for t in triangles {
            for [a, b] in sides(t) {
                let other = triangles.iter().find(|t| sides(t).contains(&[b, a])).map(normal);
                let beyond = other.or_else(|| (a == (b + 1) % n).then(|| outline.normals[b as usize]));
                most = most.max(beyond.map_or(0.0, |beyond| bend(normal(t), beyond)));
            }
        }
        (most / BEND_STEP).round() * BEND_STEP
    }

    proptest! {
        #[test]
        fn it_is_what_the_recurrence_says(
            points in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 3..8),
            normals in prop::collection::vec(prop::array::uniform3(-1.0f64..1.0), 8),
        ) {
            let points: Vec<DVec3> = points.into_iter().map(DVec3::from).collect();
            let normals = normals.into_iter().take(points.len()).map(|n| DVec3::from(n).normalize_or_zero()).collect();
            let outline = Outline { points, normals, is_edge: &|_, _| false };
            let n = outline.points.len() as u32;
            let found = cover(&outline, BEST);
            prop_assert!(is_cover(n, &found));
            let least = naive(&outline, 0, n as usize - 1);
            let found = (largest_bend(&outline, &found), 2.0 * area(&outline.points, &found));
            prop_assert!(found.0 == least.0 && (found.1 - least.1).abs() < 1e-9, "{found:?} {least:?}");
        }

        #[test]
        fn any_loop_is_covered(points in prop::collection::vec(prop::array::uniform3(-3i8..3), 3..120), n_best in 3usize..40) {
            let points: Vec<DVec3> = points.into_iter().map(|p| DVec3::from(p.map(f64::from))).collect();
            let n = points.len() as u32;
            prop_assert!(is_cover(n, &cover(&outline(points), n_best)));
        }
    }

    fn ring(n: usize, at: impl Fn(f64) -> [f64; 3]) -> Vec<DVec3> {
        (0..n).map(|i| DVec3::from(at(std::f64::consts::TAU * i as f64 / n as f64))).collect()
    }

    #[test]
    fn a_disc_is_covered_exactly_by_each_way() {
        let disc = |n| ring(n, |t| [t.cos(), t.sin(), 0.0]);
        for n in [6, 60, 600] {
            let triangles = cover(&outline(disc(n)), BEST);
            let exact = 0.5 * n as f64 * (std::f64::consts::TAU / n as f64).sin();
            assert!(is_cover(n as u32, &triangles) && (area(&disc(n), &triangles) - exact).abs() < 1e-9, "{n}");
        }
        // Wound against the loop.
        let [a, b, c] = cover(&outline(disc(6)), BEST)[0].map(|i| disc(6)[i as usize]);
        assert!(area_normal_f64([a, b, c]).z < 0.0);
    }

    #[test]
    fn a_long_loop_that_lies_in_no_plane_is_covered_by_little_more_than_its_surface() {
        // A saddle, whose area within the loop is known from its height.
        let saddle = ring(5000, |t| [t.cos(), t.sin(), 0.5 * (2.0 * t).cos()]);
        assert!(!is_flat(&saddle));
        let triangles = cover(&outline(saddle.clone()), BEST);
        assert!(is_cover(5000, &triangles));
        assert!(area(&saddle, &triangles) < 5.5, "{}", area(&saddle, &triangles));
    }

    #[test]
    fn an_edge_that_is_there_is_not_made_again() {
        let square = ring(4, |t| [t.cos(), t.sin(), 0.0]);
        for diagonal in [[0, 2], [1, 3]] {
            let is_edge = |a: u32, b: u32| [a.min(b), a.max(b)] == diagonal;
            let outline = Outline { is_edge: &is_edge, ..outline(square.clone()) };
            assert!(cover(&outline, BEST).iter().all(|t| !(t.contains(&diagonal[0]) && t.contains(&diagonal[1]))));
        }
    }

    #[test]
    fn a_hundred_thousand_edges_take_no_longer_than_their_number() {
        for height in [0.0, 1.0] {
            let long = ring(100_000, |t| [t.cos(), t.sin(), height * (9.0 * t).cos()]);
            assert!(is_cover(100_000, &cover(&outline(long), 256)));
        }
    }
}
