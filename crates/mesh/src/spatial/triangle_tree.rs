//! A tree of boxes over triangles, split by the surface area heuristic, and its one descent for all searches.

use glam::Vec3A;

use super::Bounds;
use super::triangle_pieces::boxes;
use crate::parallel;

const LEAF: usize = 4;
const BINS: usize = 16;
const DEPTH: usize = 40;
const PARALLEL: usize = 8192;

/// A node: up to four children, with the coordinates of their boxes by axis.
#[derive(Clone, Copy)]
pub(super) struct TriangleNode {
    pub(super) low: [[f32; 4]; 3],
    pub(super) high: [[f32; 4]; 3],
    /// Index of each child's node, or of a leaf's first triangle.
    first: [u32; 4],
    /// Number of triangles of each child that is a leaf; 0 for a node, [`NO_CHILD`] if absent.
    len: [u8; 4],
}

/// Margin of boxes in -1..1, so that no line passes between two.
pub(super) const LINE_MARGIN: f32 = 1e-6;

impl TriangleNode {
    /// Returns where the line through `from` with inverse slopes enters each child's box, from `start` on, and leaves it.
    #[inline(always)]
    pub(super) fn line_ranges(&self, from: [f32; 3], inverse: [f32; 3], start: f32) -> [[f32; 4]; 2] {
        let (mut enter, mut leave) = ([start; 4], [f32::INFINITY; 4]);
        for axis in 0..3 {
            for child in 0..4 {
                let low = (self.low[axis][child] - LINE_MARGIN - from[axis]) * inverse[axis];
                let high = (self.high[axis][child] + LINE_MARGIN - from[axis]) * inverse[axis];
                // 0 times infinity is NaN, which `min` and `max` ignore.
                enter[child] = enter[child].max(low.min(high));
                leave[child] = leave[child].min(low.max(high));
            }
        }
        [enter, leave]
    }

    fn set(&mut self, child: usize, bounds: &WideBounds, first: u32, len: u8) {
        for axis in 0..3 {
            self.low[axis][child] = bounds.low[axis];
            self.high[axis][child] = bounds.high[axis];
        }
        self.first[child] = first;
        self.len[child] = len;
    }

    fn with_shift(mut self, shift: u32) -> Self {
        for (first, &len) in self.first.iter_mut().zip(&self.len) {
            *first += if len == 0 { shift } else { 0 };
        }
        self
    }
}

const NO_CHILD: u8 = u8::MAX;

const NO_CHILDREN: TriangleNode =
    TriangleNode { low: [[f32::INFINITY; 4]; 3], high: [[f32::NEG_INFINITY; 4]; 3], first: [0; 4], len: [NO_CHILD; 4] };

/// A tree with triangle corners in the order of the leaves; triangles in several pieces are repeated.
pub(super) struct TriangleTree {
    pub(super) nodes: Vec<TriangleNode>,
    pub(super) corners: Vec<[[f32; 3]; 3]>,
    pub(super) triangle_idx: Vec<u32>,
}

/// A search of the tree.
pub(super) trait TreeQuery {
    /// Returns distances to the children's boxes, by which they are visited; infinite for a box that is left out.
    fn distances(&mut self, node: &TriangleNode) -> [f32; 4];

    /// Returns whether a box at this distance can still change the result.
    fn reaches(&self, distance: f32) -> bool;

    /// Tests the triangle at an index of the leaves' order.
    fn test(&mut self, i: usize);
}

impl TriangleTree {
    pub(super) fn new(triangles: &[[[f32; 3]; 3]]) -> Self {
        let mut items: Vec<BoxItem> = boxes(triangles).into_iter().map(BoxItem::new).collect();
        let nodes = if items.is_empty() { Vec::new() } else { grow_in_parallel(&mut items, 0, 0) };
        let triangle_idx: Vec<u32> = items.iter().map(|item| item.triangle).collect();
        let corners = triangle_idx.iter().map(|&i| triangles[i as usize]).collect();
        Self { nodes, corners, triangle_idx }
    }

    pub(super) fn without_nodes(corners: Vec<[[f32; 3]; 3]>) -> Self {
        Self { nodes: Vec::new(), triangle_idx: (0..corners.len() as u32).collect(), corners }
    }

    /// Runs a search from the root down.
    pub(super) fn search(&self, query: &mut impl TreeQuery) {
        if !self.nodes.is_empty() {
            self.descend(0, query);
        }
    }

    fn descend(&self, node: u32, query: &mut impl TreeQuery) {
        let node = &self.nodes[node as usize];
        let distances = query.distances(node);
        for child in sort_by_distance(&distances) {
            let first = node.first[child];
            match node.len[child] {
                NO_CHILD => {}
                _ if !query.reaches(distances[child]) => {}
                0 => self.descend(first, query),
                len => (first..first + u32::from(len)).for_each(|i| query.test(i as usize)),
            }
        }
    }
}

/// Returns the children's order by distance, in one fixed sequence of exchanges.
fn sort_by_distance(distances: &[f32; 4]) -> [usize; 4] {
    let mut order = [0, 1, 2, 3];
    let mut sort = |i: usize, j: usize| {
        if distances[order[j]] < distances[order[i]] {
            order.swap(i, j);
        }
    };
    sort(0, 1);
    sort(2, 3);
    sort(0, 2);
    sort(1, 3);
    sort(1, 2);
    order
}

/// The search for all triangles whose box meets a box; triangles in several pieces are visited repeatedly.
pub(super) struct OverlapQuery<'a, V> {
    pub(super) tree: &'a TriangleTree,
    pub(super) bounds: Bounds,
    pub(super) visit: V,
}

impl<V: FnMut(u32)> TreeQuery for OverlapQuery<'_, V> {
    #[inline(always)]
    fn distances(&mut self, node: &TriangleNode) -> [f32; 4] {
        let mut overlaps = [true; 4];
        for axis in 0..3 {
            for (child, overlaps) in overlaps.iter_mut().enumerate() {
                *overlaps &= (node.low[axis][child] <= self.bounds.high[axis])
                    & (self.bounds.low[axis] <= node.high[axis][child]);
            }
        }
        // The children's numbers keep their order.
        std::array::from_fn(|child| if overlaps[child] { child as f32 } else { f32::INFINITY })
    }

    fn reaches(&self, distance: f32) -> bool {
        distance < f32::INFINITY
    }

    fn test(&mut self, i: usize) {
        if Bounds::from_points(&self.tree.corners[i]).overlaps(&self.bounds) {
            (self.visit)(self.tree.triangle_idx[i]);
        }
    }
}

#[derive(Clone, Copy)]
struct WideBounds {
    low: Vec3A,
    high: Vec3A,
}

impl WideBounds {
    const EMPTY: Self = Self { low: Vec3A::INFINITY, high: Vec3A::NEG_INFINITY };

    fn union(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    fn half_area(&self) -> f32 {
        let [x, y, z] = (self.high - self.low).max(Vec3A::ZERO).to_array();
        x * y + y * z + z * x
    }
}

#[derive(Clone, Copy)]
struct BoxItem {
    bounds: WideBounds,
    triangle: u32,
}

impl BoxItem {
    fn new((Bounds { low, high }, triangle): (Bounds, u32)) -> Self {
        Self { bounds: WideBounds { low: low.into(), high: high.into() }, triangle }
    }

    fn middle(&self, axis: usize) -> f32 {
        self.bounds.low[axis] + self.bounds.high[axis]
    }
}

/// Builds the nodes over `items`, the root first.
fn grow_in_parallel(items: &mut [BoxItem], first: usize, depth: usize) -> Vec<TriangleNode> {
    let mut nodes = Vec::new();
    if items.len() <= PARALLEL {
        grow(&mut nodes, items, first, depth);
        return nodes;
    }
    nodes.push(NO_CHILDREN);
    let parts = with_starts(quarters(items, depth), first);
    let grown = parallel::each(parts, |(start, part)| (bounds_of(part), grow_in_parallel(part, start, depth + 2)));
    for (child, (bounds, below)) in grown.into_iter().enumerate() {
        let shift = nodes.len() as u32;
        nodes[0].set(child, &bounds, shift, 0);
        nodes.extend(below.into_iter().map(|node| node.with_shift(shift)));
    }
    nodes
}

fn grow(nodes: &mut Vec<TriangleNode>, items: &mut [BoxItem], first: usize, depth: usize) {
    let own = nodes.len();
    nodes.push(NO_CHILDREN);
    for (child, (start, part)) in with_starts(quarters(items, depth), first).into_iter().enumerate() {
        let bounds = bounds_of(part);
        if part.len() <= LEAF {
            nodes[own].set(child, &bounds, start as u32, part.len() as u8);
        } else {
            let below = nodes.len() as u32;
            nodes[own].set(child, &bounds, below, 0);
            grow(nodes, part, start, depth + 2);
        }
    }
}

fn with_starts(parts: [&mut [BoxItem]; 4], first: usize) -> Vec<(usize, &mut [BoxItem])> {
    let mut end = first;
    let mut with_start = |part: &'_ mut [BoxItem]| {
        end += part.len();
        end - part.len()
    };
    parts.into_iter().map(|part| (with_start(part), part)).filter(|(_, part)| !part.is_empty()).collect()
}

fn bounds_of(items: &[BoxItem]) -> WideBounds {
    items.iter().fold(WideBounds::EMPTY, |bounds, item| bounds.union(&item.bounds))
}

/// Splits the items in four, unless they fit a leaf.
fn quarters(items: &mut [BoxItem], depth: usize) -> [&mut [BoxItem]; 4] {
    let middle = |items: &mut [BoxItem], depth| if items.len() <= LEAF { 0 } else { split(items, depth) };
    let half = middle(items, depth);
    let (a, b) = items.split_at_mut(half);
    let (in_a, in_b) = (middle(a, depth + 1), middle(b, depth + 1));
    let ((a0, a1), (b0, b1)) = (a.split_at_mut(in_a), b.split_at_mut(in_b));
    [a0, a1, b0, b1]
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: WideBounds,
    len: usize,
}

impl Bin {
    const EMPTY: Self = Self { bounds: WideBounds::EMPTY, len: 0 };
}

/// Reorders the items by the plane of least cost; returns the number on its first side.
fn split(items: &mut [BoxItem], depth: usize) -> usize {
    let (low, high) = middles(items);
    let n_bins = items.len().min(BINS);
    let Some((axis, cut)) = (depth < DEPTH).then(|| cheapest_cut(items, low, high, n_bins)).flatten() else {
        return items.len() / 2;
    };
    let scale = n_bins as f32 / (high[axis] - low[axis]);
    let middle = partition(items, |item| bin_of(item, axis, low[axis], scale, n_bins) < cut);
    if middle == 0 || middle == items.len() { items.len() / 2 } else { middle }
}

fn middles(items: &[BoxItem]) -> (Vec3A, Vec3A) {
    let unbounded = (Vec3A::INFINITY, Vec3A::NEG_INFINITY);
    items
        .iter()
        .map(|item| item.bounds.low + item.bounds.high)
        .fold(unbounded, |(low, high), middle| (low.min(middle), high.max(middle)))
}

fn bin_of(item: &BoxItem, axis: usize, low: f32, scale: f32, n_bins: usize) -> usize {
    (((item.middle(axis) - low) * scale) as usize).min(n_bins - 1)
}

fn cheapest_cut(items: &[BoxItem], low: Vec3A, high: Vec3A, n_bins: usize) -> Option<(usize, usize)> {
    let axis = (0..3).max_by(|&i, &j| (high[i] - low[i]).total_cmp(&(high[j] - low[j])))?;
    let scale = n_bins as f32 / (high[axis] - low[axis]);
    if !scale.is_finite() {
        return None;
    }
    let mut bins = [Bin::EMPTY; BINS];
    let bins = &mut bins[..n_bins];
    for item in items {
        let bin = &mut bins[bin_of(item, axis, low[axis], scale, n_bins)];
        bin.bounds = bin.bounds.union(&item.bounds);
        bin.len += 1;
    }
    let costs = costs(bins);
    let cuts = costs[..n_bins].iter().enumerate().skip(1);
    cuts.min_by(|x, y| x.1.total_cmp(y.1)).map(|(cut, _)| (axis, cut))
}

fn costs(bins: &[Bin]) -> [f32; BINS] {
    let mut costs = [0.0; BINS];
    let add = |side: &mut Bin, bin: &Bin| {
        side.bounds = side.bounds.union(&bin.bounds);
        side.len += bin.len;
        side.bounds.half_area() * side.len as f32
    };
    let (mut left, mut right) = (Bin::EMPTY, Bin::EMPTY);
    for cut in 1..bins.len() {
        costs[cut] += add(&mut left, &bins[cut - 1]);
    }
    for cut in (1..bins.len()).rev() {
        costs[cut] += add(&mut right, &bins[cut]);
    }
    costs
}

fn partition(items: &mut [BoxItem], belongs: impl Fn(&BoxItem) -> bool) -> usize {
    let mut front = 0;
    for i in 0..items.len() {
        if belongs(&items[i]) {
            items.swap(front, i);
            front += 1;
        }
    }
    front
}
