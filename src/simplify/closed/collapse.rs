//! Edge collapse with carried quadrics (Garland and Heckbert 1997) down to a target, on a closed complex.
//!
//! Borders are closed by apexes that never move, so the link condition of closed surfaces (Dey et al. 1999)
//! is all that keeps the topology: the ends of an edge share exactly the two vertices opposite to it.
//! Merging only adds to the quadrics of an edge's ends, so costs only grow: an edge is priced again when its
//! turn comes, not when a neighbour changes.

use glam::{DVec3, Vec3};

use crate::geometry::Quadric;
use crate::mesh::OneRings;

use super::bucket_queue::BucketQueue;

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
    /// Faces, those with an apex last; a dead one begins with `NONE`.
    faces: Vec<Face>,
    /// The vertex each vertex was merged into, itself while it lives.
    merged: Vec<u32>,
    n_inner: usize,
    n_inner_faces: usize,
    n_vertices: usize,
    n_faces: usize,
    queue: BucketQueue<Edge>,
    /// No edge that was not tried since the last merge stands higher in the queue than this.
    untried_below: f32,
    /// The highest price so far.
    highest: f32,
    /// Faces around the edge at hand with the normals they would get.
    turned: Vec<(u32, Vec3)>,
    around: Vec<u32>,
    turn_forbidden: bool,
    is_oriented: bool,
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

/// A vertex: where it is, what it stands for, and the list of its corners (4 x face + place).
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Node {
    quadric: Quadric,
    position: DVec3,
    first_corner: u32,
    last_corner: u32,
    degree: u32,
    /// Grows with every merge; tells an edge that its price is old.
    version: u32,
    is_border: bool,
}

/// A face with, for each corner, the next corner at the same vertex.
#[derive(Clone, Copy)]
struct Face {
    vertices: [u32; 3],
    next_corner: [u32; 3],
    /// Unit normal; zero where there is none.
    normal: Vec3,
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
fn unit_normal([a, b, c]: [DVec3; 3]) -> Vec3 {
    let (p, q) = ((b - a).as_vec3(), (c - a).as_vec3());
    let normal = p.cross(q);
    let (squared, scale) = (normal.length_squared(), p.length_squared().max(q.length_squared()));
    if squared <= 1e-12 * scale * scale { Vec3::ZERO } else { normal / squared.sqrt() }
}

/// The minimum of the summed quadrics of an edge, if it lies near enough to the edge, and its value.
#[inline(always)]
fn minimum_within_reach(sum: &Quadric, [p, q]: [DVec3; 2]) -> Option<(DVec3, f64)> {
    let middle = (p + q) * 0.5;
    sum.minimum().filter(|(x, _)| x.distance_squared(middle) <= REACH * REACH * p.distance_squared(q))
}

/// What else comes into question, and what it costs: the two ends and the middle.
fn candidates(sum: &Quadric, [p, q]: [DVec3; 2]) -> [(DVec3, f64); 3] {
    [p, q, (p + q) * 0.5].map(|x| (x, sum.value(x)))
}

impl Collapse {
    /// Starts from positions and quadrics of the vertices, the faces over them and their rings.
    pub fn new(positions: Vec<DVec3>, quadrics: Vec<Quadric>, inner: Vec<[u32; 3]>, rings: &OneRings) -> Self {
        let apex_faces = rings.apex_faces();
        let (n_inner, n_inner_faces) = (positions.len(), inner.len());
        let node = |(position, quadric)| Node {
            quadric,
            position,
            first_corner: NONE,
            last_corner: NONE,
            degree: 0,
            version: 0,
            is_border: false,
        };
        let apexes = std::iter::repeat_n((DVec3::ZERO, Quadric::default()), rings.n_apexes());
        let mut nodes: Vec<Node> = positions.into_iter().zip(quadrics).chain(apexes).map(node).collect();
        let inner = inner.into_iter().map(|vertices| {
            let normal = unit_normal(vertices.map(|v| nodes[v as usize].position));
            Face { vertices, next_corner: [NONE; 3], normal }
        });
        let mut faces: Vec<Face> = Vec::with_capacity(n_inner_faces + apex_faces.len());
        faces.extend(inner);
        for vertices in apex_faces {
            faces.push(Face { vertices, next_corner: [NONE; 3], normal: Vec3::ZERO });
            vertices.iter().for_each(|&v| nodes[v as usize].is_border = true);
        }
        let mut collapse = Self {
            merged: (0..nodes.len() as u32).collect(),
            nodes,
            faces,
            n_inner,
            n_inner_faces,
            n_vertices: n_inner,
            n_faces: n_inner_faces,
            queue: BucketQueue::new([].into_iter()),
            untried_below: 0.0,
            highest: 0.0,
            turned: Vec::new(),
            around: Vec::new(),
            turn_forbidden: false,
            is_oriented: rings.is_oriented(),
            history: None,
        };
        for f in 0..collapse.faces.len() {
            for (place, v) in collapse.faces[f].vertices.into_iter().enumerate() {
                let corner = (4 * f + place) as u32;
                collapse.append_corners(v, corner, corner);
                collapse.nodes[v as usize].degree += 1;
            }
        }
        collapse
    }

    /// Collapses the cheapest edges until the limit or until none may go.
    pub fn run(&mut self, limit: Limit) -> End {
        while !self.reached(limit) {
            let before = self.n_vertices;
            self.turn_forbidden = false;
            self.fill_queue();
            self.empty_queue(limit);
            if self.n_vertices == before {
                return if self.turn_forbidden { End::WouldTurn } else { End::Smallest };
            }
        }
        End::Reached
    }

    /// What is left, renumbered.
    pub fn finish(self) -> Remains {
        let mut number = vec![NONE; self.n_inner];
        let mut positions = Vec::with_capacity(self.n_vertices);
        for v in (0..self.n_inner).filter(|&v| self.merged[v] == v as u32) {
            number[v] = positions.len() as u32;
            positions.push(self.nodes[v].position.as_vec3());
        }
        let inner = self.faces[..self.n_inner_faces].iter().filter(|f| f.vertices[0] != NONE);
        let faces = inner.clone().map(|f| f.vertices.map(|v| number[v as usize])).collect();
        let normals = inner.map(|f| f.normal).collect();
        let last = |mut v: u32| {
            while self.merged[v as usize] != v {
                v = self.merged[v as usize];
            }
            number[v as usize]
        };
        let vertex_of = (0..self.n_inner as u32).map(last).collect();
        Remains { positions, faces, normals, vertex_of }
    }

    fn reached(&self, limit: Limit) -> bool {
        self.n_vertices <= limit.vertices && self.n_faces <= limit.faces
    }

    fn fill_queue(&mut self) {
        let mut edges = Vec::with_capacity(self.n_faces * 3 / 2);
        // Two faces wound alike run along their edge both ways; without that, edges are priced once or twice.
        let once = self.is_oriented;
        for face in self.faces.iter().filter(|f| f.vertices[0] != NONE) {
            let [a, b, c] = face.vertices;
            for (u, v) in [(a, b), (b, c), (c, a)] {
                if (u < v || !once) && (u.max(v) as usize) < self.n_inner {
                    edges.push(self.price(u, v));
                }
            }
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

    fn price(&self, u: u32, v: u32) -> Edge {
        let stamp = self.nodes[u as usize].version + self.nodes[v as usize].version;
        Edge { ends: [u, v], stamp, cost: self.placement(u, v).1 as f32 }
    }

    /// Where the merged vertex goes and what that costs.
    fn placement(&self, u: u32, v: u32) -> (DVec3, f64) {
        let (sum, ends) = self.sum_and_ends(u, v);
        minimum_within_reach(&sum, ends).unwrap_or_else(|| {
            let candidates = candidates(&sum, ends);
            candidates.into_iter().min_by(|x, y| x.1.total_cmp(&y.1)).unwrap_or(candidates[2])
        })
    }

    /// Which way [`Self::placement`] takes.
    #[cold]
    fn place(&self, u: u32, v: u32) -> Place {
        let (sum, ends) = self.sum_and_ends(u, v);
        if minimum_within_reach(&sum, ends).is_some() {
            return Place::Minimum;
        }
        let ways = [Place::Kept, Place::Gone, Place::Middle].into_iter().zip(candidates(&sum, ends));
        ways.min_by(|x, y| x.1.1.total_cmp(&y.1.1)).map_or(Place::Middle, |(place, _)| place)
    }

    #[inline(always)]
    fn sum_and_ends(&self, u: u32, v: u32) -> (Quadric, [DVec3; 2]) {
        let (u, v) = (&self.nodes[u as usize], &self.nodes[v as usize]);
        (u.quadric + v.quadric, [u.position, v.position])
    }

    /// Merges `v` into `u` if topology and the faces around allow it.
    fn try_collapse(&mut self, u: u32, v: u32) -> bool {
        let Some(opposite) = self.link_allows(u, v) else { return false };
        let (x, _) = self.placement(u, v);
        self.turned.clear();
        if self.turns_over(u, v, x) || self.turns_over(v, u, x) {
            self.turn_forbidden = true;
            return false;
        }
        if self.history.is_some() {
            let merge = Merge { kept: u, gone: v, place: self.place(u, v) };
            self.history.iter_mut().for_each(|history| history.push(merge));
        }
        self.merge(u, v, x, opposite);
        true
    }

    /// The two vertices opposite to edge `u v`, if merging its ends keeps the surface what it is.
    fn link_allows(&mut self, u: u32, v: u32) -> Option<[u32; 2]> {
        let mut around = std::mem::take(&mut self.around);
        around.clear();
        self.for_faces(u, |_, face| around.extend(face.vertices.iter().filter(|&&w| w != u)));
        let mut opposite = [NONE; 2];
        let (mut n_opposite, mut n_shared_twice) = (0, 0);
        self.for_faces(v, |_, face| {
            if face.vertices.contains(&u) {
                let [a, b, c] = face.vertices;
                opposite[n_opposite.min(1)] = a ^ b ^ c ^ u ^ v;
                n_opposite += 1;
            }
            n_shared_twice += face.vertices.iter().filter(|&&w| w != v && w != u && around.contains(&w)).count();
        });
        self.around = around;
        let on_border = opposite.iter().any(|&w| w as usize >= self.n_inner);
        let node = |w: u32| self.nodes.get(w as usize);
        let degree = |w: u32| node(w).map_or(0, |n| n.degree);
        let bridges = [u, v].iter().all(|&w| node(w).is_some_and(|n| n.is_border)) && !on_border;
        let ok = n_opposite == 2
            && n_shared_twice == 4
            && !bridges
            && (degree(u) > 3 || degree(v) > 3)
            && opposite.iter().all(|&w| degree(w) > 3);
        ok.then_some(opposite)
    }

    /// Visits the living faces of `v` with the place of `v` in each, coded as a corner.
    fn for_faces(&self, v: u32, mut visit: impl FnMut(u32, &Face)) {
        let mut corner = self.nodes[v as usize].first_corner;
        while corner != NONE {
            let face = &self.faces[corner as usize / 4];
            if face.vertices[0] != NONE {
                visit(corner, face);
            }
            corner = face.next_corner[corner as usize % 4];
        }
    }

    /// Whether a face around `u` (without `v`) would turn when `u` moves to `x`; notes the normals they would get.
    fn turns_over(&mut self, u: u32, v: u32, x: DVec3) -> bool {
        let mut turned = std::mem::take(&mut self.turned);
        let mut over = false;
        self.for_faces(u, |corner, face| {
            let (f, place) = (corner / 4, corner as usize % 4);
            if !over && (f as usize) < self.n_inner_faces && !face.vertices.contains(&v) {
                let next = self.nodes[face.vertices[(place + 1) % 3] as usize].position;
                let last = self.nodes[face.vertices[(place + 2) % 3] as usize].position;
                let normal = unit_normal([x, next, last]);
                over = face.normal != Vec3::ZERO && face.normal.dot(normal) <= LEAST_COSINE;
                turned.push((f, normal));
            }
        });
        self.turned = turned;
        over
    }

    fn merge(&mut self, u: u32, v: u32, x: DVec3, opposite: [u32; 2]) {
        self.n_vertices -= 1;
        self.n_faces -= opposite.iter().filter(|&&w| (w as usize) < self.n_inner).count();
        self.merged[v as usize] = u;
        self.turned.iter().for_each(|&(f, normal)| self.faces[f as usize].normal = normal);
        self.rename_corners(u, v);
        let gone = self.nodes[v as usize];
        let node = &mut self.nodes[u as usize];
        node.position = x;
        node.quadric += gone.quadric;
        node.is_border |= gone.is_border;
        node.degree = node.degree + gone.degree - 4;
        // Above both, so that no edge of either end passes for priced already.
        node.version += gone.version + 1;
        self.append_corners(u, gone.first_corner, gone.last_corner);
        self.drop_dead_corners(u);
        opposite.iter().for_each(|&w| self.nodes[w as usize].degree -= 1);
    }

    /// In the faces of `v` writes `u` for `v`; the faces of the edge die.
    fn rename_corners(&mut self, u: u32, v: u32) {
        let mut corner = self.nodes[v as usize].first_corner;
        while corner != NONE {
            let face = &mut self.faces[corner as usize / 4];
            if face.vertices.contains(&u) {
                face.vertices[0] = NONE;
            } else if face.vertices[0] != NONE {
                face.vertices[corner as usize % 4] = u;
            }
            corner = face.next_corner[corner as usize % 4];
        }
    }

    fn append_corners(&mut self, v: u32, first: u32, last: u32) {
        let node = &mut self.nodes[v as usize];
        match node.last_corner {
            NONE => node.first_corner = first,
            tail => self.faces[tail as usize / 4].next_corner[tail as usize % 4] = first,
        }
        node.last_corner = last;
    }

    fn drop_dead_corners(&mut self, v: u32) {
        let mut corner = self.nodes[v as usize].first_corner;
        (self.nodes[v as usize].first_corner, self.nodes[v as usize].last_corner) = (NONE, NONE);
        while corner != NONE {
            let face = &mut self.faces[corner as usize / 4];
            let next = std::mem::replace(&mut face.next_corner[corner as usize % 4], NONE);
            if face.vertices[0] != NONE {
                self.append_corners(v, corner, corner);
            }
            corner = next;
        }
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
        let placed = place(&surface, &Assignment::identity(surface.n_vertices()), &surface.faces);
        let collapse = Collapse::new(placed.positions, placed.quadrics, surface.faces.clone(), &surface.rings);
        (surface, collapse)
    }

    fn down_to(mesh: &TriMesh, vertices: usize) -> (Surface, End, Remains) {
        let (surface, mut collapse) = begin(mesh);
        let end = collapse.run(Limit { vertices, faces: usize::MAX });
        (surface, end, collapse.finish())
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
                let living = (0..collapse.n_inner).filter(|&v| collapse.merged[v] == v as u32);
                living.map(|v| collapse.nodes[v].quadric.value(collapse.nodes[v].position)).sum()
            };
            let (mut lazy, mut naive) = (begin(&mesh).1, begin(&mesh).1);
            lazy.run(Limit { vertices: 60, faces: usize::MAX });
            naive_run(&mut naive, 60);
            let (lazy, naive) = (error(&lazy), error(&naive));
            assert!(lazy < 1.2 * naive, "{lazy} {naive}");
        }
    }
}
