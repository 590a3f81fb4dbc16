//! Edge collapse with carried quadrics (Garland and Heckbert 1997) down to a target, on a closed complex.
//!
//! Borders are closed by apexes that never move, so the link condition of closed surfaces (Dey et al. 1999)
//! is all that keeps the topology: the ends of an edge share exactly the two vertices opposite to it. In which order edges go
//! is said in `rounds`.
//!
//! What is read most lies closest together: a vertex with its quadric fills one cache line, the complex is the ordered
//! neighbours of its vertices alone, and faces are made of them at the end. Large complexes are first collapsed in blocks
//! (`blocks`), side by side and each within the cache.

mod at_height;
mod attribute_quadrics;
mod blocks;
pub(super) mod constraints;
mod half;
mod links;
mod pair;
mod rounds;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::geometry::triangle::area_normal;
use crate::mesh::OneRings;
use crate::mesh::shares::indices_where;

use crate::mesh::shares::PARALLEL;
use crate::simplify::closed::cluster::placement::Placement;
use crate::simplify::closed::pins::OnPlane;
pub(super) use attribute_quadrics::{AttributeQuadrics, of_colours};
use constraints::Holds;
use links::{Links, Span};
use pair::{LocalQuadric, Node};
pub(super) use pair::{Pair, Place};

/// Least cosine between a face's normals before and after a collapse.
const LEAST_COSINE: f32 = 0.2;
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
    /// The price at which each vertex is to be merged with its partner; infinite for those that may not go.
    least: Vec<f32>,
    /// The vertices whose prices are not known; `None` where no price is.
    unpriced: Option<Vec<u32>>,
    /// The vertices whose turn it is in a round.
    turn: Vec<u32>,
    /// Whether each vertex belongs to no edge that may go; empty where all may.
    frozen: Vec<bool>,
    /// For each vertex at the start the one it was when these vertices were numbered; empty where they are the same.
    begun: Vec<u32>,
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

/// The apexes of the borders, each with as many neighbours as there are vertices on its border, and the faces of a surface with
/// these rings, those at the apexes left out.
fn apexes(rings: &OneRings) -> (Vec<Node>, usize) {
    let n_inner = rings.n_vertices();
    let mut n_neighbors = vec![0; rings.n_apexes()];
    if rings.n_apexes() > 0 {
        let at_apexes = (0..n_inner as u32).filter_map(|v| rings.apex(v));
        at_apexes.for_each(|apex| n_neighbors[apex as usize - n_inner] += 1);
    }
    let at_apexes: usize = n_neighbors.iter().map(|n| *n as usize).sum();
    let apexes = n_neighbors.into_iter().map(|len| Node { ring: Span::unlisted(len), ..Node::default() });
    (apexes.collect(), (rings.n_entries() - 2 * at_apexes) / 3)
}

/// When to stop.
#[derive(Clone, Copy)]
pub(in crate::simplify) struct Limit {
    /// Stop at this many vertices.
    pub vertices: usize,
    /// Stop at this many faces.
    pub faces: usize,
}

impl Limit {
    /// The vertices that it leaves, about: of a closed surface as many as half of its faces.
    pub fn size(self) -> usize {
        self.vertices.min(self.faces / 2 + 2)
    }
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

impl Collapse {
    /// Starts from the placed vertices and the rings of the faces over them.
    pub fn new(placed: &Placement, rings: &OneRings) -> Self {
        let n_inner = rings.n_vertices();
        let mut links = Links::with_capacity(n_inner);
        let node = |v: u32| Node::new(placed, v, links.push(rings.ring(v).iter().copied()));
        let mut nodes: Vec<Node> = (0..n_inner as u32).map(node).collect();
        let (apexes, n_faces) = apexes(rings);
        nodes.extend(apexes);
        Self::of(nodes, links, n_inner, n_faces)
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
            least: vec![f32::INFINITY; n_inner],
            unpriced: None,
            turn: Vec::new(),
            frozen: Vec::new(),
            begun: Vec::new(),
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

    /// What is left, renumbered; each face begins with its first vertex.
    pub fn remains(&self) -> Remains {
        let living = indices_where(&self.merged, |v, &merged| v == merged);
        let mut number = vec![NONE; self.n_inner];
        (0u32..).zip(&living).for_each(|(i, &v)| number[v as usize] = i);
        let place = |&v: &u32| self.positions[v as usize];
        let positions: Vec<Vec3> = living.par_iter().with_min_len(PARALLEL).map(place).collect();
        let faces: Vec<Vec<[u32; 3]>> =
            living.par_chunks(PARALLEL).map(|chunk| self.faces_from(chunk, &number)).collect();
        let faces = faces.concat();
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

    /// The faces whose first vertices these are, those at apexes left out, by the numbers of their vertices.
    fn faces_from(&self, vertices: &[u32], number: &[u32]) -> Vec<[u32; 3]> {
        let mut faces = Vec::with_capacity(2 * vertices.len());
        for &v in vertices {
            let span = self.nodes[v as usize].ring;
            let mut last = span.len().checked_sub(1).map_or(NONE, |last| self.links.at(span, last));
            for w in self.links.of(span) {
                if v < last && v < w && !self.is_apex(last.max(w)) {
                    faces.push([v, last, w].map(|v| number[v as usize]));
                }
                last = w;
            }
        }
        faces
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

    fn ring(&self, v: u32) -> impl ExactSizeIterator<Item = u32> + Clone {
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

    /// What merging `u` and `v` costs where something holds it back; infinite where they have to stay two.
    fn price_held(&self, u: u32, v: u32) -> f32 {
        let placement = self.placement(u, v, &self.pair(u, v));
        placement.map_or(f32::INFINITY, |(_, _, cost)| cost as f32)
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
        let [of_u, of_v] = [u, v].map(|w| self.nodes[w as usize].ring);
        let at = self.links.position(of_u, v)?;
        let next = if at + 1 == of_u.len() { 0 } else { at + 1 };
        let opposite = [next, if at == 0 { of_u.len() - 1 } else { at - 1 }].map(|i| self.links.at(of_u, i));
        let n_shared = self.links.n_shared(of_u, of_v);
        let on_border = opposite.iter().any(|&w| self.is_apex(w));
        let bridges = || [u, v].iter().all(|&end| self.ring(end).any(|w| self.is_apex(w))) && !on_border;
        let ok = n_shared == 2
            && (of_u.len() > 3 || of_v.len() > 3)
            && opposite.iter().all(|&w| self.nodes[w as usize].ring.len() > 3)
            && !bridges();
        ok.then_some(opposite)
    }

    /// Whether a face around `u` (without `v`) would turn, or lose its area, when `u` moves to `x`.
    #[inline(always)]
    fn turns_over(&self, u: u32, v: u32, x: Vec3) -> bool {
        let ring = self.nodes[u as usize].ring;
        let p = self.positions[u as usize];
        let at = self.links.position(ring, v).unwrap_or(0);
        let mut before: Option<Vec3> = None;
        for w in self.links.beyond(ring, at) {
            let here = self.positions.get(w as usize).copied();
            if let (Some(q), Some(r)) = (before, here) {
                let (old, new) = (area_normal([p, q, r]), area_normal([x, q, r]));
                let along = old.dot(new);
                let least = LEAST_COSINE * LEAST_COSINE * old.length_squared() * new.length_squared();
                let stays = along > 0.0 && along * along > least && has_area(new, [x, q, r]);
                if !stays && has_area(old, [p, q, r]) {
                    return true;
                }
            }
            before = here;
        }
        false
    }

    /// Joins the neighbours of `v` to `u` instead.
    #[inline(always)]
    fn merge(&mut self, u: u32, v: u32, opposite: [u32; 2]) {
        self.n_vertices -= 1;
        self.n_faces -= opposite.iter().filter(|&&w| !self.is_apex(w)).count();
        self.merged[v as usize] = u;
        let [of_u, of_v] = [u, v].map(|w| self.nodes[w as usize].ring);
        for i in 0..of_v.len() {
            let w = self.links.at(of_v, i);
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
        self.nodes[u as usize].ring = self.links.join([u, v], [of_u, of_v]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{TriMesh, shapes};
    use crate::simplify::closed::cluster::darts::Assignment;
    use crate::simplify::closed::cluster::placement::place;
    use crate::simplify::closed::prepare::surface::Surface;

    fn begin(mesh: &TriMesh) -> (Surface<'_>, Collapse) {
        let surface = Surface::new(mesh);
        let placed = place(&surface, &Assignment::identity(surface.n_vertices()), &[], &surface.faces);
        let collapse = Collapse::new(&placed, &surface.rings);
        (surface, collapse)
    }

    fn down_to(mesh: &TriMesh, vertices: usize) -> (Surface<'_>, End, Remains) {
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
            collapse.unpriced = None;
            collapse.price();
            let price = |&[u, v]: &[u32; 2]| collapse.pair(u, v).placement().2;
            let of = |u: u32| collapse.ring(u).filter(move |&v| v > u).map(move |v| [u, v]);
            let mut edges: Vec<[u32; 2]> =
                collapse.living().flat_map(of).filter(|&[_, v]| !collapse.is_apex(v)).collect();
            edges.sort_by(|x, y| price(x).total_cmp(&price(y)));
            assert!(edges.iter().any(|&[u, v]| collapse.try_collapse(u, v)));
        }
    }

    #[test]
    fn rounds_are_as_good_as_pricing_all_edges_each_time() {
        for mesh in [shapes::wavy_sphere(3, 10.0), shapes::open_cylinder(20, 12)] {
            let error = |collapse: &Collapse| -> f64 {
                collapse.living().map(|v| f64::from(collapse.nodes[v as usize].quadric.c)).sum()
            };
            let (mut in_rounds, mut naive) = (begin(&mesh).1, begin(&mesh).1);
            in_rounds.run(Limit { vertices: 60, faces: usize::MAX });
            naive_run(&mut naive, 60);
            let (in_rounds, naive) = (error(&in_rounds), error(&naive));
            assert!(in_rounds < 1.2 * naive, "{in_rounds} {naive}");
        }
    }
}
