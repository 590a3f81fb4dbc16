//! Stretches of a collapse: consecutive vertices, and the faces beside them in memory.
//!
//! Vertices and faces are sorted along a space-filling curve, so that most edges lie within one stretch. Threads merge
//! vertices of different stretches at the same time.

use super::corner_table::{CornerStep, CornerTable, NONE};
use super::pair::CollapseVertex;
use super::state::{Collapse, REMOVED};

/// Number of stretches of a large mesh.
const STRETCHES: usize = 16;
/// Least and largest number of vertices of a stretch.
const LEAST: usize = 1 << 13;
const MOST: usize = 1 << 16;

pub(super) struct Stretch<'m> {
    nodes: &'m mut [CollapseVertex],
    first: u32,
    pub corners: CornerTable<&'m mut [u32]>,
    /// Number of the first ghost vertex.
    n_inner: u32,
}

/// Reason to merge later: vertices or faces of other stretches are needed.
pub(super) struct Beyond;

pub(super) type Within<T> = Result<T, Beyond>;

/// Vertices and faces before the end of a stretch.
#[derive(Clone, Copy)]
pub(super) struct StretchEnd {
    pub vertices: usize,
    pub faces: usize,
}

impl Stretch<'_> {
    #[inline(always)]
    pub fn holds(&self, v: u32) -> bool {
        (v.wrapping_sub(self.first) as usize) < self.nodes.len()
    }

    #[inline(always)]
    pub fn get_node_mut(&mut self, v: u32) -> Within<&mut CollapseVertex> {
        self.nodes.get_mut(v.wrapping_sub(self.first) as usize).ok_or(Beyond)
    }

    #[inline(always)]
    pub fn node(&self, v: u32) -> &CollapseVertex {
        &self.nodes[v.wrapping_sub(self.first) as usize]
    }

    #[inline(always)]
    pub fn node_mut(&mut self, v: u32) -> &mut CollapseVertex {
        &mut self.nodes[v.wrapping_sub(self.first) as usize]
    }

    #[inline(always)]
    pub fn is_ghost(&self, v: u32) -> bool {
        v >= self.n_inner
    }

    #[inline(always)]
    pub fn ids(&self, [u, v]: [u32; 2]) -> [u32; 2] {
        [self.node(u).id, self.node(v).id]
    }

    /// Returns the ends of the edge opposite `corner`; [`NONE`] if its face was removed.
    #[inline(always)]
    pub fn edge(&self, corner: u32) -> Within<[u32; 2]> {
        let is_within = |v: u32| v == NONE || self.holds(v);
        let ends = if self.corners.holds(corner) { self.corners.edge(corner) } else { return Err(Beyond) };
        if ends.into_iter().all(is_within) { Ok(ends) } else { Err(Beyond) }
    }

    /// Walks around a vertex, from the step `first` in a face of the stretch; neighbours may be beyond it.
    #[inline(always)]
    pub fn walk(&self, vertex: u32, first: CornerStep, mut visit: impl FnMut(CornerStep)) -> Within<()> {
        let mut step = first;
        loop {
            visit(step);
            step = self.corners.step_across(self.corners.corner_across(step.from), vertex).ok_or(Beyond)?;
            if step.at == first.at {
                return Ok(());
            }
        }
    }
}

/// Returns where each stretch ends.
pub(super) fn stretch_ends(collapse: &Collapse) -> Vec<StretchEnd> {
    let (n_inner, n_faces) = (collapse.n_inner, collapse.corners.n_faces());
    let n = n_inner.div_ceil(STRETCHES).clamp(LEAST, MOST);
    let mut ends = Vec::with_capacity(n_inner / n + 1);
    let mut faces = 0;
    for vertices in (n..n_inner).step_by(n) {
        // Faces are nearly in the order of their smallest vertices, so the last face at a vertex shows where its faces
        // begin.
        let next = (vertices..n_inner).find(|&v| collapse.nodes[v].corner != REMOVED);
        let at_next = next.into_iter().flat_map(|v| collapse.faces_around(v as u32)).map(|step| step.at as usize / 4);
        faces = at_next.max().unwrap_or(n_faces).max(faces);
        ends.push(StretchEnd { vertices, faces });
    }
    ends.push(StretchEnd { vertices: n_inner, faces: n_faces });
    ends
}

/// Splits rows of vertices, such as their cheapest edges, by stretches.
pub(super) fn split_by_vertices<'m, T>(ends: &[StretchEnd], mut rows: &'m mut [T]) -> Vec<(u32, &'m mut [T])> {
    let mut first = 0;
    let part = |end: &StretchEnd| {
        let (part, rest) = std::mem::take(&mut rows).split_at_mut(end.vertices - first);
        let part = (first as u32, part);
        (rows, first) = (rest, end.vertices);
        part
    };
    ends.iter().map(part).collect()
}

/// Returns the whole mesh, ghost vertices included, as one stretch.
pub(super) fn whole<'m>(nodes: &'m mut [CollapseVertex], corners: &'m mut CornerTable, n_inner: usize) -> Stretch<'m> {
    let n_faces = corners.n_faces();
    let corners = corners.split(std::iter::once(n_faces)).remove(0);
    Stretch { nodes, first: 0, corners, n_inner: n_inner as u32 }
}

/// Splits the mesh at these ends; ghost vertices belong to no stretch.
pub(super) fn split<'m>(
    ends: &[StretchEnd],
    nodes: &'m mut [CollapseVertex],
    corners: &'m mut CornerTable,
) -> Vec<Stretch<'m>> {
    let n_inner = ends.last().map_or(0, |end| end.vertices);
    let corners = corners.split(ends.iter().map(|end| end.faces));
    let nodes = split_by_vertices(ends, &mut nodes[..n_inner]);
    let stretch = |((first, nodes), corners)| Stretch { nodes, first, corners, n_inner: n_inner as u32 };
    nodes.into_iter().zip(corners).map(stretch).collect()
}
