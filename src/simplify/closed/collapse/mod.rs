//! Edge collapse with carried quadrics (Garland and Heckbert 1997) down to a target, on a closed complex.
//!
//! Borders are closed by apexes that never move, so the link condition of closed surfaces (Dey et al. 1999)
//! is all that keeps the topology: the ends of an edge share exactly the two vertices opposite to it.
//! The edges of a merged vertex are priced at once, side by side, and put into the queue anew; what stands there of them from
//! before has an old stamp and is passed over when its turn comes.
//!
//! What is read most lies closest together: a vertex with its quadric fills one cache line, the complex is the ordered
//! neighbours of its vertices alone, and faces are made of them at the end. Large complexes are first collapsed in blocks
//! (`blocks`), side by side and each within the cache.

mod at_height;
mod attribute_quadrics;
mod blocks;
mod bucket_queue;
mod half;
mod links;
mod pair;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::triangle::area_normal;
use crate::linalg::{Isa, Work};
use crate::mesh::OneRings;

use super::half::OnPlane;
use super::holds::Holds;
use super::placement::Placement;
pub(super) use attribute_quadrics::{AttributeQuadrics, of_colours};
use bucket_queue::BucketQueue;
use links::{Links, Span};
use pair::{LocalQuadric, Node, SIDE_BY_SIDE, price, prices, prices_of};
pub(super) use pair::{Pair, Place};

/// An edge that may not go now is tried again at so many times its price.
const PATIENCE: f32 = 1.5;
/// Edges in the queue per merge that is to be done: as many as come up in the course of it, and more.
const EDGES_PER_MERGE: usize = 8;
/// Fewer merges than this are counted as so many.
const LEAST_MERGES: usize = 4096;
/// Least cosine between a face's normals before and after a collapse.
const LEAST_COSINE: f32 = 0.2;
/// Faces or vertices that a thread takes at once.
const PARALLEL: usize = 4096;
const NONE: u32 = u32::MAX;
/// The version of a vertex that was merged into another. No edge of it has the stamp of one that was priced while its ends
/// lived: their versions count merges, of which there are fewer.
const MERGED: u32 = 1 << 30;

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
    /// Whether each vertex belongs to no edge that may go; empty where all may.
    frozen: Vec<bool>,
    /// For each vertex at the start the one it was when these vertices were numbered; empty where they are the same.
    begun: Vec<u32>,
    /// No edge that was not tried since the last merge stands higher in the queue than this.
    untried_below: f32,
    /// The highest price so far.
    highest: f32,
    turn_forbidden: bool,
    /// What merges cost the colours at the corners, if there are any.
    pub colours: AttributeQuadrics,
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

/// An edge in the queue: its ends as they were when it was priced, and the sum of their versions.
#[derive(Clone, Copy, Default)]
struct Edge {
    ends: [u32; 2],
    stamp: u32,
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
    /// What stays on the plane, where the surface is one half of a mirrored one.
    pub on_plane: Option<OnPlane>,
}

/// The merges without which so many vertices and faces do not come to the limit: each takes away two faces at most.
fn merges_to(limit: Limit, n_vertices: usize, n_faces: usize) -> usize {
    n_vertices.saturating_sub(limit.vertices).max(n_faces.saturating_sub(limit.faces).div_ceil(2))
}

/// The apexes of the borders, each with as many neighbours as there are vertices on its border.
fn apexes(rings: &OneRings) -> Vec<Node> {
    let n_inner = rings.n_vertices();
    let mut n_neighbors = vec![0; rings.n_apexes()];
    if rings.n_apexes() > 0 {
        let at_apexes = (0..n_inner as u32).filter_map(|v| rings.apex(v));
        at_apexes.for_each(|apex| n_neighbors[apex as usize - n_inner] += 1);
    }
    n_neighbors.into_iter().map(|len| Node { ring: Span::unlisted(len), ..Node::default() }).collect()
}

/// The faces of a surface with these rings, those at the apexes left out.
fn n_faces(rings: &OneRings) -> usize {
    let at_apexes: usize = apexes(rings).iter().map(|apex| apex.ring.len()).sum();
    (rings.n_entries() - 2 * at_apexes) / 3
}

/// How many vertices both rings hold.
fn n_shared(of_u: &[u32], of_v: &[u32]) -> usize {
    const SHORT: usize = 8;
    if of_u.len() > SHORT {
        return of_v.iter().filter(|w| of_u.contains(w)).count();
    }
    let mut padded = [NONE; SHORT];
    padded[..of_u.len()].copy_from_slice(of_u);
    of_v.iter().map(|w| usize::from(padded.iter().fold(false, |any, x| any | (x == w)))).sum()
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

/// [`Collapse::empty_queue`] as work that is compiled for the instructions at hand.
struct EmptyQueue<'a> {
    collapse: &'a mut Collapse,
    limit: Limit,
    most: f32,
}

impl Work for EmptyQueue<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.collapse.pop_until(self.limit, self.most);
    }
}

impl Collapse {
    /// Starts from the placed vertices and the rings of the faces over them.
    pub fn new(placed: &Placement, rings: &OneRings) -> Self {
        let n_inner = placed.positions.len();
        let mut links = Links::with_capacity(rings.n_entries(), n_inner);
        let node = |v: u32| Node::new(placed, v, links.push(rings.ring(v).iter().copied()));
        let mut nodes: Vec<Node> = (0..n_inner as u32).map(node).collect();
        nodes.extend(apexes(rings));
        Self::of(nodes, links, n_inner, n_faces(rings))
    }

    /// As [`Collapse::new`], and on the way down to the limit as far as blocks go, if there are enough vertices for them.
    pub fn toward(limit: Limit, placed: &Placement, rings: &OneRings) -> Self {
        if blocks::are_worth_it(rings.n_vertices()) {
            return blocks::collapse_in_blocks(placed, rings, limit);
        }
        Self::new(placed, rings)
    }

    /// Starts from nodes, the apexes last, and their neighbours.
    fn of(nodes: Vec<Node>, links: Links, n_inner: usize, n_faces: usize) -> Self {
        Self {
            positions: nodes[..n_inner].iter().map(|node| node.position).collect(),
            merged: (0..n_inner as u32).collect(),
            nodes,
            links,
            n_inner,
            n_vertices: n_inner,
            n_faces,
            queue: BucketQueue::default(),
            frozen: Vec::new(),
            begun: Vec::new(),
            untried_below: 0.0,
            highest: 0.0,
            turn_forbidden: false,
            colours: AttributeQuadrics::default(),
            holds: None,
            history: None,
        }
    }

    /// Collapses the cheapest edges until the limit or until none may go.
    pub fn run(&mut self, limit: Limit) -> End {
        if self.on_plane().is_some() { self.run_half(limit) } else { self.run_to(limit) }
    }

    fn run_to(&mut self, limit: Limit) -> End {
        let (n_vertices, n_faces) = self.size();
        let mut n_edges = EDGES_PER_MERGE.saturating_mul(merges_to(limit, n_vertices, n_faces).max(LEAST_MERGES));
        while !self.reached(limit) {
            let before = self.n_vertices;
            self.turn_forbidden = false;
            let most = self.fill_queue(n_edges);
            self.empty_queue(limit, most);
            if self.n_vertices == before && most == f32::INFINITY {
                return match (self.holds.is_some(), self.turn_forbidden) {
                    (true, _) => End::Held,
                    (_, true) => End::WouldTurn,
                    _ => End::Smallest,
                };
            }
            n_edges = usize::MAX;
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
        let normal = |face: &[u32; 3]| unit_normal(face.map(|v| positions[v as usize]));
        let normals = faces.par_iter().with_min_len(PARALLEL).map(normal).collect();
        let last = |v: u32| number[self.last(v) as usize];
        let vertex_of = match self.begun.as_slice() {
            [] => (0..self.n_inner as u32).into_par_iter().with_min_len(PARALLEL).map(last).collect(),
            begun => begun.par_iter().with_min_len(PARALLEL).map(|&v| last(v)).collect(),
        };
        let of_living =
            self.holds.iter().flat_map(|holds| self.living().map(move |v| (holds.is_fixed(v), holds.origin(v))));
        let (fixed, origins) = of_living.unzip();
        let on_plane = self.on_plane().map(|on_plane| on_plane.of_living(self.living()));
        Remains { positions, faces, normals, vertex_of, fixed, origins, on_plane }
    }

    /// The vertex that stands for `v` now.
    fn last(&self, mut v: u32) -> u32 {
        while self.merged[v as usize] != v {
            v = self.merged[v as usize];
        }
        v
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

    fn is_frozen(&self, v: u32) -> bool {
        self.frozen.get(v as usize).is_some_and(|frozen| *frozen)
    }

    fn reached(&self, limit: Limit) -> bool {
        let (n_vertices, n_faces) = self.size();
        n_vertices <= limit.vertices && n_faces <= limit.faces
    }

    /// Vertices and faces; where this is one half of a mirrored mesh, those of the whole.
    fn size(&self) -> (usize, usize) {
        match self.on_plane() {
            None => (self.n_vertices, self.n_faces),
            Some(on_plane) => (2 * self.n_vertices - on_plane.len(), 2 * self.n_faces),
        }
    }

    /// Begins a queue with about as many of the cheapest edges as are wanted; returns up to which price it has all.
    fn fill_queue(&mut self, wanted: usize) -> f32 {
        let edges = self.edges();
        let costs = if self.is_plain() {
            prices(&self.nodes, &edges)
        } else {
            edges.iter().map(|&[u, v]| self.price(u, v)).collect()
        };
        self.highest = costs.iter().copied().filter(|cost| *cost < f32::INFINITY).fold(0.0, f32::max);
        self.untried_below = self.highest;
        let edge = |(&cost, &ends): (&f32, &[u32; 2])| (cost, Edge { ends, stamp: self.stamp(ends) });
        let most;
        (self.queue, most) = BucketQueue::new(costs.iter().zip(&edges).map(edge), wanted);
        most
    }

    /// The edges that may go, their ends ascending.
    fn edges(&self) -> Vec<[u32; 2]> {
        let mut edges = Vec::with_capacity(self.n_faces * 3 / 2 + 3);
        for u in self.living().filter(|&u| !self.is_frozen(u)) {
            let later = self.ring(u).iter().filter(|&&v| v > u && !self.is_apex(v) && !self.is_frozen(v));
            edges.extend(later.map(|&v| [u, v]));
        }
        edges
    }

    /// Collapses edges in the order of their prices up to `most`, until the limit or until all were tried in vain as
    /// they are.
    fn empty_queue(&mut self, limit: Limit, most: f32) {
        Isa::best().run(EmptyQueue { collapse: self, limit, most });
    }

    #[inline(always)]
    fn pop_until(&mut self, limit: Limit, most: f32) {
        while !self.reached(limit) {
            let Some((cost, edge)) = self.queue.pop(most) else { return };
            let [u, v] = edge.ends;
            if edge.stamp != self.stamp(edge.ends) {
                continue;
            }
            if self.try_collapse(u, v) {
                self.push_edges_of(u);
                self.untried_below = self.highest;
            } else if cost > self.untried_below * (1.0 + 2.0 * BucketQueue::<Edge>::WIDTH) + f32::MIN_POSITIVE {
                return;
            } else if cost < f32::MAX / PATIENCE {
                let cost = cost.max(f32::MIN_POSITIVE) * PATIENCE;
                self.highest = self.highest.max(cost);
                self.queue.push(cost, edge);
            }
        }
    }

    /// Puts the edges of a merged vertex into the queue anew.
    #[inline(always)]
    fn push_edges_of(&mut self, u: u32) {
        let ring = self.nodes[u as usize].ring;
        for first in (0..ring.len()).step_by(SIDE_BY_SIDE) {
            let ends: [u32; SIDE_BY_SIDE] = self.links.some_of(ring, first);
            let costs = if self.is_plain() {
                prices_of(ends.map(|w| (&self.nodes[u as usize], &self.nodes[w as usize])))
            } else {
                ends.map(|w| if self.is_apex(w) { f32::INFINITY } else { self.price(u, w) })
            };
            for (&w, cost) in ends.iter().zip(costs).take(ring.len() - first) {
                if !self.is_apex(w) && !self.is_frozen(w) && cost < f32::INFINITY {
                    self.highest = self.highest.max(cost);
                    self.queue.push(cost, Edge { ends: [u, w], stamp: self.stamp([u, w]) });
                }
            }
        }
    }

    /// Changes with every merge of one of the two.
    fn stamp(&self, [u, v]: [u32; 2]) -> u32 {
        self.nodes[u as usize].version + self.nodes[v as usize].version
    }

    /// Whether nothing but the quadrics of the nodes says what a merge costs.
    #[inline(always)]
    fn is_plain(&self) -> bool {
        self.holds.is_none() && self.colours.is_empty()
    }

    fn pair(&self, u: u32, v: u32) -> Pair {
        let mut pair = Pair::new(&self.nodes[u as usize], &self.nodes[v as usize]);
        if !self.colours.is_empty() {
            pair.sum += self.colours.cost([u, v], pair.other());
        }
        pair
    }

    /// What merging `u` and `v` costs; infinite where they have to stay two.
    #[inline(always)]
    fn price(&self, u: u32, v: u32) -> f32 {
        if self.is_plain() {
            return price(&self.nodes[u as usize], &self.nodes[v as usize]);
        }
        self.placement(u, v, &self.pair(u, v)).map_or(f32::INFINITY, |(_, _, cost)| cost as f32)
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
    #[inline(always)]
    fn try_collapse(&mut self, u: u32, v: u32) -> bool {
        let Some(opposite) = self.link_allows(u, v) else { return false };
        let pair = self.pair(u, v);
        let Some((place, offset, _)) = self.placement(u, v, &pair) else { return false };
        if self.holds.as_ref().is_some_and(|holds| !holds.outlive(u, v, opposite)) || self.would_bridge(u, v) {
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
        let [kept, gone] = [u, v].map(|w| &self.nodes[w as usize]);
        let step = x - kept.position;
        let planes = if self.colours.is_empty() { pair.sum } else { Pair::new(kept, gone).sum };
        self.colours.merge([u, v], pair.other(), step.as_dvec3());
        let node = &mut self.nodes[u as usize];
        // About the position as it was rounded.
        node.quadric = LocalQuadric::new(&planes, step);
        node.position = x;
        self.positions[u as usize] = x;
        true
    }

    /// The two vertices opposite to edge `u v`, if merging its ends keeps the surface what it is.
    #[inline(always)]
    fn link_allows(&self, u: u32, v: u32) -> Option<[u32; 2]> {
        let (of_u, of_v) = (self.ring(u), self.ring(v));
        let at = of_u.iter().position(|&w| w == v)?;
        let next = if at + 1 == of_u.len() { 0 } else { at + 1 };
        let opposite = [of_u[next], of_u[if at == 0 { of_u.len() - 1 } else { at - 1 }]];
        let n_shared = n_shared(of_u, of_v);
        let on_border = opposite.iter().any(|&w| self.is_apex(w));
        let bridges = || [of_u, of_v].iter().all(|ring| ring.iter().any(|&w| self.is_apex(w))) && !on_border;
        let ok = n_shared == 2
            && (of_u.len() > 3 || of_v.len() > 3)
            && opposite.iter().all(|&w| self.nodes[w as usize].ring.len() > 3)
            && !bridges();
        ok.then_some(opposite)
    }

    /// Whether a face around `u` (without `v`) would turn when `u` moves to `x`.
    #[inline(always)]
    fn turns_over(&self, u: u32, v: u32, x: Vec3) -> bool {
        let ring = self.ring(u);
        let p = self.positions[u as usize];
        let at = ring.iter().position(|&w| w == v).unwrap_or(0);
        let mut before: Option<Vec3> = None;
        for &w in ring[at + 1..].iter().chain(&ring[..at]) {
            let here = self.positions.get(w as usize).copied();
            if let (Some(q), Some(r)) = (before, here) {
                let (old, new) = (area_normal([p, q, r]), area_normal([x, q, r]));
                let along = old.dot(new);
                let least = LEAST_COSINE * LEAST_COSINE * old.length_squared() * new.length_squared();
                if !(along > 0.0 && along * along > least) && has_area(old, [p, q, r]) {
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
        self.nodes[v as usize].version = MERGED;
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
        let collapse = Collapse::new(&placed, &surface.rings);
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
            collapse.fill_queue(usize::MAX);
            let mut edges: Vec<(f32, Edge)> = std::iter::from_fn(|| collapse.queue.pop(f32::INFINITY)).collect();
            edges.sort_by(|x, y| x.0.total_cmp(&y.0));
            let gone = edges.iter().any(|(_, edge)| collapse.try_collapse(edge.ends[0], edge.ends[1]));
            assert!(gone);
        }
    }

    #[test]
    fn the_queue_is_as_good_as_pricing_all_edges_each_time() {
        for mesh in [shapes::wavy_sphere(3, 10.0), shapes::open_cylinder(20, 12)] {
            let error = |collapse: &Collapse| -> f64 {
                collapse.living().map(|v| f64::from(collapse.nodes[v as usize].quadric.c)).sum()
            };
            let (mut by_queue, mut naive) = (begin(&mesh).1, begin(&mesh).1);
            by_queue.run(Limit { vertices: 60, faces: usize::MAX });
            naive_run(&mut naive, 60);
            let (by_queue, naive) = (error(&by_queue), error(&naive));
            assert!(by_queue < 1.2 * naive, "{by_queue} {naive}");
        }
    }
}
