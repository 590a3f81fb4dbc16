//! A tree of bounding boxes over triangles, four children wide: the ground of nearest-point and overlap queries.
//!
//! Split by the surface area heuristic over 16 bins per axis; the same tree on any number of threads.

/// Most triangles in a leaf.
const LEAF: usize = 4;
/// Bins per axis when a split is chosen.
const BINS: usize = 16;
/// Below this depth ranges are halved, so that no input makes the tree deep.
const DEPTH: usize = 40;
/// Ranges longer than this are split on several threads.
const PARALLEL: usize = 8192;

/// An axis-parallel box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub low: [f32; 3],
    /// Largest coordinates.
    pub high: [f32; 3],
}

impl Bounds {
    /// The box that holds nothing.
    pub const EMPTY: Self = Self { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    /// The box of some points.
    pub fn of(points: &[[f32; 3]]) -> Self {
        points.iter().fold(Self::EMPTY, |bounds, &p| bounds.union(&Self { low: p, high: p }))
    }

    /// The smallest box around two.
    pub fn union(&self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|k| self.low[k].min(other.low[k])),
            high: std::array::from_fn(|k| self.high[k].max(other.high[k])),
        }
    }

    /// Whether two boxes share a point.
    pub fn overlaps(&self, other: &Self) -> bool {
        (0..3).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }

    /// Half the surface of the box; 0 for the empty one.
    fn half_area(&self) -> f32 {
        let [x, y, z]: [f32; 3] = std::array::from_fn(|k| (self.high[k] - self.low[k]).max(0.0));
        x * y + y * z + z * x
    }
}

/// Up to four children with their boxes, coordinate by coordinate so that all four are tested at once.
#[derive(Clone, Copy)]
pub(super) struct Node {
    pub(super) low: [[f32; 4]; 3],
    pub(super) high: [[f32; 4]; 3],
    /// Index of the child node, or of the first triangle of a leaf.
    pub(super) first: [u32; 4],
    /// Triangles of a leaf; 0 for an inner node, [`NO_CHILD`] for none.
    pub(super) len: [u8; 4],
}

/// Marks a child that does not exist.
pub(super) const NO_CHILD: u8 = u8::MAX;

const NO_CHILDREN: Node =
    Node { low: [[f32::INFINITY; 4]; 3], high: [[f32::NEG_INFINITY; 4]; 3], first: [0; 4], len: [NO_CHILD; 4] };

/// The tree, with the corners of the triangles in the order of its leaves.
pub(super) struct TriangleTree {
    /// The root is node 0; none where there are no triangles.
    pub(super) nodes: Vec<Node>,
    pub(super) corners: Vec<[[f32; 3]; 3]>,
    /// Which triangle of the caller each one is.
    pub(super) triangle_idx: Vec<u32>,
}

#[derive(Clone, Copy)]
struct Item {
    bounds: Bounds,
    triangle: u32,
}

impl Item {
    /// Twice the middle of the box.
    fn middle(&self, axis: usize) -> f32 {
        self.bounds.low[axis] + self.bounds.high[axis]
    }
}

impl TriangleTree {
    pub(super) fn new(triangles: &[[[f32; 3]; 3]]) -> Self {
        let item = |(i, corners): (usize, &[[f32; 3]; 3])| Item { bounds: Bounds::of(corners), triangle: i as u32 };
        let mut items: Vec<Item> = triangles.iter().enumerate().map(item).collect();
        let mut nodes = Vec::new();
        if !items.is_empty() {
            nodes.reserve(items.len() / 6 + 1);
            grow(&mut nodes, &mut items, 0, 0);
        }
        let triangle_idx: Vec<u32> = items.iter().map(|item| item.triangle).collect();
        let corners = triangle_idx.iter().map(|&i| triangles[i as usize]).collect();
        Self { nodes, corners, triangle_idx }
    }

    /// Calls `visit` for every triangle whose box meets `bounds`, by the caller's index.
    pub(super) fn visit_overlaps(&self, bounds: &Bounds, visit: &mut impl FnMut(u32)) {
        if !self.nodes.is_empty() {
            self.visit_node(0, bounds, visit);
        }
    }

    fn visit_node(&self, node: u32, bounds: &Bounds, visit: &mut impl FnMut(u32)) {
        let node = &self.nodes[node as usize];
        for child in 0..4 {
            let child_bounds =
                Bounds { low: node.low.map(|values| values[child]), high: node.high.map(|values| values[child]) };
            if !child_bounds.overlaps(bounds) {
                continue;
            }
            match node.len[child] {
                NO_CHILD => {}
                0 => self.visit_node(node.first[child], bounds, visit),
                len => {
                    for i in node.first[child] as usize..node.first[child] as usize + usize::from(len) {
                        if Bounds::of(&self.corners[i]).overlaps(bounds) {
                            visit(self.triangle_idx[i]);
                        }
                    }
                }
            }
        }
    }
}

/// Appends the node over `items` and everything below it; `first` is the index of the first item in the whole.
fn grow(nodes: &mut Vec<Node>, items: &mut [Item], first: usize, depth: usize) {
    let own = nodes.len();
    nodes.push(NO_CHILDREN);
    let mut start = first;
    for (child, part) in quarters(items, depth).into_iter().enumerate() {
        let bounds = part.iter().fold(Bounds::EMPTY, |bounds, item| bounds.union(&item.bounds));
        let below = nodes.len();
        let node = &mut nodes[own];
        for axis in 0..3 {
            node.low[axis][child] = bounds.low[axis];
            node.high[axis][child] = bounds.high[axis];
        }
        if part.len() <= LEAF {
            node.len[child] = part.len() as u8;
            node.first[child] = start as u32;
        } else {
            node.len[child] = 0;
            node.first[child] = below as u32;
            grow(nodes, part, start, depth + 2);
        }
        start += part.len();
    }
}

/// Splits the items in two and both halves again, where they do not fit a leaf.
fn quarters(items: &mut [Item], depth: usize) -> Vec<&mut [Item]> {
    let halves = |items: &'_ mut [Item], depth| -> usize { if items.len() <= LEAF { 0 } else { split(items, depth) } };
    let middle = halves(items, depth);
    let (a, b) = items.split_at_mut(middle);
    let (in_a, in_b) = if a.len() + b.len() > PARALLEL {
        rayon::join(|| halves(a, depth + 1), || halves(b, depth + 1))
    } else {
        (halves(a, depth + 1), halves(b, depth + 1))
    };
    let (a0, a1) = a.split_at_mut(in_a);
    let (b0, b1) = b.split_at_mut(in_b);
    [a0, a1, b0, b1].into_iter().filter(|part| !part.is_empty()).collect()
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    len: usize,
}

/// Orders the items so that the two sides of the cheapest plane stand apart; returns the length of the first.
fn split(items: &mut [Item], depth: usize) -> usize {
    let (low, high) = middles(items);
    let Some((axis, cut)) = (depth < DEPTH).then(|| cheapest_cut(items, low, high)).flatten() else {
        return items.len() / 2;
    };
    let scale = BINS as f32 / (high[axis] - low[axis]);
    let middle = partition(items, |item| bin_of(item, axis, low[axis], scale) < cut);
    if middle == 0 || middle == items.len() { items.len() / 2 } else { middle }
}

/// Smallest and largest (doubled) box middles.
fn middles(items: &[Item]) -> ([f32; 3], [f32; 3]) {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for item in items {
        for axis in 0..3 {
            low[axis] = low[axis].min(item.middle(axis));
            high[axis] = high[axis].max(item.middle(axis));
        }
    }
    (low, high)
}

fn bin_of(item: &Item, axis: usize, low: f32, scale: f32) -> usize {
    (((item.middle(axis) - low) * scale) as usize).min(BINS - 1)
}

/// Axis and bin where the sum of area times count of both sides is least; none where all middles coincide.
fn cheapest_cut(items: &[Item], low: [f32; 3], high: [f32; 3]) -> Option<(usize, usize)> {
    let mut best = None;
    let mut best_cost = f32::INFINITY;
    for axis in 0..3 {
        let scale = BINS as f32 / (high[axis] - low[axis]);
        if !scale.is_finite() {
            continue;
        }
        let mut bins = [Bin { bounds: Bounds::EMPTY, len: 0 }; BINS];
        for item in items {
            let bin = &mut bins[bin_of(item, axis, low[axis], scale)];
            bin.bounds = bin.bounds.union(&item.bounds);
            bin.len += 1;
        }
        for (cut, cost) in costs(&bins).into_iter().enumerate().skip(1) {
            if cost < best_cost {
                (best_cost, best) = (cost, Some((axis, cut)));
            }
        }
    }
    best
}

/// For each bin the cost of cutting before it.
fn costs(bins: &[Bin; BINS]) -> [f32; BINS] {
    let mut costs = [0.0; BINS];
    let add = |side: &mut Bin, bin: &Bin| {
        side.bounds = side.bounds.union(&bin.bounds);
        side.len += bin.len;
        side.bounds.half_area() * side.len as f32
    };
    let mut left = Bin { bounds: Bounds::EMPTY, len: 0 };
    for cut in 1..BINS {
        costs[cut] += add(&mut left, &bins[cut - 1]);
    }
    let mut right = Bin { bounds: Bounds::EMPTY, len: 0 };
    for cut in (1..BINS).rev() {
        costs[cut] += add(&mut right, &bins[cut]);
    }
    costs
}

/// Moves the items with the property to the front; returns how many there are.
fn partition(items: &mut [Item], belongs: impl Fn(&Item) -> bool) -> usize {
    let mut front = 0;
    for i in 0..items.len() {
        if belongs(&items[i]) {
            items.swap(front, i);
            front += 1;
        }
    }
    front
}
