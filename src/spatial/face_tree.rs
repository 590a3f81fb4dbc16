//! The nearest point on indexed triangles, where the queries are fewer than the triangles: a tree that is made quickly.
//!
//! The triangles are put in order along a space-filling curve and packed, the boxes of eight to a node, the boxes of eight nodes to
//! the next (a packed R-tree, Kamel and Faloutsos 1993). Nothing but their boxes is copied. [`NearestOnTriangles`](super::NearestOnTriangles) takes
//! ten times as long to make and is faster to ask.

use glam::DVec3;
use rayon::prelude::*;

use super::curve_order::curve_order_of_faces;
use super::nearest_on_triangles::limit;
use crate::geometry::nearest_on_triangle::nearest_weights_f64;

/// Children of a node.
const WIDTH: usize = 8;
/// Nodes that one task makes.
const CHUNK: usize = 512;
/// Nodes that wait to be visited, at most: all children but one of each level, for as many levels as 32-bit indices need.
const WAITING: usize = (WIDTH - 1) * 11 + 1;

/// A tree over the triangles of a mesh.
///
/// Among triangles at exactly the same distance the first one wins, as in
/// [`NearestOnTriangles`](super::NearestOnTriangles).
///
/// ```
/// use neural_mesh::spatial::FaceTree;
/// let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let tree = FaceTree::new(&positions, &[[0, 1, 2]]);
/// assert_eq!(tree.nearest([0.25, 0.25, 2.0].into()), Some((0, 4.0)));
/// ```
pub struct FaceTree<'a> {
    positions: &'a [[f32; 3]],
    faces: &'a [[u32; 3]],
    /// The triangles along the curve, n_faces.
    order: Vec<u32>,
    /// Nodes from those over the triangles to the root, which is alone.
    levels: Vec<Vec<Node>>,
    /// A power of two that makes coordinates fit into -1..1, so that no square under- or overflows.
    scale: f64,
}

/// The boxes of the children, coordinate by coordinate; empty ones, at no finite distance, where there is none.
#[derive(Clone, Copy)]
struct Node {
    low: [[f32; WIDTH]; 3],
    high: [[f32; WIDTH]; 3],
}

const NO_CHILDREN: Node = Node { low: [[f32::INFINITY; WIDTH]; 3], high: [[f32::NEG_INFINITY; WIDTH]; 3] };

/// The best so far, and the squared distance beyond which boxes need no visit.
struct Best {
    face: u32,
    /// Its place along the curve; that of the first triangle where it was a guess that nothing else came near.
    place: usize,
    distance2: f64,
    limit: f32,
}

impl<'a> FaceTree<'a> {
    /// Makes the tree over triangles (n_faces x 3, indices of positions) with finite corners.
    pub fn new(positions: &'a [[f32; 3]], faces: &'a [[u32; 3]]) -> Self {
        let most = positions.as_flattened().iter().fold(0.0, |most: f32, x| most.max(x.abs()));
        let scale = if most > 0.0 { 0.5f64.powi(f64::from(most).log2().ceil() as i32) } else { 1.0 };
        let order = curve_order_of_faces(positions, faces);
        let mut tree = Self { positions, faces, order, levels: Vec::new(), scale };
        tree.levels.push(tree.over_triangles());
        while let Some(below) = tree.levels.last().filter(|below| below.len() > 1) {
            let nodes = below.chunks(WIDTH).map(|below| node_over(below.iter().map(Node::whole))).collect();
            tree.levels.push(nodes);
        }
        tree
    }

    /// The nearest triangle and the squared distance to it; `None` where there are none.
    pub fn nearest(&self, p: DVec3) -> Option<(u32, f64)> {
        self.nearest_from(p, None)
    }

    /// The same, found sooner where the nearest one lies near the triangle `guess`, as it does for the next of points in a row.
    #[inline(always)]
    pub fn nearest_from(&self, p: DVec3, guess: Option<u32>) -> Option<(u32, f64)> {
        self.best(p, guess, f64::NEG_INFINITY).map(|best| (best.face, best.distance2 / (self.scale * self.scale)))
    }

    /// The squared distance to the nearest triangle if it is more than `least`; found soon where it is not and `guess` is near
    /// enough to say so.
    ///
    /// ```
    /// use neural_mesh::spatial::FaceTree;
    /// let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let tree = FaceTree::new(&positions, &[[0, 1, 2]]);
    /// let above = |least| tree.distance_above(least, [0.25, 0.25, 2.0].into(), None);
    /// assert_eq!((above(3.9), above(4.0)), (Some(4.0), None));
    /// ```
    #[inline(always)]
    pub fn distance_above(&self, least: f64, p: DVec3, guess: Option<u32>) -> Option<f64> {
        let scale2 = self.scale * self.scale;
        let found = self.best(p, guess, least * scale2)?.distance2 / scale2;
        (found > least).then_some(found)
    }

    /// The triangles in their order along the curve.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Some triangles around the one that is nearest, itself among them; none where there are none.
    ///
    /// ```
    /// use neural_mesh::spatial::FaceTree;
    /// let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    /// let tree = FaceTree::new(&positions, &[[0, 1, 2]]);
    /// assert_eq!(tree.around([0.25, 0.25, 2.0].into()), [0]);
    /// ```
    pub fn around(&self, p: DVec3) -> &[u32] {
        let Some(Best { place, .. }) = self.best(p, None, f64::NEG_INFINITY) else { return &[] };
        let leaf = place / WIDTH;
        let end = self.order.len().min((leaf + 2) * WIDTH);
        &self.order[leaf.saturating_sub(1) * WIDTH..end]
    }

    /// The nearest triangle, or any that is no farther than `enough` (squared), in scaled coordinates.
    #[inline(always)]
    fn best(&self, p: DVec3, guess: Option<u32>, enough: f64) -> Option<Best> {
        let none = Best { face: u32::MAX, place: 0, distance2: f64::INFINITY, limit: f32::INFINITY };
        let (p, mut best) = (p * self.scale, none);
        if let Some(face) = guess.filter(|&face| (face as usize) < self.faces.len()) {
            self.test_face(face, 0, p, &mut best);
        }
        if !self.faces.is_empty() {
            self.descend(p, enough, &mut best);
        }
        (best.face != u32::MAX).then_some(best)
    }

    /// The nodes over the triangles.
    fn over_triangles(&self) -> Vec<Node> {
        let node = |faces: &[u32]| node_over(faces.iter().map(|&face| self.bounds(face)));
        self.order.par_chunks(WIDTH).with_min_len(CHUNK).map(node).collect()
    }

    #[inline(always)]
    fn corners(&self, face: u32) -> [[f32; 3]; 3] {
        let scaled = |v: u32| self.positions[v as usize].map(|x| (f64::from(x) * self.scale) as f32);
        self.faces[face as usize].map(scaled)
    }

    fn bounds(&self, face: u32) -> Bounds {
        self.corners(face).into_iter().map(|corner| (corner, corner)).fold(EMPTY, union)
    }

    /// Visits the nodes that may hold a nearer triangle, the nearest first.
    #[inline(always)]
    fn descend(&self, p: DVec3, enough: f64, best: &mut Best) {
        let point = p.as_vec3().to_array();
        let mut waiting = [(0.0, 0, 0); WAITING];
        waiting[0] = (0.0, self.levels.len() as u32, 0);
        let mut n_waiting = 1;
        while n_waiting > 0 && best.distance2 > enough {
            n_waiting -= 1;
            let (distance, above, node) = waiting[n_waiting];
            if distance > best.limit {
                continue;
            }
            if above == 0 {
                self.test_face(self.order[node], node, p, best);
                continue;
            }
            let (children, n) = self.levels[above as usize - 1][node].by_distance(point, best.limit);
            for &(distance, child) in children[..n].iter().rev() {
                waiting[n_waiting] = (distance, above - 1, node * WIDTH + child);
                n_waiting += 1;
            }
        }
    }

    #[inline(always)]
    fn test_face(&self, face: u32, place: usize, p: DVec3, best: &mut Best) {
        let corners = self.corners(face).map(|corner| DVec3::from_array(corner.map(f64::from)));
        let weights = nearest_weights_f64(p, corners);
        let point = corners[0] * weights[0] + corners[1] * weights[1] + corners[2] * weights[2];
        let distance2 = p.distance_squared(point);
        if (distance2, face) < (best.distance2, best.face) {
            *best = Best { face, place, distance2, limit: limit(distance2, p) };
        }
    }
}

/// Lowest and highest coordinates of a box.
type Bounds = ([f32; 3], [f32; 3]);

const EMPTY: Bounds = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);

fn union(a: Bounds, b: Bounds) -> Bounds {
    (std::array::from_fn(|k| a.0[k].min(b.0[k])), std::array::from_fn(|k| a.1[k].max(b.1[k])))
}

/// The node over at most [`WIDTH`] children.
fn node_over(children: impl Iterator<Item = Bounds>) -> Node {
    let mut node = NO_CHILDREN;
    for (child, (low, high)) in children.enumerate() {
        for axis in 0..3 {
            node.low[axis][child] = low[axis];
            node.high[axis][child] = high[axis];
        }
    }
    node
}

impl Node {
    /// The box around all children.
    fn whole(&self) -> Bounds {
        let low = self.low.map(|values| values.into_iter().fold(f32::INFINITY, f32::min));
        (low, self.high.map(|values| values.into_iter().fold(f32::NEG_INFINITY, f32::max)))
    }

    /// The children no farther than the limit (squared), the nearest first, and how many they are.
    #[inline(always)]
    fn by_distance(&self, p: [f32; 3], limit: f32) -> ([(f32, usize); WIDTH], usize) {
        let mut distances = [0.0; WIDTH];
        for (axis, p) in p.into_iter().enumerate() {
            for (child, distance) in distances.iter_mut().enumerate() {
                let outside = (self.low[axis][child] - p).max(p - self.high[axis][child]).max(0.0);
                *distance += outside * outside;
            }
        }
        let (mut sorted, mut n) = ([(f32::INFINITY, 0); WIDTH], 0);
        for (child, &distance) in distances.iter().enumerate() {
            if distance <= limit && distance.is_finite() {
                let at = sorted[..n].iter().position(|&(other, _)| other > distance).unwrap_or(n);
                sorted.copy_within(at..n, at + 1);
                sorted[at] = (distance, child);
                n += 1;
            }
        }
        (sorted, n)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spatial::NearestOnTriangles;
    use proptest::prelude::*;

    fn agrees(positions: &[[f32; 3]], faces: &[[u32; 3]], queries: &[[f64; 3]]) {
        let tree = FaceTree::new(positions, faces);
        let triangles: Vec<_> = faces.iter().map(|face| face.map(|v| positions[v as usize])).collect();
        let oracle = NearestOnTriangles::new(&triangles);
        for &query in queries {
            let expected = oracle.nearest(query.into()).map(|hit| (hit.triangle, hit.distance2));
            assert_eq!(tree.nearest(query.into()), expected, "{query:?}");
            let guesses = [0, faces.len() as u32 / 2, u32::MAX];
            for guess in guesses {
                assert_eq!(tree.nearest_from(query.into(), Some(guess)), expected, "{query:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn agrees_with_the_exact_tree(
            positions in prop::collection::vec(prop::array::uniform3(-1.0f32..1.0), 3..60),
            corners in prop::collection::vec(prop::array::uniform3(0usize..1000), 0..300),
            queries in prop::collection::vec(prop::array::uniform3(-2.0f64..2.0), 1..20),
            scale in prop::sample::select(vec![1e-30f32, 1.0, 1e30]),
        ) {
            let positions: Vec<[f32; 3]> = positions.iter().map(|p| p.map(|x| x * scale)).collect();
            let faces: Vec<[u32; 3]> = corners.iter().map(|f| f.map(|v| (v % positions.len()) as u32)).collect();
            let queries: Vec<[f64; 3]> = queries.iter().map(|p| p.map(|x| x * f64::from(scale))).collect();
            agrees(&positions, &faces, &queries);
        }
    }

    /// A point far out makes all other faces one cell of the curve's first grid.
    #[test]
    fn a_far_point_does_not_make_it_wrong() {
        let mut positions: Vec<[f32; 3]> = (0..3000).map(|i| [(i % 50) as f32, (i / 50) as f32, 0.0]).collect();
        positions.push([1e7; 3]);
        let face = |i: u32| [i, i + 1, i + 50];
        let mut faces: Vec<[u32; 3]> = (0..2900).map(face).collect();
        faces.push([0, 1, 3000]);
        agrees(&positions, &faces, &[[3.3, 7.1, 2.0], [-5.0, 100.0, 0.5], [1e6; 3], [20.0, 20.0, 0.0]]);
    }
}
