//! Topology of some faces, joinable with that of others at shared vertices.

use rustc_hash::FxHashMap;

use super::TriMesh;
use super::first_equal::{PositionKey, position_key};
use super::half_edges::{HalfEdge, for_each_edge, next, start};
use super::topology_figures::Topology;
use super::union_find::UnionFind;
use super::windings::Windings;

/// The topology of some faces: counts of complete elements, and those that other faces may extend.
///
/// A fan is a set of corners at one vertex joined over edges.
#[derive(Clone, Debug, Default)]
#[doc(hidden)]
pub struct TopologyPatch {
    /// Counts of complete elements; vertices are those that are not shared, edges those with an unshared end.
    pub closed: Topology,
    pub n_closed_fans: usize,
    pub is_one_sided: bool,
    pub n_open_components: u32,
    pub n_open_sides: u32,
    /// Position of the vertex of each open fan.
    pub open_fans: Vec<PositionKey>,
    pub curves: Vec<[u32; 2]>,
    /// Half-edges between two shared vertices.
    pub open_edges: Vec<OpenEdge>,
}

#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct OpenEdge {
    pub ends: [PositionKey; 2],
    pub fans: [u32; 2],
    pub component: u32,
    pub side: u32,
    /// True if the face is wound opposite to the first face of its side.
    pub is_turned: bool,
}

impl OpenEdge {
    pub fn places(&self) -> [PositionKey; 2] {
        let [a, b] = self.ends;
        [a.min(b), a.max(b)]
    }

    pub fn fans_along(&self, other: &Self) -> [u32; 2] {
        let [a, b] = self.fans;
        if self.ends == other.ends { [a, b] } else { [b, a] }
    }
}

impl TopologyPatch {
    /// Builds the topology of one block of a mesh; `is_shared` accepts vertices that other blocks use.
    pub fn new(mesh: &TriMesh, is_shared: impl Fn(u32) -> bool) -> Self {
        let mut links = Links::new(mesh);
        for_each_edge(mesh.positions().len(), mesh.faces(), |[a, b], half_edges| {
            if is_shared(a) && is_shared(b) {
                links.open.extend(half_edges.iter().map(|of| of.half_edge));
            } else {
                links.join(half_edges);
            }
        });
        let mut patch = Self { closed: links.counts, ..Self::default() };
        let fans = links.open_fans(&mut patch, &is_shared);
        links.trace_boundary(&mut patch, &fans);
        links.list_open(&mut patch, &fans);
        patch
    }
}

/// Returns the fans that the boundary edges `ends` connect, ascending, and their sets by boundary curve.
pub(super) fn curves_through(ends: &[[u32; 2]]) -> (Vec<u32>, UnionFind) {
    let mut fans: Vec<u32> = ends.as_flattened().to_vec();
    fans.sort_unstable();
    fans.dedup();
    let mut curves = UnionFind::new(fans.len());
    let number = |fan: u32| fans.partition_point(|&other| other < fan) as u32;
    for &[a, b] in ends {
        curves.union(number(a), number(b));
    }
    (fans, curves)
}

struct Links<'a> {
    mesh: &'a TriMesh,
    faces: UnionFind,
    corners: UnionFind,
    counts: Topology,
    boundary: Vec<u32>,
    open: Vec<u32>,
}

impl<'a> Links<'a> {
    fn new(mesh: &'a TriMesh) -> Self {
        let n_faces = mesh.faces().len();
        Self {
            mesh,
            faces: UnionFind::new(n_faces),
            corners: UnionFind::new(3 * n_faces),
            counts: Topology { faces: n_faces, ..Topology::default() },
            boundary: Vec::new(),
            open: Vec::new(),
        }
    }

    fn join(&mut self, half_edges: &[HalfEdge]) {
        self.counts.edges += 1;
        match half_edges {
            [only] => {
                self.boundary.push(only.half_edge);
                self.counts.boundary_edges += 1;
            }
            [_, _] => {}
            _ => self.counts.non_manifold_edges += 1,
        }
        for pair in half_edges.windows(2) {
            let [x, y] = [pair[0].half_edge, pair[1].half_edge];
            self.faces.union(x / 3, y / 3);
            let agree = start(self.mesh.faces(), x) != start(self.mesh.faces(), y);
            let (at_start, at_end) = if agree { (next(y), y) } else { (y, next(y)) };
            self.corners.union(x, at_start);
            self.corners.union(next(x), at_end);
            self.counts.inconsistent_edges += usize::from(!agree && half_edges.len() == 2);
        }
    }

    fn open_fans(&mut self, patch: &mut TopologyPatch, is_shared: &impl Fn(u32) -> bool) -> FxHashMap<u32, u32> {
        let (mut fans, mut open) = (vec![0u32; self.mesh.positions().len()], FxHashMap::default());
        for corner in 0..3 * self.mesh.faces().len() as u32 {
            if self.corners.find(corner) != corner {
                continue;
            }
            let vertex = start(self.mesh.faces(), corner);
            if is_shared(vertex) {
                open.insert(corner, open.len() as u32);
                patch.open_fans.push(position_key(self.mesh.positions()[vertex as usize]));
            } else {
                fans[vertex as usize] += 1;
                patch.n_closed_fans += 1;
            }
        }
        for (_, n) in (0..).zip(fans).filter(|(vertex, _)| !is_shared(*vertex)) {
            patch.closed.vertices += 1;
            patch.closed.unreferenced_vertices += usize::from(n == 0);
            patch.closed.non_manifold_vertices += usize::from(n > 1);
        }
        open
    }

    fn trace_boundary(&mut self, patch: &mut TopologyPatch, open: &FxHashMap<u32, u32>) {
        let mut ends: Vec<[u32; 2]> = Vec::with_capacity(self.boundary.len());
        for &half_edge in &self.boundary {
            ends.push([self.corners.find(half_edge), self.corners.find(next(half_edge))]);
        }
        let (fans, mut curves) = curves_through(&ends);
        let mut first_of: FxHashMap<u32, u32> = FxHashMap::default();
        for (i, fan) in (0..).zip(&fans) {
            let Some(&fan) = open.get(fan) else { continue };
            let first = *first_of.entry(curves.find(i)).or_insert(fan);
            patch.curves.push([first, fan]);
        }
        patch.closed.boundary_loops = curves.n_sets() - first_of.len();
    }

    fn list_open(mut self, patch: &mut TopologyPatch, fans: &FxHashMap<u32, u32>) {
        let is_needed = self.counts.inconsistent_edges > 0 || !self.open.is_empty();
        let mut sides = Windings::new(if is_needed { self.mesh.faces().len() } else { 0 });
        patch.is_one_sided = is_needed && !self.turn(&mut sides);
        let (mut components, mut numbers) = (FxHashMap::default(), FxHashMap::default());
        for half_edge in std::mem::take(&mut self.open) {
            let corners = [half_edge, next(half_edge)];
            let n = components.len() as u32;
            let component = *components.entry(self.faces.find(half_edge / 3)).or_insert(n);
            let (first, is_turned) = sides.first(half_edge / 3);
            let n = numbers.len() as u32;
            patch.open_edges.push(OpenEdge {
                ends: corners.map(|at| position_key(self.mesh.positions()[start(self.mesh.faces(), at) as usize])),
                fans: corners.map(|at| fans.get(&self.corners.find(at)).copied().unwrap_or_default()),
                component,
                side: *numbers.entry(first).or_insert(n),
                is_turned,
            });
        }
        (patch.n_open_components, patch.n_open_sides) = (components.len() as u32, numbers.len() as u32);
        patch.closed.components = self.faces.n_sets() - components.len();
    }

    /// Joins faces into sides over edges that are not open; returns whether all can be wound consistently.
    fn turn(&self, sides: &mut Windings) -> bool {
        let mut waits = vec![false; 3 * self.mesh.faces().len()];
        self.open.iter().for_each(|&half_edge| waits[half_edge as usize] = true);
        let (faces, mut all_agree) = (self.mesh.faces(), true);
        for_each_edge(self.mesh.positions().len(), faces, |_, half_edges| {
            if let &[g, h] = half_edges
                && !waits[g.half_edge as usize]
            {
                all_agree &= sides.join([g.face(), h.face()], g.runs_up(faces) == h.runs_up(faces));
            }
        });
        all_agree
    }
}
