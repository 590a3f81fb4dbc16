//! Edge collapse with carried quadrics (Garland and Heckbert 1997) down to a target, on a closed complex.
//!
//! Borders are closed by apexes that never move, so the link condition of closed surfaces (Dey et al. 1999)
//! is all that keeps the topology: the ends of an edge share exactly the two vertices opposite to it.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use glam::{DVec3, Vec3};

use crate::geometry::Quadric;
use crate::geometry::triangle::area_normal_f64;
use crate::mesh::OneRings;

/// A face may not turn by more than this: least cosine between its normals before and after.
const LEAST_COSINE: f32 = 0.2;
const NONE: u32 = u32::MAX;

/// A closed complex being collapsed.
pub(super) struct Collapse {
    positions: Vec<DVec3>,
    /// Faces, those with an apex last; a dead face begins with `NONE`.
    faces: Vec<[u32; 3]>,
    /// Unit normals of the faces without an apex.
    normals: Vec<Vec3>,
    quadrics: Vec<Quadric>,
    /// The vertex each vertex was merged into, itself while it lives.
    merged: Vec<u32>,
    versions: Vec<u32>,
    first_corner: Vec<u32>,
    last_corner: Vec<u32>,
    next_corner: Vec<u32>,
    is_border: Vec<bool>,
    n_inner: usize,
    n_vertices: usize,
    n_faces: usize,
    queue: BinaryHeap<Reverse<Entry>>,
    /// Faces around the edge at hand with the normals they would get.
    turned: Vec<(u32, Vec3)>,
    ring: Vec<u32>,
    marks: Vec<u32>,
    mark: u32,
    turn_forbidden: bool,
}

/// An edge in the queue: cost (the bits of a positive `f32` are ordered as it is), its ends, their versions' sum.
type Entry = (u32, u32, u32, u32);

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
fn unit_normal(corners: [DVec3; 3]) -> Vec3 {
    let normal = area_normal_f64(corners);
    let [a, b, c] = corners;
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    if normal.length_squared() <= 1e-14 * longest * longest { Vec3::ZERO } else { normal.normalize().as_vec3() }
}

impl Collapse {
    /// Starts from positions and quadrics of the vertices, the faces over them and their rings.
    pub fn new(positions: Vec<DVec3>, quadrics: Vec<Quadric>, mut faces: Vec<[u32; 3]>, rings: &OneRings) -> Self {
        let n_inner = positions.len();
        let n_nodes = n_inner + rings.n_apexes();
        let n_faces = faces.len();
        let apex_faces = rings.apex_faces();
        faces.extend_from_slice(&apex_faces);
        let normal = |f: &[u32; 3]| unit_normal(f.map(|v| positions[v as usize]));
        let normals = faces[..n_faces].iter().map(normal).collect();
        let mut is_border = vec![false; n_nodes];
        apex_faces.as_flattened().iter().for_each(|&v| is_border[v as usize] = true);
        let mut collapse = Self {
            positions,
            normals,
            quadrics,
            merged: (0..n_nodes as u32).collect(),
            versions: vec![0; n_nodes],
            first_corner: vec![NONE; n_nodes],
            last_corner: vec![NONE; n_nodes],
            next_corner: vec![NONE; 3 * faces.len()],
            faces,
            is_border,
            n_inner,
            n_vertices: n_inner,
            n_faces,
            queue: BinaryHeap::new(),
            turned: Vec::new(),
            ring: Vec::new(),
            marks: vec![0; n_nodes],
            mark: 0,
            turn_forbidden: false,
        };
        for corner in 0..3 * collapse.faces.len() as u32 {
            let v = collapse.faces[corner as usize / 3][corner as usize % 3];
            collapse.append_corners(v, corner, corner);
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

    fn empty_queue(&mut self, limit: Limit) {
        while !self.reached(limit) {
            let Some(Reverse((_, u, v, stamp))) = self.queue.pop() else { return };
            let alive = self.merged[u as usize] == u && self.merged[v as usize] == v;
            if alive && self.versions[u as usize] + self.versions[v as usize] == stamp {
                self.try_collapse(u, v);
            }
        }
    }

    /// What is left, renumbered.
    pub fn finish(self) -> Remains {
        let mut number = vec![NONE; self.n_inner];
        let mut positions = Vec::with_capacity(self.n_vertices);
        for v in (0..self.n_inner).filter(|&v| self.merged[v] == v as u32) {
            number[v] = positions.len() as u32;
            positions.push(self.positions[v].as_vec3());
        }
        let inner = |f: &&[u32; 3]| f[0] != NONE && f.iter().all(|&v| (v as usize) < self.n_inner);
        let faces = self.faces.iter().filter(inner).map(|f| f.map(|v| number[v as usize])).collect();
        let last = |mut v: u32| {
            while self.merged[v as usize] != v {
                v = self.merged[v as usize];
            }
            number[v as usize]
        };
        let vertex_of = (0..self.n_inner as u32).map(last).collect();
        Remains { positions, faces, vertex_of }
    }

    fn reached(&self, limit: Limit) -> bool {
        self.n_vertices <= limit.vertices && self.n_faces <= limit.faces
    }

    fn fill_queue(&mut self) {
        let mut entries = Vec::with_capacity(self.faces.len() * 3 / 2);
        for face in &self.faces {
            for (u, v) in [(face[0], face[1]), (face[1], face[2]), (face[2], face[0])] {
                if face[0] != NONE && u < v && (v as usize) < self.n_inner {
                    entries.push(Reverse(self.entry(u, v)));
                }
            }
        }
        self.queue = BinaryHeap::from(entries);
    }

    fn entry(&self, u: u32, v: u32) -> Entry {
        let (_, cost) = self.placement(u, v);
        ((cost as f32).to_bits(), u, v, self.versions[u as usize] + self.versions[v as usize])
    }

    /// Where the merged vertex goes and what that costs.
    fn placement(&self, u: u32, v: u32) -> (DVec3, f64) {
        let sum = self.quadrics[u as usize] + self.quadrics[v as usize];
        let (p, q) = (self.positions[u as usize], self.positions[v as usize]);
        let middle = (p + q) * 0.5;
        match sum.minimum() {
            Some((x, cost)) if x.distance_squared(middle) <= 4.0 * p.distance_squared(q) => (x, cost),
            _ => {
                let candidates = [p, q, middle].map(|x| (x, sum.value(x)));
                candidates.into_iter().min_by(|x, y| x.1.total_cmp(&y.1)).unwrap_or((middle, f64::INFINITY))
            }
        }
    }

    fn try_collapse(&mut self, u: u32, v: u32) {
        let Some(shared) = self.link_allows(u, v) else { return };
        let (x, _) = self.placement(u, v);
        self.turned.clear();
        if self.turns_over(u, v, x) || self.turns_over(v, u, x) {
            self.turn_forbidden = true;
            return;
        }
        self.merge(u, v, x, shared);
    }

    /// The two vertices opposite to edge `u v`, if merging its ends keeps the surface what it is.
    fn link_allows(&mut self, u: u32, v: u32) -> Option<[u32; 2]> {
        self.mark += 2;
        let mark = self.mark;
        let mut opposite = [NONE; 2];
        let (mut n_opposite, mut degree_u, mut degree_v) = (0, 0, 0);
        let mut corner = self.first_corner[u as usize];
        while corner != NONE {
            let face = self.faces[corner as usize / 3];
            if face[0] != NONE {
                degree_u += 1;
                face.iter().for_each(|&w| self.marks[w as usize] = mark);
                if face.contains(&v) {
                    if n_opposite < 2 {
                        opposite[n_opposite] = face[0] ^ face[1] ^ face[2] ^ u ^ v;
                    }
                    n_opposite += 1;
                }
            }
            corner = self.next_corner[corner as usize];
        }
        let mut n_shared = 0;
        let mut corner = self.first_corner[v as usize];
        while corner != NONE {
            let face = self.faces[corner as usize / 3];
            if face[0] != NONE {
                degree_v += 1;
                for w in face {
                    if w != u && w != v && self.marks[w as usize] == mark {
                        self.marks[w as usize] = mark + 1;
                        n_shared += 1;
                    }
                }
            }
            corner = self.next_corner[corner as usize];
        }
        let on_border = opposite.iter().any(|&w| w as usize >= self.n_inner);
        let bridges = self.is_border[u as usize] && self.is_border[v as usize] && !on_border;
        let ok = n_opposite == 2
            && n_shared == 2
            && !bridges
            && (degree_u > 3 || degree_v > 3)
            && opposite.iter().all(|&w| self.degree_above_three(w));
        ok.then_some(opposite)
    }

    fn degree_above_three(&self, v: u32) -> bool {
        let mut degree = 0;
        let mut corner = self.first_corner[v as usize];
        while corner != NONE && degree < 4 {
            degree += u32::from(self.faces[corner as usize / 3][0] != NONE);
            corner = self.next_corner[corner as usize];
        }
        degree > 3
    }

    /// Whether a face around `u` (without `v`) would turn when `u` moves to `x`; notes the normals they would get.
    fn turns_over(&mut self, u: u32, v: u32, x: DVec3) -> bool {
        let mut corner = self.first_corner[u as usize];
        while corner != NONE {
            let (f, place) = (corner as usize / 3, corner as usize % 3);
            let face = self.faces[f];
            if f < self.normals.len() && face[0] != NONE && !face.contains(&v) {
                let next = self.positions[face[(place + 1) % 3] as usize];
                let last = self.positions[face[(place + 2) % 3] as usize];
                let normal = unit_normal([x, next, last]);
                let before = self.normals[f];
                if before != Vec3::ZERO && before.dot(normal) <= LEAST_COSINE {
                    return true;
                }
                self.turned.push((f as u32, normal));
            }
            corner = self.next_corner[corner as usize];
        }
        false
    }

    fn merge(&mut self, u: u32, v: u32, x: DVec3, shared: [u32; 2]) {
        self.n_vertices -= 1;
        self.n_faces -= shared.iter().filter(|&&w| (w as usize) < self.n_inner).count();
        self.merged[v as usize] = u;
        self.positions[u as usize] = x;
        self.turned.iter().for_each(|&(f, normal)| self.normals[f as usize] = normal);
        let moved = self.quadrics[v as usize];
        self.quadrics[u as usize] += moved;
        self.is_border[u as usize] |= self.is_border[v as usize];
        self.rename_corners(u, v);
        self.append_corners(u, self.first_corner[v as usize], self.last_corner[v as usize]);
        self.versions[u as usize] += 1;
        self.drop_dead_corners(u);
        self.queue_edges(u);
    }

    /// In the faces of `v` writes `u` for `v`; the faces of the edge die.
    fn rename_corners(&mut self, u: u32, v: u32) {
        let mut corner = self.first_corner[v as usize];
        while corner != NONE {
            let face = &mut self.faces[corner as usize / 3];
            if face[0] != NONE {
                if face.contains(&u) {
                    face[0] = NONE;
                } else {
                    face[corner as usize % 3] = u;
                }
            }
            corner = self.next_corner[corner as usize];
        }
    }

    fn append_corners(&mut self, v: u32, first: u32, last: u32) {
        match self.last_corner[v as usize] {
            NONE => self.first_corner[v as usize] = first,
            tail => self.next_corner[tail as usize] = first,
        }
        self.last_corner[v as usize] = last;
    }

    fn drop_dead_corners(&mut self, v: u32) {
        let mut corner = self.first_corner[v as usize];
        (self.first_corner[v as usize], self.last_corner[v as usize]) = (NONE, NONE);
        while corner != NONE {
            let next = self.next_corner[corner as usize];
            if self.faces[corner as usize / 3][0] != NONE {
                self.next_corner[corner as usize] = NONE;
                self.append_corners(v, corner, corner);
            }
            corner = next;
        }
    }

    fn queue_edges(&mut self, u: u32) {
        let mut ring = std::mem::take(&mut self.ring);
        ring.clear();
        self.mark += 2;
        let mut corner = self.first_corner[u as usize];
        while corner != NONE {
            for w in self.faces[corner as usize / 3] {
                if w != u && (w as usize) < self.n_inner && self.marks[w as usize] != self.mark {
                    self.marks[w as usize] = self.mark;
                    ring.push(w);
                }
            }
            corner = self.next_corner[corner as usize];
        }
        for &w in &ring {
            let entry = self.entry(u.min(w), u.max(w));
            self.queue.push(Reverse(entry));
        }
        self.ring = ring;
    }
}
