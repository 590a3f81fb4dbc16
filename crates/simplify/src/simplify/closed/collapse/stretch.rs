//! Stretches of a collapse: consecutive vertices with a range of faces, most of which touch only these vertices.

use std::ops::Range;

use super::state::{Collapse, REMOVED};

/// Least number of vertices of a stretch.
const LEAST: usize = 1 << 12;
/// Largest number of vertices of a stretch.
const MOST: usize = 1 << 16;
/// Number of stretches per thread, within these bounds.
const PER_THREAD: usize = 4;

/// Faces of a stretch, and a row for each of its vertices.
pub(super) struct Stretch<'r, T> {
    pub faces: Range<usize>,
    first_vertex: u32,
    rows: &'r mut [T],
}

impl<T> Stretch<'_, T> {
    /// Returns the row of a vertex; `None` if the vertex is outside of the stretch.
    #[inline(always)]
    pub fn row_mut(&mut self, v: u32) -> Option<&mut T> {
        self.rows.get_mut(v.wrapping_sub(self.first_vertex) as usize)
    }
}

impl Collapse<'_> {
    /// Splits the faces and the rows of vertices into stretches, as many as keep all threads busy.
    ///
    /// Vertices and faces are sorted along a space-filling curve, so that most edges lie within one stretch.
    pub(super) fn split_into_stretches<'r, T>(&self, rows: &'r mut [T]) -> Vec<Stretch<'r, T>> {
        let n_threads = rayon::current_num_threads();
        let n = if n_threads == 1 { MOST } else { rows.len().div_ceil(PER_THREAD * n_threads).clamp(LEAST, MOST) };
        let mut first_face = 0;
        let stretch = |(i, rows): (usize, &'r mut [T])| {
            let faces = first_face..self.first_face_at(i * n + rows.len()).max(first_face);
            first_face = faces.end;
            Stretch { faces, first_vertex: (i * n) as u32, rows }
        };
        rows.chunks_mut(n).enumerate().map(stretch).collect()
    }

    /// Returns about the first face whose vertices are all `vertex` or later ones.
    fn first_face_at(&self, vertex: usize) -> usize {
        // Faces are nearly in the order of their smallest vertices, so it is the last face at the vertex.
        let present = (vertex..self.n_inner).find(|&v| self.nodes[v].corner != REMOVED);
        let faces = present.into_iter().flat_map(|v| self.faces_around(v as u32)).map(|step| step.at as usize / 4);
        faces.max().unwrap_or(self.corners.n_faces())
    }
}
