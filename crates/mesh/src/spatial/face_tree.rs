//! A quickly built tree for closest points on indexed triangles, best for few queries.
//!
//! A packed R-tree (Kamel and Faloutsos 1993) over triangles along a space-filling curve. A node has eight boxes in
//! bytes and is one cache line. Thin triangles are cut into pieces; if nearly all are thin, oriented boxes replace the
//! nodes.

use glam::DVec3;

use super::Bounds;
use super::curve_order::{curve_order, curve_order_of_faces};
use super::nearest_on_triangles::{hit_triangle, limit, unit_exponent};
use super::needle_tree::NeedleTree;
use super::triangle_pieces;
use crate::geometry::triangle::corners_f64;
use crate::parallel;

const WIDTH: usize = 8;
/// Additional pieces per triangle above which thin triangles are cut.
const NEEDLES: f64 = 0.05;
const CHUNK: usize = 512;
const WAITING: usize = (WIDTH - 1) * 11 + 1 + WIDTH;
/// Steps of byte coordinates across a node; one below the largest byte, for rounding.
const STEPS: f32 = 254.0;

const UNITS: f32 = 8_388_608.0;

/// Numbers of tests in a search.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SearchCost {
    /// Number of triangles, or pieces of them, tested.
    pub triangles: u32,
    /// Number of box tests; a node's packed boxes count as one.
    pub boxes: u32,
}

impl SearchCost {
    /// Returns the number of triangle and box tests.
    pub fn total(self) -> u32 {
        self.triangles + self.boxes
    }
}

/// A tree over the triangles of a mesh; ties go to the first triangle.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::spatial::FaceTree;
/// let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
/// let tree = FaceTree::new(&positions, &[[0, 1, 2]]);
/// assert_eq!(tree.nearest([0.25, 0.25, 2.0].into()), Some((0, 4.0)));
/// ```
pub struct FaceTree<'a> {
    positions: &'a [[f32; 3]],
    faces: &'a [[u32; 3]],
    order: Vec<u32>,
    /// Triangle of each piece, in curve order; `None` if no triangle is cut.
    pieces: Option<Vec<u32>>,
    /// Index of each triangle, or of its last piece, in curve order.
    places: Vec<u32>,
    /// Oriented boxes, which replace all nodes if too many triangles are thin.
    needles: Option<NeedleTree>,
    /// Nodes by level, the root last.
    levels: Vec<Vec<PackedNode>>,
    whole: Bounds,
    /// Power of two that scales coordinates to -1..1.
    pub(super) scale: f64,
    factors: [f32; 2],
}

/// The boxes of at most eight children.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct PackedNode {
    origin: [f32; 3],
    step: f32,
    low: [[u8; WIDTH]; 3],
    high: [[u8; WIDTH]; 3],
}

#[derive(Clone, Copy)]
struct PendingNode {
    distance: f32,
    above: u32,
    node: u32,
}

/// A point, and the squared distance at which any triangle is near enough.
type FaceQuery = (DVec3, f64);

/// The place of a leaf's first triangle, and the squared distances of its boxes.
type LeafDistances<'a> = (usize, &'a [f32; WIDTH]);

struct Queue {
    waiting: [PendingNode; WAITING],
    n_waiting: usize,
}

#[derive(Clone, Copy)]
struct BestFace {
    face: u32,
    distance2: f64,
    limit: f32,
    cost: SearchCost,
}

impl BestFace {
    #[inline(always)]
    fn with_limit(distance2: f64, p: DVec3) -> Self {
        Self { face: u32::MAX, distance2, limit: limit(distance2, p), cost: SearchCost::default() }
    }
}

impl<'a> FaceTree<'a> {
    /// Builds the tree over finite triangles, n_faces x 3.
    pub fn new(positions: &'a [[f32; 3]], faces: &'a [[u32; 3]]) -> Self {
        let mut tree = Self::without_nodes(positions, faces);
        // Whole numbers have one sum in any order, and in that of the mesh corners are near each other in memory.
        let wanted = |face: usize| f64::from(triangle_pieces::wanted_cuts(&tree.corners(face as u32)));
        let count = |chunk: usize, faces: &[[u32; 3]]| (0..faces.len()).map(|i| wanted(chunk * CHUNK + i)).sum::<f64>();
        let cuts: f64 = parallel::chunks(faces, CHUNK, count).into_iter().sum();
        if triangle_pieces::are_needles(cuts, faces.len()) {
            tree.whole =
                tree.order.iter().map(|&face| tree.bounds(face)).fold(Bounds::EMPTY, |all, bounds| all.union(&bounds));
            tree.needles = Some(NeedleTree::new((0..faces.len() as u32).map(|face| tree.corners(face))));
            return tree;
        }
        let mut made = tree.over_triangles(cuts);
        tree.places = tree.places();
        loop {
            tree.levels.push(made.iter().map(|made| made.0).collect());
            if made.len() <= 1 {
                tree.whole = made.first().map_or(Bounds::EMPTY, |root| root.1);
                return tree;
            }
            made = made.chunks(WIDTH).map(|below| node_over(below.iter().map(|made| made.1))).collect();
        }
    }

    fn without_nodes(positions: &'a [[f32; 3]], faces: &'a [[u32; 3]]) -> Self {
        let bounds = Bounds::from_points(positions);
        let most = bounds.low.into_iter().chain(bounds.high).fold(0.0, |most: f32, x| most.max(x.abs()));
        let exponent = unit_exponent(most);
        let power = |exponent: i32| 2.0f64.powi(exponent);
        let factors = [power(exponent / 2) as f32, power(exponent - exponent / 2) as f32];
        let order = curve_order_of_faces(positions, faces, &bounds);
        let (levels, scale) = (Vec::new(), power(exponent));
        let (pieces, places, needles) = (None, Vec::new(), None);
        Self { positions, faces, order, pieces, places, needles, levels, whole: Bounds::EMPTY, scale, factors }
    }

    /// Returns the closest triangle and its squared distance; `None` without triangles.
    pub fn nearest(&self, p: DVec3) -> Option<(u32, f64)> {
        self.nearest_from(p, None)
    }

    /// Returns the closest triangle and its squared distance; fast if the triangle `guess` is near.
    #[inline(always)]
    pub fn nearest_from(&self, p: DVec3, guess: Option<u32>) -> Option<(u32, f64)> {
        self.find_near(p, guess, f64::NEG_INFINITY)
    }

    /// Returns the closest triangle, or any at a squared distance of at most `enough`, and its squared distance.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::spatial::FaceTree;
    /// let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let tree = FaceTree::new(&positions, &[[0, 1, 2], [0, 1, 3]]);
    /// let above = |enough| tree.find_near([0.25, 0.25, 0.5].into(), Some(0), enough);
    /// assert!(above(0.25).is_some_and(|(_, distance2)| distance2 <= 0.25));
    /// assert_eq!(above(0.01), Some((1, 0.0625)));
    /// ```
    #[inline(always)]
    pub fn find_near(&self, p: DVec3, guess: Option<u32>, enough: f64) -> Option<(u32, f64)> {
        self.find_near_with_cost(p, guess, enough).map(|(face, distance2, _)| (face, distance2))
    }

    /// Searches as [`find_near`](Self::find_near), and also returns the numbers of tests.
    #[inline(always)]
    pub fn find_near_with_cost(&self, p: DVec3, guess: Option<u32>, enough: f64) -> Option<(u32, f64, SearchCost)> {
        let scale2 = self.scale * self.scale;
        self.best(p, guess, enough * scale2, &|_| true).map(|best| (best.face, best.distance2 / scale2, best.cost))
    }

    /// Returns the closest triangle within `reach` that `accept` allows, and its squared distance; fast if the triangle
    /// `guess` is near.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::spatial::FaceTree;
    /// let positions = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    /// let tree = FaceTree::new(&positions, &[[0, 1, 2], [0, 1, 3]]);
    /// let found = |reach| tree.nearest_of([0.25, 0.5, 0.25].into(), None, reach, |face| face == 1);
    /// assert_eq!((found(0.5), found(0.4)), (Some((1, 0.25)), None));
    /// ```
    pub fn nearest_of(
        &self,
        p: DVec3,
        guess: Option<u32>,
        reach: f64,
        accept: impl Fn(u32) -> bool,
    ) -> Option<(u32, f64)> {
        let (p, reach) = (p * self.scale, reach * self.scale);
        let mut best = BestFace::with_limit(reach * reach, p);
        self.search((p, f64::NEG_INFINITY), guess, &accept, &mut best);
        (best.face != u32::MAX).then(|| (best.face, best.distance2 / (self.scale * self.scale)))
    }

    /// Returns the triangles' indices in the order of the space-filling curve.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// Returns the diagonal of the bounding box, 0 without triangles.
    pub fn diagonal(&self) -> f64 {
        self.whole.diagonal() / self.scale
    }

    #[inline(always)]
    fn best(&self, p: DVec3, guess: Option<u32>, enough: f64, accept: &impl Fn(u32) -> bool) -> Option<BestFace> {
        let p = p * self.scale;
        let none = BestFace::with_limit(f64::INFINITY, p);
        let mut best = none;
        if enough >= 0.0 && self.needles.is_none() {
            // First search only within `enough`.
            best.limit = limit(enough, p);
            self.search((p, enough), guess, accept, &mut best);
            if best.distance2 > enough {
                best = BestFace { cost: best.cost, ..none };
            }
        }
        if best.distance2 > enough {
            self.search((p, enough), guess, accept, &mut best);
        }
        (best.face != u32::MAX).then_some(best)
    }

    #[inline(always)]
    fn search(&self, (p, enough): FaceQuery, guess: Option<u32>, accept: &impl Fn(u32) -> bool, best: &mut BestFace) {
        match (&self.needles, guess.filter(|&face| (face as usize) < self.faces.len())) {
            (Some(needles), guess) => {
                guess.into_iter().filter(|&face| accept(face)).for_each(|face| self.test_face(face, p, best));
                self.visit_needles(needles, (p, enough), accept, best);
            }
            (None, Some(face)) => self.climb(self.places[face as usize], (p, enough), accept, best),
            (None, None) if self.faces.is_empty() => {}
            (None, None) => self.descend((p, enough), accept, best),
        }
    }

    fn over_triangles(&mut self, cuts: f64) -> Vec<(PackedNode, Bounds)> {
        if cuts <= NEEDLES * self.order.len() as f64 {
            return nodes_over(&self.order, |face| self.bounds(face));
        }
        let triangles: Vec<_> = (0..self.faces.len() as u32).map(|face| self.corners(face)).collect();
        let boxes = triangle_pieces::boxes(&triangles);
        let middle = |piece: u32| {
            let bounds = &boxes[piece as usize].0;
            std::array::from_fn(|k| 0.5 * (bounds.low[k] + bounds.high[k]))
        };
        let order = curve_order(boxes.len(), middle, || ());
        let nodes = nodes_over(&order, |piece| boxes[piece as usize].0);
        self.pieces = Some(order.iter().map(|&piece| boxes[piece as usize].1).collect());
        nodes
    }

    /// Returns the corners of a triangle, scaled to -1..1.
    #[inline(always)]
    pub(super) fn corners(&self, face: u32) -> [[f32; 3]; 3] {
        let [s, t] = self.factors;
        let [a, b, c] = self.faces[face as usize];
        let scaled = |v: u32| {
            let [x, y, z] = self.positions[v as usize];
            [x * s * t, y * s * t, z * s * t]
        };
        [scaled(a), scaled(b), scaled(c)]
    }

    #[inline(always)]
    fn bounds(&self, face: u32) -> Bounds {
        Bounds::from_points(&self.corners(face))
    }

    #[inline(never)]
    fn visit_needles(
        &self,
        needles: &NeedleTree,
        (p, enough): FaceQuery,
        accept: &impl Fn(u32) -> bool,
        best: &mut BestFace,
    ) {
        let bound = |best: &BestFace| if best.distance2 > enough { best.distance2 } else { f64::NEG_INFINITY };
        let n_boxes = needles.visit_near(p, bound(best), |faces| {
            faces.iter().filter(|&&face| accept(face)).for_each(|&face| self.test_face(face, p, best));
            bound(best)
        });
        best.cost.boxes += n_boxes;
    }

    fn places(&self) -> Vec<u32> {
        let mut places = vec![0; self.faces.len()];
        let faces = self.pieces.as_ref().unwrap_or(&self.order);
        (0..).zip(faces).for_each(|(place, &face)| places[face as usize] = place);
        places
    }

    #[inline(always)]
    fn descend(&self, search: FaceQuery, accept: &impl Fn(u32) -> bool, best: &mut BestFace) {
        let root = PendingNode { distance: 0.0, above: self.levels.len() as u32, node: 0 };
        let mut queue = Queue { waiting: [root; WAITING], n_waiting: 1 };
        self.visit(&mut queue, search, accept, best);
    }

    #[inline(always)]
    fn climb(&self, place: u32, (p, enough): FaceQuery, accept: &impl Fn(u32) -> bool, best: &mut BestFace) {
        let point = p.as_vec3().to_array();
        let mut visited = place as usize / WIDTH;
        best.cost.boxes += 1;
        let leaf = (visited * WIDTH, &self.levels[0][visited].distances(point));
        if enough >= 0.0 && self.find_above(leaf, (p, enough), accept, best) {
            return;
        }
        self.test_faces(leaf, (p, enough), accept, best);
        if best.distance2 <= enough {
            return;
        }
        let none = PendingNode { distance: 0.0, above: 0, node: 0 };
        let mut queue = Queue { waiting: [none; WAITING], n_waiting: 0 };
        for level in 1..self.levels.len() {
            best.cost.boxes += 1;
            self.put_children(&mut queue, level, visited / WIDTH, Some(visited), (point, best.limit));
            self.visit(&mut queue, (p, enough), accept, best);
            if best.distance2 <= enough {
                return;
            }
            visited /= WIDTH;
        }
    }

    #[inline(always)]
    fn visit(&self, queue: &mut Queue, (p, enough): FaceQuery, accept: &impl Fn(u32) -> bool, best: &mut BestFace) {
        let point = p.as_vec3().to_array();
        while queue.n_waiting > 0 && best.distance2 > enough {
            queue.n_waiting -= 1;
            let PendingNode { distance, above, node } = queue.waiting[queue.n_waiting];
            best.cost.boxes += 1;
            if distance > best.limit {
                continue;
            }
            let (level, node) = (above as usize - 1, node as usize);
            if level == 0 {
                let leaf = (node * WIDTH, &self.levels[0][node].distances(point));
                self.test_faces(leaf, (p, enough), accept, best);
            } else {
                self.put_children(queue, level, node, None, (point, best.limit));
            }
        }
    }

    /// Queues a node's children within the squared distance `limit`, the nearest last.
    #[inline(always)]
    fn put_children(
        &self,
        queue: &mut Queue,
        level: usize,
        node: usize,
        visited: Option<usize>,
        (point, limit): ([f32; 3], f32),
    ) {
        let first = node * WIDTH;
        let n_children = WIDTH.min(self.levels[level - 1].len() - first);
        let mut distances = self.levels[level][node].distances(point);
        visited.into_iter().for_each(|child| distances[child - first] = f32::INFINITY);
        let Queue { waiting, n_waiting } = queue;
        let start = *n_waiting;
        for child in find_within(&distances, n_children, limit) {
            waiting[*n_waiting] =
                PendingNode { distance: distances[child], above: level as u32, node: (first + child) as u32 };
            *n_waiting += 1;
        }
        let nearer = |i: usize, j: usize| if waiting[j].distance < waiting[i].distance { j } else { i };
        if let Some(nearest) = (start..*n_waiting).reduce(nearer) {
            waiting.swap(nearest, *n_waiting - 1);
        }
    }

    /// Finds a triangle of a leaf that is near enough, and on which the point lies when it falls along the normal.
    #[inline(always)]
    fn find_above(
        &self,
        (first, distances): LeafDistances,
        (p, enough): FaceQuery,
        accept: &impl Fn(u32) -> bool,
        best: &mut BestFace,
    ) -> bool {
        let faces = self.faces_of_leaf(first);
        for child in find_within(distances, faces.len(), best.limit) {
            let face = faces[child];
            if accept(face) {
                best.cost.triangles += 1;
                let distance2 = height_above(p, self.corners(face));
                if distance2 <= enough {
                    *best = BestFace { face, distance2, ..*best };
                    return true;
                }
            }
        }
        false
    }

    fn faces_of_leaf(&self, first: usize) -> &[u32] {
        let faces = self.pieces.as_ref().unwrap_or(&self.order);
        &faces[first..faces.len().min(first + WIDTH)]
    }

    #[inline(always)]
    fn test_faces(
        &self,
        (first, distances): LeafDistances,
        (p, enough): FaceQuery,
        accept: &impl Fn(u32) -> bool,
        best: &mut BestFace,
    ) {
        let faces = self.faces_of_leaf(first);
        let nearer = |i: usize, j: usize| if distances[j] < distances[i] { j } else { i };
        let nearest = (0..faces.len()).reduce(nearer).unwrap_or_default();
        if distances[nearest] <= best.limit {
            if accept(faces[nearest]) {
                self.test_face(faces[nearest], p, best);
            }
            for (child, &face) in faces.iter().enumerate() {
                if best.distance2 <= enough {
                    return;
                }
                if distances[child] <= best.limit && child != nearest && accept(face) {
                    self.test_face(face, p, best);
                }
            }
        }
    }

    #[inline(always)]
    fn test_face(&self, face: u32, p: DVec3, best: &mut BestFace) {
        let distance2 = hit_triangle(&self.corners(face), face, p).distance2;
        best.cost.triangles += 1;
        if (distance2, face) < (best.distance2, best.face) {
            let limit = limit(distance2, p);
            *best = BestFace { face, distance2, limit: if limit < best.limit { limit } else { best.limit }, ..*best };
        }
    }
}

/// Lists the first `n` children with a finite distance of at most `limit`.
#[inline(always)]
fn find_within(distances: &[f32; WIDTH], n: usize, limit: f32) -> impl Iterator<Item = usize> {
    let limit = if limit < f32::MAX { limit } else { f32::MAX };
    let mut marks = 0u32;
    for (child, &distance) in distances.iter().enumerate() {
        marks |= u32::from(distance <= limit) << child;
    }
    marks &= (1 << n) - 1;
    std::iter::from_fn(move || {
        let child = marks.trailing_zeros() as usize;
        marks &= marks.wrapping_sub(1);
        (child < WIDTH).then_some(child)
    })
}

/// Returns the squared height of a point over a triangle, infinite if it does not fall on the inside.
#[inline(always)]
fn height_above(p: DVec3, corners: [[f32; 3]; 3]) -> f64 {
    let [a, b, c] = corners_f64(corners);
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let normal = ab.cross(ac);
    let (to_b, to_c, square) = (normal.dot(ap.cross(ac)), normal.dot(ab.cross(ap)), normal.length_squared());
    let is_inside = to_b > 0.0 && to_c > 0.0 && to_b + to_c < square;
    let height = normal.dot(ap);
    if is_inside { height * height / square } else { f64::INFINITY }
}

/// Returns the lowest nodes, each over the next items in order.
fn nodes_over(order: &[u32], bounds: impl Fn(u32) -> Bounds + Sync) -> Vec<(PackedNode, Bounds)> {
    let node = |items: &[u32]| node_over(items.iter().map(|&item| bounds(item)));
    parallel::map(order.len().div_ceil(WIDTH), CHUNK, |i| node(&order[i * WIDTH..order.len().min((i + 1) * WIDTH)]))
}

#[inline(always)]
fn node_over(children: impl ExactSizeIterator<Item = Bounds>) -> (PackedNode, Bounds) {
    let mut boxes = [Bounds::EMPTY; WIDTH];
    let mut whole = Bounds::EMPTY;
    for (place, child) in boxes.iter_mut().zip(children) {
        *place = child;
        whole = whole.union(&child);
    }
    let Bounds { low: origin, high } = whole;
    let extent = (0..3).map(|k| high[k] - origin[k]).fold(0.0, f32::max);
    let step = extent / STEPS * (1.0 + 1e-6);
    let mut node = PackedNode { origin, step, low: [[0; WIDTH]; 3], high: [[0; WIDTH]; 3] };
    let per_unit = if step > 0.0 { 1.0 / step } else { 0.0 };
    for (axis, origin) in origin.into_iter().enumerate() {
        for (child, Bounds { low, high }) in boxes.iter().enumerate() {
            // Half a step rounds outward; the hundredth exceeds the rounding error.
            node.low[axis][child] = nearest_byte((low[axis] - origin) * per_unit - 0.51);
            node.high[axis][child] = nearest_byte((high[axis] - origin) * per_unit + 0.51);
        }
    }
    (node, whole)
}

#[inline(always)]
fn nearest_byte(x: f32) -> u8 {
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < 255.0 { x } else { 255.0 };
    (x + UNITS).to_bits() as u8
}

impl PackedNode {
    #[inline(always)]
    fn distances(&self, p: [f32; 3]) -> [f32; WIDTH] {
        let mut distances = [0.0; WIDTH];
        for (axis, p) in p.into_iter().enumerate() {
            let from_origin = p - self.origin[axis];
            for (child, distance) in distances.iter_mut().enumerate() {
                let below = f32::from(self.low[axis][child]) * self.step - from_origin;
                let above = from_origin - f32::from(self.high[axis][child]) * self.step;
                let outside = if below > above { below } else { above };
                let outside = if outside > 0.0 { outside } else { 0.0 };
                *distance += outside * outside;
            }
        }
        distances
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
            let is_odd = |face: u32| face % 2 == 1;
            let odd = oracle.nearest_of(query.into(), is_odd).map(|hit| (hit.triangle, hit.distance2));
            for guess in guesses {
                assert_eq!(tree.nearest_from(query.into(), Some(guess)), expected, "{query:?}");
                for factor in [0.3, 1.5, 100.0] {
                    let enough = expected.map_or(0.0, |(_, distance2)| factor * distance2);
                    let near = tree.find_near(query.into(), Some(guess), enough);
                    let exact = |(face, _): (u32, f64)| {
                        oracle.nearest_of(query.into(), |other| other == face).map(|hit| hit.distance2)
                    };
                    let is_near = |(_, distance2): (u32, f64)| distance2 <= enough;
                    let is_right = near
                        .is_none_or(|found| exact(found).is_some_and(|exact| (found.1 - exact).abs() <= 1e-12 * exact));
                    assert!(
                        is_right && (near == expected || near.is_some_and(is_near)),
                        "{query:?} {near:?} {expected:?}"
                    );
                }
                assert_eq!(tree.nearest_of(query.into(), Some(guess), f64::INFINITY, is_odd), odd, "{query:?}");
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

    #[test]
    fn needles_are_found_by_their_pieces() {
        let rim = |i: u32| {
            let angle = i as f32 * 0.002;
            [angle.cos(), angle.sin(), 0.01 * (40.0 * angle).sin()]
        };
        let positions: Vec<[f32; 3]> = std::iter::once([0.1, 0.0, 0.02]).chain((0..2000).map(rim)).collect();
        let faces: Vec<[u32; 3]> = (1..2000).map(|i| [0, i, i + 1]).collect();
        let queries = [[0.3, 0.4, 0.0], [-0.7, -0.2, 0.01], [0.1, 0.0, 0.02], [0.5, -0.5, 1.0], [3.0, 2.0, 0.0]];
        agrees(&positions, &faces, &queries);
        let tree = FaceTree::new(&positions, &faces);
        let n_pieces = tree.pieces.as_ref().map_or(0, Vec::len);
        assert!(n_pieces > 2 * faces.len() && tree.order().len() == faces.len(), "{n_pieces}");
        let (_, _, cost) = tree.find_near_with_cost(queries[0].into(), None, f64::NEG_INFINITY).unwrap();
        assert!(cost.triangles < faces.len() as u32 / 4, "{cost:?}");
    }

    #[test]
    fn boxes_lie_along_the_needles_of_a_fan() {
        let rim = |i: u32| [(i as f32 * 1.5e-4).cos(), (i as f32 * 1.5e-4).sin(), 0.0];
        let positions: Vec<[f32; 3]> = std::iter::once([0.0; 3]).chain((0..20_000).map(rim)).collect();
        let faces: Vec<[u32; 3]> = (1..20_000).map(|i| [0, i, i + 1]).collect();
        let queries = [[0.3, 0.4, 0.0], [-0.7, -0.2, 0.01], [0.5, -0.5, 1.0], [3.0, 2.0, 0.0]];
        agrees(&positions, &faces, &queries);
        let tree = FaceTree::new(&positions, &faces);
        assert!(tree.needles.is_some() && (tree.diagonal() - 5f64.sqrt()).abs() < 0.02, "{}", tree.diagonal());
        for query in queries {
            let (_, _, cost) = tree.find_near_with_cost(query.into(), None, f64::NEG_INFINITY).unwrap();
            assert!(cost.total() < 400, "{query:?} {cost:?}");
            let (face, distance2, _) = tree.find_near_with_cost(query.into(), None, 4.0).unwrap();
            assert!(face < 19_999 && distance2 <= 9.0);
        }
    }

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
