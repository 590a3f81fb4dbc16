//! Nearest points by a k-d tree (the k-nn graphs of Secs. 3.2 and 3.3).

use crate::parallel;

/// Finds the `k` nearest other points of every point, nearest first; ties go to the lower index.
///
/// # Shapes
/// - `points`: n x 3, finite
/// - returns n x min(k, n - 1) indices, row-major, without a point's own
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::spatial::nearest_neighbours;
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
/// assert_eq!(nearest_neighbours(&points, 1), [1, 0, 1]);
/// assert_eq!(nearest_neighbours(&points, 9), [1, 2, 0, 2, 1, 0]);
/// ```
pub fn nearest_neighbours(points: &[[f32; 3]], k: usize) -> Vec<u32> {
    let k = k.min(points.len().saturating_sub(1));
    if k == 0 {
        return Vec::new();
    }
    let tree = Tree::new(points);
    let mut in_tree_order = vec![0u32; points.len() * k];
    parallel::chunks_mut(&mut in_tree_order, QUERIES * k, |block, rows| {
        let mut nearest = Nearest::new(k);
        let mut before = None;
        for (i, row) in rows.chunks_exact_mut(k).enumerate() {
            let query = tree.query_at(block * QUERIES + i);
            let bound = before.map_or(f32::INFINITY, |before| bound(points, &query, before, &nearest));
            tree.search(&mut nearest, &query, bound);
            nearest.write(row);
            before = Some(query.point);
        }
    });
    let mut result = vec![0u32; points.len() * k];
    for (row, &point) in in_tree_order.chunks_exact(k).zip(&tree.order) {
        result[point as usize * k..][..k].copy_from_slice(row);
    }
    result
}

/// Finds the `k` points nearest to each query, nearest first; ties go to the lower index.
///
/// # Shapes
/// - `points`: n x 3, `queries`: n_queries x 3, finite
/// - returns n_queries x min(k, n) indices, row-major
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::spatial::nearest_to;
/// let points = [[0.0; 3], [1.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
/// assert_eq!(nearest_to(&points, &[[3.0, 0.0, 0.0], [0.9, 0.0, 0.0]], 2), [2, 1, 1, 0]);
/// ```
pub fn nearest_to(points: &[[f32; 3]], queries: &[[f32; 3]], k: usize) -> Vec<u32> {
    let k = k.min(points.len());
    if k == 0 {
        return Vec::new();
    }
    let tree = Tree::new(points);
    let mut indices = vec![0u32; queries.len() * k];
    parallel::each(indices.chunks_mut(QUERIES * k).zip(queries.chunks(QUERIES)), |(rows, queries)| {
        let mut nearest = Nearest::new(k);
        for (row, &point) in rows.chunks_exact_mut(k).zip(queries) {
            tree.search(&mut nearest, &NeighbourQuery { point, skipped: usize::MAX }, f32::INFINITY);
            nearest.write(row);
        }
    });
    indices
}

/// Orders points (n x 3, finite) so that near points are close together in memory.
///
/// Returns each of the n indices once, in the order of the leaves of a k-d tree.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::spatial::coherent_order;
/// let alternating: Vec<[f32; 3]> = (0..64).map(|i| [(i % 2 * 100 + i) as f32, 0.0, 0.0]).collect();
/// let order = coherent_order(&alternating);
/// assert!(order[..32].iter().all(|i| i % 2 == 0) && order[32..].iter().all(|i| i % 2 == 1));
/// ```
pub fn coherent_order(points: &[[f32; 3]]) -> Vec<u32> {
    Tree::new(points).order
}

const QUERIES: usize = 256;

const LEAF: usize = 32;

/// A k-d tree: points in an order in which every node is a range.
struct Tree {
    order: Vec<u32>,
    coordinates: [Vec<f32>; 3],
    splits: Vec<(u8, f32)>,
}

struct NeighbourQuery {
    point: [f32; 3],
    skipped: usize,
}

/// A range of the tree's order; the children of node `i` are `2 i + 1` and `2 i + 2`.
#[derive(Clone, Copy)]
struct KdNode {
    index: usize,
    begin: usize,
    end: usize,
}

impl KdNode {
    fn root(n_points: usize) -> Self {
        Self { index: 0, begin: 0, end: n_points }
    }

    fn is_leaf(self) -> bool {
        self.end - self.begin <= LEAF
    }

    fn children(self) -> [Self; 2] {
        let middle = self.begin.midpoint(self.end);
        [
            Self { index: 2 * self.index + 1, end: middle, ..self },
            Self { index: 2 * self.index + 2, begin: middle, ..self },
        ]
    }
}

impl Tree {
    fn new(points: &[[f32; 3]]) -> Self {
        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        let mut found = Vec::new();
        split(points, &mut order, KdNode::root(points.len()), &mut found);
        let mut splits = vec![(0, 0.0); found.iter().map(|split| split.0 + 1).max().unwrap_or(0)];
        found.into_iter().for_each(|(node, axis, at)| splits[node] = (axis, at));
        let coordinates = [0, 1, 2].map(|axis| order.iter().map(|&i| points[i as usize][axis]).collect());
        Self { order, coordinates, splits }
    }

    fn query_at(&self, place: usize) -> NeighbourQuery {
        NeighbourQuery { point: [0, 1, 2].map(|axis: usize| self.coordinates[axis][place]), skipped: place }
    }

    /// Stores the points nearest to the query, within the squared distance `bound`.
    fn search(&self, nearest: &mut Nearest, query: &NeighbourQuery, bound: f32) {
        nearest.clear(bound);
        self.visit(nearest, query, KdNode::root(self.order.len()), [0.0; 3]);
    }

    /// Offers the points of `node` that can be among the nearest; `gap` is its distance from the query along each axis.
    fn visit(&self, nearest: &mut Nearest, query: &NeighbourQuery, node: KdNode, gap: [f32; 3]) {
        // Computed as for points, so that rounding never prunes a point that ties.
        if squared_length(gap) > nearest.worst {
            return;
        }
        if node.is_leaf() {
            return self.offer_leaf(nearest, query, node);
        }
        let (axis, split) = self.splits[node.index];
        let beyond = query.point[axis as usize] - split;
        let mut far_gap = gap;
        far_gap[axis as usize] = beyond.abs();
        let [left, right] = node.children();
        let (near, far) = if beyond < 0.0 { (left, right) } else { (right, left) };
        self.visit(nearest, query, near, gap);
        self.visit(nearest, query, far, far_gap);
    }

    fn offer_leaf(&self, nearest: &mut Nearest, query: &NeighbourQuery, node: KdNode) {
        let [x, y, z] = &self.coordinates;
        let [px, py, pz] = query.point;
        let mut distances = [0.0f32; LEAF];
        let leaf = node.begin..node.end;
        let coordinates = x[leaf.clone()].iter().zip(&y[leaf.clone()]).zip(&z[leaf.clone()]);
        for (distance, ((x, y), z)) in distances.iter_mut().zip(coordinates) {
            *distance = squared_length([x - px, y - py, z - pz]);
        }
        for (distance, at) in distances.iter().zip(leaf) {
            if *distance <= nearest.worst && at != query.skipped {
                nearest.offer(*distance, self.order[at]);
            }
        }
    }
}

fn squared_length([x, y, z]: [f32; 3]) -> f32 {
    x * x + y * y + z * z
}

const ALONE: usize = 4096;

/// Orders the points of a node and records every split.
fn split(points: &[[f32; 3]], order: &mut [u32], node: KdNode, splits: &mut Vec<(usize, u8, f32)>) {
    if node.is_leaf() {
        return order.sort_unstable();
    }
    let axis = longest_axis(points, order);
    let coordinate = |i: u32| points[i as usize][axis];
    let middle = order.len() / 2;
    let (_, &mut median, _) =
        order.select_nth_unstable_by(middle, |&a, &b| coordinate(a).total_cmp(&coordinate(b)).then(a.cmp(&b)));
    splits.push((node.index, axis as u8, coordinate(median)));
    let (lower, upper) = order.split_at_mut(middle);
    let [left, right] = node.children();
    if node.end - node.begin <= ALONE {
        split(points, lower, left, splits);
        split(points, upper, right, splits);
    } else {
        let mut of_upper = Vec::new();
        parallel::join(|| split(points, lower, left, splits), || split(points, upper, right, &mut of_upper));
        splits.append(&mut of_upper);
    }
}

fn longest_axis(points: &[[f32; 3]], order: &[u32]) -> usize {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for &i in order {
        for axis in 0..3 {
            low[axis] = low[axis].min(points[i as usize][axis]);
            high[axis] = high[axis].max(points[i as usize][axis]);
        }
    }
    let extent = |axis: usize| high[axis] - low[axis];
    (1..3).fold(0, |best, axis| if extent(axis) > extent(best) { axis } else { best })
}

/// Bounds the squared distance to the query's k-th nearest point by the previous query and its nearest points.
fn bound(points: &[[f32; 3]], query: &NeighbourQuery, before: [f32; 3], nearest: &Nearest) -> f32 {
    // Computed as in the leaves, so that rounding never leaves out a point that ties.
    let distance = |[x, y, z]: [f32; 3]| {
        let [px, py, pz] = query.point;
        squared_length([x - px, y - py, z - pz])
    };
    nearest.indices().map(|i| distance(points[i as usize])).fold(distance(before), f32::max)
}

struct Nearest {
    /// Squared distance (high 32 bits) and index (low 32 bits) of each point, ascending.
    keys: Vec<u64>,
    worst: f32,
}

impl Nearest {
    fn new(k: usize) -> Self {
        Self { keys: vec![u64::MAX; k], worst: f32::INFINITY }
    }

    fn clear(&mut self, bound: f32) {
        self.keys.fill(u64::MAX);
        self.worst = bound;
    }

    fn offer(&mut self, distance: f32, index: u32) {
        let key = u64::from(distance.to_bits()) << 32 | u64::from(index);
        let mut place = self.keys.len() - 1;
        if key >= self.keys[place] {
            return;
        }
        while place > 0 && key < self.keys[place - 1] {
            self.keys[place] = self.keys[place - 1];
            place -= 1;
        }
        self.keys[place] = key;
        let last = self.keys[self.keys.len() - 1];
        if last != u64::MAX {
            self.worst = f32::from_bits((last >> 32) as u32);
        }
    }

    fn indices(&self) -> impl Iterator<Item = u32> {
        self.keys.iter().map(|&key| key as u32)
    }

    fn write(&self, row: &mut [u32]) {
        row.iter_mut().zip(self.indices()).for_each(|(index, found)| *index = found);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Finds all neighbours of the queries by distance; with `skips_own`, a query is no neighbour of itself.
    fn brute_force(points: &[[f32; 3]], queries: &[[f32; 3]], k: usize, skips_own: bool) -> Vec<u32> {
        let row = |(i, q): (u32, &[f32; 3])| {
            let distance = |p: &[f32; 3]| squared_length([0, 1, 2].map(|axis| p[axis] - q[axis]));
            let all = points.iter().map(distance).zip(0..);
            let mut all: Vec<(f32, u32)> = all.filter(|&(_, j)| !skips_own || j != i).collect();
            all.sort_by(|a, b| a.partial_cmp(b).unwrap());
            all.into_iter().take(k).map(|(_, j)| j).collect::<Vec<_>>()
        };
        (0..).zip(queries).flat_map(row).collect()
    }

    fn check(points: &[[f32; 3]]) {
        for k in [0, 1, 7, 20] {
            assert_eq!(nearest_neighbours(points, k), brute_force(points, points, k, true));
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        #[test]
        fn agrees_with_brute_force(points in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 0..300)) {
            check(&points);
        }

        #[test]
        fn queries_anywhere_agree_with_brute_force(
            points in prop::collection::vec(prop::array::uniform3(-2i8..3), 0..200),
            queries in prop::collection::vec(prop::array::uniform3(-3i8..4), 0..20),
        ) {
            let [points, queries] = [points, queries].map(|all| all.iter().map(|p| p.map(f32::from)).collect::<Vec<_>>());
            for k in [0, 1, 7, 300] {
                assert_eq!(nearest_to(&points, &queries, k), brute_force(&points, &queries, k, false));
            }
        }

        #[test]
        fn ties_go_to_the_lower_index(points in prop::collection::vec(prop::array::uniform3(-2i8..3), 0..300)) {
            let on_a_lattice: Vec<[f32; 3]> = points.iter().map(|p| p.map(f32::from)).collect();
            check(&on_a_lattice);
        }
    }

    #[test]
    fn any_number_of_equal_points_is_fine() {
        check(&[[0.5, -3.0, 1e30]; 500]);
    }

    #[test]
    fn overflowing_distances_still_give_every_row_its_neighbours() {
        let points: Vec<[f32; 3]> = (0..100).map(|i| [if i % 2 == 0 { f32::MAX } else { f32::MIN }; 3]).collect();
        check(&points);
    }
}
