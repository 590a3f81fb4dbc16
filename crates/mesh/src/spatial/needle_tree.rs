//! A tree of oriented boxes for thin triangles, which axis-parallel boxes cannot separate in a fan.
//!
//! Boxes follow the principal axes of the corners (Gottschalk, Lin and Manocha 1996, "OBBTree").

use glam::DVec3;

use crate::geometry::extent;
use crate::geometry::triangle::{area_normal_f64, corners_f64};
use crate::parallel;

const LEAF: usize = 4;
const MARGIN: f64 = 1e-13;
const SLACK: f64 = 1e-9;
const SWEEPS: usize = 5;
const PARALLEL: usize = 4096;
const WAITING: usize = 40;

pub(super) struct NeedleTree {
    /// Nodes, each followed by the nodes of its first half, then of its second.
    nodes: Vec<NeedleNode>,
    triangles: Vec<u32>,
}

#[derive(Clone, Copy, Default)]
struct NeedleNode {
    middle: DVec3,
    axes: [DVec3; 3],
    half: DVec3,
    first: u32,
    len: u32,
}

#[derive(Clone, Copy)]
struct NeedleItem {
    corners: [DVec3; 3],
    centroid: DVec3,
    triangle: u32,
}

impl NeedleTree {
    /// Builds the tree over triangles with coordinates of about one at most.
    pub(super) fn new(triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Self {
        let item = |(corners, triangle): ([[f32; 3]; 3], u32)| {
            let corners = corners_f64(corners);
            NeedleItem { corners, centroid: (corners[0] + corners[1] + corners[2]) / 3.0, triangle }
        };
        let mut items: Vec<NeedleItem> = triangles.zip(0..).map(item).collect();
        let mut nodes = vec![NeedleNode::default(); if items.is_empty() { 0 } else { n_nodes(items.len()) }];
        grow(&mut nodes, &mut items, [0, 0]);
        Self { nodes, triangles: items.iter().map(|item| item.triangle).collect() }
    }

    /// Visits leaves within a squared bound of a point, roughly nearest first; returns the number of boxes tested.
    ///
    /// `visit` returns the new bound.
    #[inline(always)]
    pub(super) fn visit_near(&self, p: DVec3, bound: f64, visit: impl FnMut(&[u32]) -> f64) -> u32 {
        self.descend(0.0, |node| node.distance2(p), bound, visit)
    }

    /// Visits leaves whose box a triangle may meet.
    pub(super) fn visit_touching(&self, corners: [DVec3; 3], mut visit: impl FnMut(&[u32])) {
        let [a, b, c] = corners;
        let normal = area_normal_f64(corners);
        let across = [normal, normal.cross(b - a), normal.cross(c - b), normal.cross(a - c)];
        let across = across.map(DVec3::normalize_or_zero);
        let distance = |node: &NeedleNode| if node.is_apart(&corners, &across) { f64::INFINITY } else { 0.0 };
        let root = self.nodes.first().map_or(0.0, distance);
        self.descend(root, distance, 0.0, |leaf| {
            visit(leaf);
            0.0
        });
    }

    /// Visits leaves within a bound, of two halves the nearer first; `visit` returns the new bound.
    #[inline(always)]
    fn descend(
        &self,
        root: f64,
        distance: impl Fn(&NeedleNode) -> f64,
        mut bound: f64,
        mut visit: impl FnMut(&[u32]) -> f64,
    ) -> u32 {
        let mut waiting = [(root, 0u32); WAITING];
        let (mut n_waiting, mut n_visits) = (usize::from(!self.nodes.is_empty()), 0);
        while n_waiting > 0 {
            n_waiting -= 1;
            let (nearest, at) = waiting[n_waiting];
            if nearest > bound * (1.0 + SLACK) {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.len > 0 {
                bound = visit(&self.triangles[node.first as usize..(node.first + node.len) as usize]);
                continue;
            }
            n_visits += 2;
            let halves = [at + 1, node.first].map(|half| (distance(&self.nodes[half as usize]), half));
            let [near, far] = if halves[1].0 < halves[0].0 { [halves[1], halves[0]] } else { halves };
            (waiting[n_waiting], waiting[n_waiting + 1]) = (far, near);
            n_waiting += 2;
        }
        n_visits
    }
}

impl NeedleNode {
    #[inline(always)]
    fn distance2(&self, p: DVec3) -> f64 {
        let from_middle = p - self.middle;
        let along = DVec3::from(self.axes.map(|axis| axis.dot(from_middle)));
        (along.abs() - self.half).max(DVec3::ZERO).length_squared()
    }

    /// Returns whether a side of the box, or a direction `across` the triangle, separates the two.
    fn is_apart(&self, corners: &[DVec3; 3], across: &[DVec3; 4]) -> bool {
        let corners = corners.map(|corner| corner - self.middle);
        let is_between = |axis: DVec3, half: f64| {
            let [a, b, c] = corners.map(|corner| corner.dot(axis));
            a.min(b).min(c) <= half && a.max(b).max(c) >= -half
        };
        let half_along = |axis: DVec3| (0..3).map(|k| self.half[k] * self.axes[k].dot(axis).abs()).sum::<f64>();
        !(0..3).all(|k| is_between(self.axes[k], self.half[k]))
            || !across.iter().all(|&axis| is_between(axis, half_along(axis)))
    }
}

fn n_nodes(n: usize) -> usize {
    if n <= LEAF { 1 } else { 1 + n_nodes(n / 2) + n_nodes(n - n / 2) }
}

fn grow(nodes: &mut [NeedleNode], items: &mut [NeedleItem], [at, start]: [usize; 2]) {
    let Some((own, below)) = nodes.split_first_mut() else { return };
    *own = fit_box(items);
    if items.len() <= LEAF {
        (own.first, own.len) = (start as u32, items.len() as u32);
        return;
    }
    let (low, high) = extent(items.iter().map(|item| item.centroid));
    let axis = (high - low).max_position();
    let middle = items.len() / 2;
    let along = |a: &NeedleItem, b: &NeedleItem| {
        a.centroid[axis].total_cmp(&b.centroid[axis]).then(a.triangle.cmp(&b.triangle))
    };
    items.select_nth_unstable_by(middle, along);
    let (before, after) = items.split_at_mut(middle);
    let (first, second) = below.split_at_mut(n_nodes(middle));
    let second_at = at + 1 + first.len();
    own.first = second_at as u32;
    let (one, two) = ([at + 1, start], [second_at, start + middle]);
    if after.len() > PARALLEL {
        parallel::join(|| grow(first, before, one), || grow(second, after, two));
    } else {
        grow(first, before, one);
        grow(second, after, two);
    }
}

fn fit_box(items: &[NeedleItem]) -> NeedleNode {
    let corners = || items.iter().flat_map(|item| item.corners);
    let mean = corners().sum::<DVec3>() / (3 * items.len()) as f64;
    let mut moments = [[0.0; 3]; 3];
    for corner in corners() {
        let from_mean = (corner - mean).to_array();
        for (row, x) in moments.iter_mut().zip(from_mean) {
            row.iter_mut().zip(from_mean).for_each(|(moment, y)| *moment += x * y);
        }
    }
    let axes = principal_axes(moments);
    let (low, high) = extent(corners().map(|corner| axes.map(|axis| axis.dot(corner)).into()));
    let middle = 0.5 * (low + high);
    let middle = axes[0] * middle.x + axes[1] * middle.y + axes[2] * middle.z;
    NeedleNode { middle, axes, half: 0.5 * (high - low) + DVec3::splat(MARGIN), ..NeedleNode::default() }
}

fn principal_axes(mut matrix: [[f64; 3]; 3]) -> [DVec3; 3] {
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for (p, q) in [(0, 1), (0, 2), (1, 2)].repeat(SWEEPS) {
        if matrix[p][q] == 0.0 {
            continue;
        }
        let slope = 0.5 * (matrix[q][q] - matrix[p][p]) / matrix[p][q];
        let tangent = 1f64.copysign(slope) / (slope.abs() + slope.hypot(1.0));
        let cosine = 1.0 / tangent.hypot(1.0);
        let sine = tangent * cosine;
        let turn =
            |row: &mut [f64; 3]| (row[p], row[q]) = (cosine * row[p] - sine * row[q], sine * row[p] + cosine * row[q]);
        matrix.iter_mut().for_each(turn);
        let (row, other) = (matrix[p], matrix[q]);
        matrix[p] = std::array::from_fn(|k| cosine * row[k] - sine * other[k]);
        matrix[q] = std::array::from_fn(|k| sine * row[k] + cosine * other[k]);
        axes.iter_mut().for_each(turn);
    }
    std::array::from_fn(|k| DVec3::new(axes[0][k], axes[1][k], axes[2][k]).normalize_or(DVec3::AXES[k]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::nearest_on_triangle::nearest_weights_f64;
    use proptest::prelude::*;

    fn distance2(corners: [[f32; 3]; 3], p: DVec3) -> f64 {
        let corners = corners_f64(corners);
        let [u, v, w] = nearest_weights_f64(p, corners);
        p.distance_squared(corners[0] * u + corners[1] * v + corners[2] * w)
    }

    fn nearest(tree: &NeedleTree, triangles: &[[[f32; 3]; 3]], p: DVec3) -> ((f64, u32), u32) {
        let (mut best, mut n_tests) = ((f64::INFINITY, u32::MAX), 0);
        let n_boxes = tree.visit_near(p, f64::INFINITY, |leaf| {
            n_tests += leaf.len() as u32;
            let found = leaf.iter().map(|&i| (distance2(triangles[i as usize], p), i));
            best = found.fold(best, |best, found| if found < best { found } else { best });
            best.0
        });
        (best, n_tests + n_boxes)
    }

    fn naive(triangles: &[[[f32; 3]; 3]], p: DVec3) -> (f64, u32) {
        let all = triangles.iter().zip(0..).map(|(&corners, i)| (distance2(corners, p), i));
        all.fold((f64::INFINITY, u32::MAX), |best, found| if found < best { found } else { best })
    }

    fn fan(n: u32) -> Vec<[[f32; 3]; 3]> {
        let rim = |i: u32| {
            let angle = f64::from(i) / f64::from(n) * 3.0;
            [angle.cos() as f32, angle.sin() as f32, (0.1 * (5.0 * angle).sin()) as f32]
        };
        (0..n).map(|i| [[0.0; 3], rim(i), rim(i + 1)]).collect()
    }

    proptest! {
        #[test]
        fn what_is_near_or_met_is_what_a_search_of_all_finds(
            corners in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 3..240),
            flat in prop::sample::select(vec![0.0f32, 1e-6, 1.0]),
            thin in prop::sample::select(vec![0.0f32, 1e-4, 1.0]),
            queries in prop::collection::vec(prop::array::uniform3(-1.5f64..1.5), 1..12),
        ) {
            let corners: Vec<[f32; 3]> = corners.iter().map(|&[x, y, z]| [x, y, flat * z]).collect();
            let needle = |c: &[[f32; 3]]| {
                [c[0], c[1], std::array::from_fn(|k| c[1][k] + thin * (c[2][k] - c[1][k]))]
            };
            let triangles: Vec<[[f32; 3]; 3]> = corners.chunks_exact(3).map(needle).collect();
            let tree = NeedleTree::new(triangles.iter().copied());
            for query in queries {
                prop_assert_eq!(nearest(&tree, &triangles, query.into()).0, naive(&triangles, query.into()));
            }
            for (i, a) in triangles.iter().enumerate() {
                let mut met = Vec::new();
                tree.visit_touching(corners_f64(*a), |leaf| met.extend(leaf));
                for (j, b) in (0..).zip(&triangles) {
                    let touches = i == j as usize || crate::geometry::crossing::triangles_cross(*a, *b);
                    prop_assert!(!touches || met.contains(&j));
                }
            }
        }
    }

    #[test]
    fn needles_of_a_fan_are_distinguished() {
        let triangles = fan(20_000);
        let tree = NeedleTree::new(triangles.iter().copied());
        let mut n_visits = 0;
        for i in 0..200 {
            let (angle, radius) = (0.0149 * f64::from(i), (f64::from(i * 37 % 200) / 200.0).sqrt());
            let p = DVec3::new(radius * angle.cos(), radius * angle.sin(), 0.01);
            let (found, n) = nearest(&tree, &triangles, p);
            assert_eq!(found, naive(&triangles, p), "{p}");
            n_visits += n;
        }
        assert!(n_visits < 200 * 400, "{n_visits}");
    }

    #[test]
    fn nothing_and_points_are_no_trouble() {
        let none = NeedleTree::new(std::iter::empty());
        assert_eq!(none.visit_near(DVec3::ONE, f64::INFINITY, |_| unreachable!("no leaf")), 0);
        let triangles = vec![[[0.25; 3]; 3]; 100];
        let tree = NeedleTree::new(triangles.iter().copied());
        assert_eq!(nearest(&tree, &triangles, DVec3::ONE).0, naive(&triangles, DVec3::ONE));
    }
}
