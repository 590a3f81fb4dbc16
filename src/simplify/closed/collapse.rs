//! Edge collapse with carried quadrics (Garland and Heckbert 1997) down to a target, on a closed complex.
//!
//! Borders are closed by apexes that never move, so the link condition of closed surfaces (Dey et al. 1999)
//! is all that keeps the topology: the ends of an edge share exactly the two vertices opposite to it.
//! Merging only adds to the quadrics of an edge's ends, so costs only grow: an edge is priced again when its
//! turn comes, not when a neighbour changes.
//!
//! What is read most lies closest together: a vertex with its quadric fills one cache line, the complex is the ordered
//! neighbours of its vertices alone, and faces are made of them at the end.

use glam::{DVec3, Vec3};

use crate::geometry::Quadric;
use crate::geometry::triangle::area_normal;
use crate::mesh::OneRings;

use super::bucket_queue::BucketQueue;
use super::holds::Holds;
use super::links::{Links, Span};

/// Least cosine between a face's normals before and after a collapse.
const LEAST_COSINE: f32 = 0.2;
/// An edge that may not go now is tried again at so many times its price.
const PATIENCE: f32 = 1.5;
/// A merged vertex lies at most this many edge lengths from the middle of its edge.
const REACH: f64 = 2.0;
const NONE: u32 = u32::MAX;

/// A closed complex being collapsed.
pub(super) struct Collapse {
    /// Vertices, the apexes of the borders last.
    nodes: Vec<Node>,
    /// Where the vertices are: what the nodes say, once more and closer together.
    positions: Vec<Vec3>,
    /// The neighbours of the vertices; those of the apexes are not kept.
    links: Links,
    /// The vertex each vertex was merged into, itself while it lives.
    merged: Vec<u32>,
    n_inner: usize,
    n_vertices: usize,
    n_faces: usize,
    queue: BucketQueue<Edge>,
    /// No edge that was not tried since the last merge stands higher in the queue than this.
    untried_below: f32,
    /// The highest price so far.
    highest: f32,
    turn_forbidden: bool,
    /// What holds it back beside the topology.
    pub holds: Option<Holds>,
    /// The merges in order, where they are to be remembered.
    pub history: Option<Vec<Merge>>,
}

/// A merge of two vertices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Merge {
    /// The vertex that stays.
    pub kept: u32,
    /// The one merged into it.
    pub gone: u32,
    /// Where the merged vertex went.
    pub place: Place,
}

/// Where a merged vertex goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Place {
    /// To the minimum of the summed quadrics.
    Minimum,
    /// Where the vertex that stays was.
    Kept,
    /// Where the other one was.
    Gone,
    /// Between them.
    Middle,
}

/// A vertex: where it is, what it stands for, and where its neighbours are listed.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Node {
    position: Vec3,
    quadric: LocalQuadric,
    ring: Span,
    /// Grows with every merge; tells an edge that its price is old.
    version: u32,
}

/// A quadric about its vertex: `d -> d'Ad - 2 b'd + c` for the offset `d` from there. Small numbers, so that single
/// precision holds them as well as double precision held them about the origin.
#[derive(Clone, Copy)]
struct LocalQuadric {
    a: [f32; 6],
    b: [f32; 3],
    c: f32,
}

impl LocalQuadric {
    fn new(quadric: &Quadric, position: Vec3) -> Self {
        let Quadric { a, b, c } = quadric.about(position.as_dvec3());
        Self { a: a.map(|x| x as f32), b: b.as_vec3().to_array(), c: c.max(0.0) as f32 }
    }

    fn wide(&self) -> Quadric {
        Quadric { a: self.a.map(f64::from), b: DVec3::from(self.b.map(f64::from)), c: f64::from(self.c) }
    }
}

/// An edge in the queue: its ends as they were when it was priced, the sum of their versions, and its price.
#[derive(Clone, Copy)]
struct Edge {
    ends: [u32; 2],
    stamp: u32,
    cost: f32,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::simplify) enum End {
    /// At the limit.
    Reached,
    /// Every edge that is left holds the topology: components are at their smallest.
    Smallest,
    /// The edges that could go would turn a face over.
    WouldTurn,
    /// What has to stay leaves no edge that could go.
    Held,
}

/// What is left of the complex, without apexes and dead parts.
pub(super) struct Remains {
    /// Positions, n_vertices x 3.
    pub positions: Vec<Vec3>,
    /// Faces, n_faces x 3.
    pub faces: Vec<[u32; 3]>,
    /// Unit normals of the faces, n_faces x 3; zero where there is none.
    pub normals: Vec<Vec3>,
    /// For each inner vertex at the start the vertex it was merged into.
    pub vertex_of: Vec<u32>,
    /// Whether each vertex has to stay where it is; empty where all may move.
    pub fixed: Vec<bool>,
    /// The vertices of the surface that the vertices lie on, as far as they were to stay on one; empty where none was.
    pub origins: Vec<u32>,
}

/// When to stop.
#[derive(Clone, Copy)]
pub(in crate::simplify) struct Limit {
    /// Stop at this many vertices.
    pub vertices: usize,
    /// Stop at this many faces.
    pub faces: usize,
}

/// Unit normal of a triangle; zero where it has (nearly) no area.
fn unit_normal(corners: [Vec3; 3]) -> Vec3 {
    let normal = area_normal(corners);
    if has_area(normal, corners) { normal / normal.length() } else { Vec3::ZERO }
}

/// Whether this normal of a triangle is more than rounding.
fn has_area(area_normal: Vec3, [a, b, c]: [Vec3; 3]) -> bool {
    let scale = a.distance_squared(b).max(a.distance_squared(c));
    area_normal.length_squared() > 1e-12 * scale * scale
}

/// An edge about to be merged, seen from its first end: the summed quadric about there, and where the other end is.
pub(super) struct Pair {
    sum: Quadric,
    other: DVec3,
}

impl Pair {
    #[inline(always)]
    fn new(u: &Node, v: &Node) -> Self {
        let other = (v.position - u.position).as_dvec3();
        Self { sum: u.quadric.wide() + v.quadric.wide().about(-other), other }
    }

    /// The minimum, if it lies near enough to the edge, and its value.
    #[inline(always)]
    fn minimum_within_reach(&self) -> Option<(DVec3, f64)> {
        let middle = self.other * 0.5;
        self.sum.minimum().filter(|(x, _)| x.distance_squared(middle) <= REACH * REACH * self.other.length_squared())
    }

    /// The best of what else comes into question: the two ends and the middle.
    #[inline(always)]
    fn best_other(&self) -> (Place, DVec3, f64) {
        let [kept, gone, middle] = [Place::Kept, Place::Gone, Place::Middle].map(|place| self.at(place));
        let best = if gone.2 < kept.2 { gone } else { kept };
        if middle.2 < best.2 { middle } else { best }
    }

    /// One of the two ends or, for any other place, the middle, from the first end, and what that costs.
    #[inline(always)]
    pub fn at(&self, place: Place) -> (Place, DVec3, f64) {
        let t = match place {
            Place::Kept => 0.0,
            Place::Gone => 1.0,
            Place::Middle | Place::Minimum => 0.5,
        };
        let Pair { sum, other } = self;
        (place, *other * t, t * t * sum.curvature(*other) - 2.0 * t * sum.b.dot(*other) + sum.c)
    }

    /// What the placement costs, without the place.
    #[inline(always)]
    fn cost(&self) -> f64 {
        let Pair { sum, other } = self;
        let Some((scaled, determinant)) = sum.scaled_minimum() else { return self.best_other().2 };
        let reach = REACH * determinant;
        if scaled.distance_squared(*other * (0.5 * determinant)) <= reach * reach * other.length_squared() {
            (sum.c - sum.b.dot(scaled) / determinant).max(0.0)
        } else {
            self.best_other().2
        }
    }

    /// Where the merged vertex goes, from the first end, and what that costs.
    #[inline(always)]
    pub fn placement(&self) -> (Place, DVec3, f64) {
        match self.minimum_within_reach() {
            Some((x, cost)) => (Place::Minimum, x, cost),
            None => self.best_other(),
        }
    }
}

impl Collapse {
    /// Starts from positions and quadrics of the vertices and the rings of the faces over them.
    pub fn new(positions: &[DVec3], quadrics: &[Quadric], rings: &OneRings) -> Self {
        let (links, spans) = Links::new(rings);
        let n_inner = positions.len();
        let positions: Vec<Vec3> = positions.iter().map(|p| p.as_vec3()).collect();
        let node = |v: usize| Node {
            position: positions[v],
            quadric: LocalQuadric::new(&quadrics[v], positions[v]),
            ring: spans[v],
            version: 0,
        };
        let apex = |span: &Span| Node {
            position: Vec3::ZERO,
            quadric: LocalQuadric::new(&Quadric::default(), Vec3::ZERO),
            ring: *span,
            version: 0,
        };
        let nodes: Vec<Node> = (0..n_inner).map(node).chain(spans[n_inner..].iter().map(apex)).collect();
        let n_borders: usize = spans[n_inner..].iter().map(|span| span.len()).sum();
        Self {
            merged: (0..n_inner as u32).collect(),
            n_faces: (rings.n_entries() - 2 * n_borders) / 3,
            nodes,
            positions,
            links,
            n_inner,
            n_vertices: n_inner,
            queue: BucketQueue::new([].into_iter()),
            untried_below: 0.0,
            highest: 0.0,
            turn_forbidden: false,
            holds: None,
            history: None,
        }
    }

    /// Collapses the cheapest edges until the limit or until none may go.
    pub fn run(&mut self, limit: Limit) -> End {
        while !self.reached(limit) {
            let before = self.n_vertices;
            self.turn_forbidden = false;
            self.fill_queue();
            self.empty_queue(limit);
            if self.n_vertices == before {
                return match (self.holds.is_some(), self.turn_forbidden) {
                    (true, _) => End::Held,
                    (_, true) => End::WouldTurn,
                    _ => End::Smallest,
                };
            }
        }
        End::Reached
    }

    /// What is left, renumbered; each face begins with its first vertex.
    pub fn remains(&self) -> Remains {
        let mut number = vec![NONE; self.n_inner];
        let mut positions = Vec::with_capacity(self.n_vertices);
        for v in self.living() {
            number[v as usize] = positions.len() as u32;
            positions.push(self.positions[v as usize]);
        }
        let mut faces = Vec::with_capacity(self.n_faces);
        for v in self.living() {
            let ring = self.ring(v);
            let mut last = ring.last().copied().unwrap_or(NONE);
            for &w in ring {
                if v < last && v < w && (last.max(w) as usize) < self.n_inner {
                    faces.push([v, last, w].map(|v| number[v as usize]));
                }
                last = w;
            }
        }
        let normals = faces.iter().map(|f| unit_normal(f.map(|v| positions[v as usize]))).collect();
        let last = |mut v: u32| {
            while self.merged[v as usize] != v {
                v = self.merged[v as usize];
            }
            number[v as usize]
        };
        let vertex_of = (0..self.n_inner as u32).map(last).collect();
        let of_living =
            self.holds.iter().flat_map(|holds| self.living().map(move |v| (holds.is_fixed(v), holds.origin(v))));
        let (fixed, origins) = of_living.unzip();
        Remains { positions, faces, normals, vertex_of, fixed, origins }
    }

    fn living(&self) -> impl Iterator<Item = u32> {
        (0..self.n_inner as u32).filter(|&v| self.merged[v as usize] == v)
    }

    fn ring(&self, v: u32) -> &[u32] {
        self.links.of(self.nodes[v as usize].ring)
    }

    fn is_apex(&self, v: u32) -> bool {
        v as usize >= self.n_inner
    }

    fn reached(&self, limit: Limit) -> bool {
        self.n_vertices <= limit.vertices && self.n_faces <= limit.faces
    }

    fn fill_queue(&mut self) {
        let mut edges = Vec::with_capacity(self.n_faces * 3 / 2 + 3);
        for u in self.living() {
            let later = self.ring(u).iter().filter(|&&v| v > u && !self.is_apex(v));
            edges.extend(later.map(|&v| self.price(u, v)).filter(|edge| edge.cost < f32::INFINITY));
        }
        self.highest = edges.iter().map(|edge| edge.cost).fold(0.0, f32::max);
        self.untried_below = self.highest;
        self.queue = BucketQueue::new(edges.iter().map(|edge| (edge.cost, *edge)));
    }

    /// Collapses edges in the order of their prices, until the limit or until all were tried in vain as they are.
    fn empty_queue(&mut self, limit: Limit) {
        while !self.reached(limit) {
            let Some(edge) = self.queue.pop() else { return };
            let [u, v] = edge.ends.map(|end| self.current(end));
            if u == v {
                continue;
            }
            if edge.stamp != self.nodes[u as usize].version + self.nodes[v as usize].version {
                let edge = self.price(u, v);
                if edge.cost == f32::INFINITY {
                    continue;
                }
                self.highest = self.highest.max(edge.cost);
                self.untried_below = self.untried_below.max(edge.cost);
                self.queue.push(edge.cost, edge);
            } else if self.try_collapse(u, v) {
                self.untried_below = self.highest;
            } else if edge.cost > self.untried_below * (1.0 + 2.0 * BucketQueue::<Edge>::WIDTH) + f32::MIN_POSITIVE {
                return;
            } else if edge.cost < f32::MAX / PATIENCE {
                let cost = edge.cost.max(f32::MIN_POSITIVE) * PATIENCE;
                self.highest = self.highest.max(cost);
                self.queue.push(cost, Edge { cost, ..edge });
            }
        }
    }

    /// The vertex that stands for `v` now.
    fn current(&mut self, mut v: u32) -> u32 {
        while self.merged[v as usize] != v {
            self.merged[v as usize] = self.merged[self.merged[v as usize] as usize];
            v = self.merged[v as usize];
        }
        v
    }

    fn pair(&self, u: u32, v: u32) -> Pair {
        Pair::new(&self.nodes[u as usize], &self.nodes[v as usize])
    }

    #[inline(always)]
    fn price(&self, u: u32, v: u32) -> Edge {
        let stamp = self.nodes[u as usize].version + self.nodes[v as usize].version;
        let pair = self.pair(u, v);
        let cost = match &self.holds {
            None => pair.cost() as f32,
            Some(holds) => holds.placement(u, v, &pair).map_or(f32::INFINITY, |(_, _, cost)| cost as f32),
        };
        Edge { ends: [u, v], stamp, cost }
    }

    /// Where the merged vertex goes, from `u`, and what that costs; `None` where they have to stay two.
    #[inline(always)]
    fn placement(&self, u: u32, v: u32, pair: &Pair) -> Option<(Place, DVec3, f64)> {
        match &self.holds {
            None => Some(pair.placement()),
            Some(holds) => holds.placement(u, v, pair),
        }
    }

    /// Merges `v` into `u` if topology and the faces around allow it.
    fn try_collapse(&mut self, u: u32, v: u32) -> bool {
        let Some(opposite) = self.link_allows(u, v) else { return false };
        let pair = self.pair(u, v);
        let Some((place, offset, _)) = self.placement(u, v, &pair) else { return false };
        if self.holds.as_ref().is_some_and(|holds| !holds.outlive(u, v, opposite)) {
            return false;
        }
        let x = (self.nodes[u as usize].position.as_dvec3() + offset).as_vec3();
        if self.turns_over(u, v, x) || self.turns_over(v, u, x) {
            self.turn_forbidden = true;
            return false;
        }
        self.history.iter_mut().for_each(|history| history.push(Merge { kept: u, gone: v, place }));
        self.merge(u, v, opposite);
        self.holds.iter_mut().for_each(|holds| holds.merge(u, v, place));
        let node = &mut self.nodes[u as usize];
        // About the position as it was rounded.
        node.quadric = LocalQuadric::new(&pair.sum, x - node.position);
        node.position = x;
        self.positions[u as usize] = x;
        true
    }

    /// The two vertices opposite to edge `u v`, if merging its ends keeps the surface what it is.
    fn link_allows(&self, u: u32, v: u32) -> Option<[u32; 2]> {
        let (of_u, of_v) = (self.ring(u), self.ring(v));
        let at = of_u.iter().position(|&w| w == v)?;
        let next = if at + 1 == of_u.len() { 0 } else { at + 1 };
        let opposite = [of_u[next], of_u[if at == 0 { of_u.len() - 1 } else { at - 1 }]];
        let n_shared = of_v.iter().map(|w| usize::from(of_u.contains(w))).sum::<usize>();
        let on_border = opposite.iter().any(|&w| self.is_apex(w));
        let bridges = || [of_u, of_v].iter().all(|ring| ring.iter().any(|&w| self.is_apex(w))) && !on_border;
        let ok = n_shared == 2
            && (of_u.len() > 3 || of_v.len() > 3)
            && opposite.iter().all(|&w| self.nodes[w as usize].ring.len() > 3)
            && !bridges();
        ok.then_some(opposite)
    }

    /// Whether a face around `u` (without `v`) would turn when `u` moves to `x`.
    fn turns_over(&self, u: u32, v: u32, x: Vec3) -> bool {
        let ring = self.ring(u);
        let p = self.positions[u as usize];
        let at = ring.iter().position(|&w| w == v).unwrap_or(0);
        let mut before: Option<Vec3> = None;
        for &w in ring[at + 1..].iter().chain(&ring[..at]) {
            let here = self.positions.get(w as usize).copied();
            if let (Some(q), Some(r)) = (before, here) {
                let (old, new) = (area_normal([p, q, r]), area_normal([x, q, r]));
                let stays = old.dot(new) > LEAST_COSINE * old.length() * new.length();
                if !stays && has_area(old, [p, q, r]) {
                    return true;
                }
            }
            before = here;
        }
        false
    }

    /// Joins the neighbours of `v` to `u` instead.
    fn merge(&mut self, u: u32, v: u32, opposite: [u32; 2]) {
        self.n_vertices -= 1;
        self.n_faces -= opposite.iter().filter(|&&w| !self.is_apex(w)).count();
        self.merged[v as usize] = u;
        let [of_u, of_v] = [u, v].map(|w| self.nodes[w as usize].ring);
        for i in 0..of_v.len() {
            let w = self.links.of(of_v)[i];
            let is_opposite = opposite.contains(&w);
            if self.is_apex(w) {
                let ring = &mut self.nodes[w as usize].ring;
                *ring = if is_opposite { ring.shorter() } else { *ring };
            } else if is_opposite {
                self.links.remove(&mut self.nodes[w as usize].ring, v);
            } else if w != u {
                self.links.replace(self.nodes[w as usize].ring, v, u);
            }
        }
        let gone = self.nodes[v as usize].version;
        let node = &mut self.nodes[u as usize];
        node.ring = self.links.join([u, v], [of_u, of_v]);
        // Above both, so that no edge of either end passes for priced already.
        node.version += gone + 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::darts::Assignment;
    use crate::simplify::closed::placement::place;
    use crate::simplify::closed::surface::Surface;

    fn begin(mesh: &TriMesh) -> (Surface, Collapse) {
        let surface = Surface::new(mesh);
        let placed = place(&surface, &Assignment::identity(surface.n_vertices()), &[], &surface.faces);
        let collapse = Collapse::new(&placed.positions, &placed.quadrics, &surface.rings);
        (surface, collapse)
    }

    fn down_to(mesh: &TriMesh, vertices: usize) -> (Surface, End, Remains) {
        let (surface, mut collapse) = begin(mesh);
        let end = collapse.run(Limit { vertices, faces: usize::MAX });
        (surface, end, collapse.remains())
    }

    fn assert_corners_stay(mesh: &TriMesh, corners: &[[f32; 3]]) {
        let (surface, end, remains) = down_to(mesh, corners.len());
        assert_eq!((end, remains.positions.len()), (End::Reached, corners.len()));
        let left: Vec<[f32; 3]> = remains.positions.iter().map(|p| surface.scale.restore(p.as_dvec3())).collect();
        for &corner in corners {
            let nearest = left.iter().map(|&p| Vec3::from(p).distance(corner.into())).fold(f32::INFINITY, f32::min);
            assert!(nearest < 1e-3, "{corner:?} {nearest}");
        }
    }

    #[test]
    fn corners_are_what_stays_of_flat_parts() {
        let cube: Vec<[f32; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|x| x as f32)).collect();
        assert_corners_stay(&shapes::cuboid([1.0; 3], 5), &cube);
        let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];
        assert_corners_stay(&shapes::grid(9, 6), &square);
    }

    #[test]
    fn the_smallest_surfaces_stay() {
        let tetrahedra =
            (0..300u32).flat_map(|i| [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]].map(|f| f.map(|v| 4 * i + v)));
        let places = (0..300).flat_map(|i| {
            let x = 3.0 * i as f32;
            [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0], [x, 0.0, 1.0]]
        });
        let mesh = TriMesh::new(places.collect(), tetrahedra.collect()).unwrap();
        for shape in [&mesh, &shapes::tetrahedron()] {
            let (_, end, remains) = down_to(shape, 1);
            assert_eq!((end, remains.faces.len()), (End::Smallest, shape.faces().len()));
        }
        for shape in [shapes::icosphere(2), shapes::cuboid([1.0; 3], 3)] {
            let (_, end, remains) = down_to(&shape, 1);
            assert!(end != End::Reached && remains.positions.len() <= 8, "{end:?}");
        }
    }

    #[test]
    fn every_vertex_is_told_what_became_of_it() {
        let mesh = shapes::torus(24, 10, 1.0, 0.3);
        let (_, _, remains) = down_to(&mesh, 50);
        assert_eq!(remains.vertex_of.len(), mesh.positions().len());
        let mut used = vec![false; 50];
        remains.vertex_of.iter().for_each(|&v| used[v as usize] = true);
        assert_eq!(used, [true; 50]);
        assert_eq!((remains.faces.len(), remains.normals.len()), (100, 100));
    }

    /// Always the cheapest edge that may go, all edges priced anew each time.
    fn naive_run(collapse: &mut Collapse, vertices: usize) {
        while collapse.n_vertices > vertices {
            collapse.fill_queue();
            let mut edges: Vec<Edge> = std::iter::from_fn(|| collapse.queue.pop()).collect();
            edges.sort_by(|x, y| x.cost.total_cmp(&y.cost));
            let gone = edges.iter().any(|edge| collapse.try_collapse(edge.ends[0], edge.ends[1]));
            assert!(gone);
        }
    }

    #[test]
    fn the_lazy_queue_is_as_good_as_pricing_all_edges_each_time() {
        for mesh in [shapes::wavy_sphere(3, 10.0), shapes::open_cylinder(20, 12)] {
            let error = |collapse: &Collapse| -> f64 {
                collapse.living().map(|v| f64::from(collapse.nodes[v as usize].quadric.c)).sum()
            };
            let (mut lazy, mut naive) = (begin(&mesh).1, begin(&mesh).1);
            lazy.run(Limit { vertices: 60, faces: usize::MAX });
            naive_run(&mut naive, 60);
            let (lazy, naive) = (error(&lazy), error(&naive));
            assert!(lazy < 1.2 * naive, "{lazy} {naive}");
        }
    }
}
