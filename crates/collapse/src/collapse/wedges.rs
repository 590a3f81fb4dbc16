//! Wedges: vertices of the caller that share one position, such as the two sides of a seam of texture coordinates.
//!
//! The mesh of a pass knows positions alone. The input's faces follow it, with a wedge per corner:
//!
//! ```text
//!        |          |             Where v is merged into u, the faces at their edge vanish. In each of these the wedge
//!     v0 | v1       |             of v becomes that of u: one pair inside a side, two along a seam. All other faces
//!   -----+----   u0 | u1          around v have one of these wedges, as v is merged along the seam only.
//!     u0 | u1     --+--
//! ```

use crate::collapse::build::is_face;
use crate::collapse::rings::{NONE, Rings, state};

const SIDES: [(usize, usize); 3] = [(0, 1), (1, 2), (2, 0)];

/// Wedges and attributes to carry along, of the size of the input.
#[derive(Clone)]
pub(crate) struct SidesInput<'a> {
    /// A wedge per corner, n_faces x 3.
    pub wedges: &'a [[u32; 3]],
    pub n_wedges: usize,
    /// True if a vertex may have several wedges.
    pub has_copies: bool,
    /// Values, n_wedges x width; a difference of 1 counts as a distance of the extent. Empty: none.
    pub values: Vec<f32>,
    pub width: usize,
    /// Number of a vertex' values that count; the rest are only carried.
    pub n_counted: usize,
}

/// A face of the input that is still there.
#[derive(Clone, Copy)]
pub(crate) struct WedgeFace {
    /// Its vertices in the mesh of the pass.
    pub vertices: [u32; 3],
    /// Its vertices in the input.
    pub wedges: [u32; 3],
    /// Its number in the input.
    pub source: u32,
}

/// Two wedges of which the first became the second.
#[derive(Clone, Copy)]
pub(crate) struct WedgePair {
    pub goes: u32,
    pub stays: u32,
    /// Their vertices in the mesh of the pass.
    pub vertices: [u32; 2],
}

/// The input's faces with their wedges.
pub(crate) struct Wedges {
    pub faces: Vec<WedgeFace>,
    /// The wedge that each became in the pass; itself if none.
    targets: Vec<u32>,
    /// True if a vertex may have several.
    has_copies: bool,
}

impl Wedges {
    /// `faces` by vertices of the rings, with their wedges; faces that use a vertex twice are left out.
    pub(crate) fn new(faces: impl Iterator<Item = [u32; 3]>, sides: &SidesInput) -> Wedges {
        let all = faces.zip(sides.wedges).zip(0..);
        let faces = all.map(|((vertices, &wedges), source)| WedgeFace { vertices, wedges, source });
        let faces = faces.filter(|face| is_face(&face.vertices)).collect();
        Wedges { faces, targets: (0..sides.n_wedges as u32).collect(), has_copies: sides.has_copies }
    }

    /// Marks vertices on lines, where wedges of neighbouring faces differ, and the ends and forks of lines.
    pub(crate) fn mark_lines(&self, rings: &mut Rings) {
        let Some(has_many) = self.find_many(rings) else { return };
        rings.lines.clear();
        rings.lines.resize(rings.vertices.len(), [NONE; 2]);
        let mut n_lines = vec![0u8; rings.vertices.len()];
        // Both wedges of each edge that may be on a line, from its lower vertex, once per face.
        let edges = self.list_edges(&has_many);
        for pair in edges.windows(2).filter(|pair| pair[0].0 == pair[1].0 && pair[0].1 != pair[1].1) {
            let [a, b] = pair[0].0;
            for (v, other) in [(a, b), (b, a)] {
                let n = &mut n_lines[v as usize];
                if let Some(end) = rings.lines[v as usize].get_mut(usize::from(*n)) {
                    *end = other;
                }
                *n = n.saturating_add(1);
            }
        }
        for (v, n) in n_lines.into_iter().enumerate() {
            let state = &mut rings.states[v];
            *state = *state & !state::FORK
                | match n {
                    // A boundary vertex may have wedges without a line where chains were joined at it.
                    0 if !has_many[v] => 0,
                    1 if !has_many[v] && *state & state::BOUNDARY == 0 => state::END,
                    2 if *state & state::BOUNDARY == 0 => state::LINE,
                    _ => state::FORK,
                };
        }
    }

    // Whether each vertex has several wedges; none if no vertex has.
    fn find_many(&self, rings: &Rings) -> Option<Vec<bool>> {
        if !self.has_copies {
            return None;
        }
        let mut wedge_of = vec![NONE; rings.vertices.len()];
        let mut has_many = vec![false; rings.vertices.len()];
        for (&v, &wedge) in self.faces.iter().flat_map(|face| face.vertices.iter().zip(&face.wedges)) {
            let first = &mut wedge_of[v as usize];
            has_many[v as usize] |= *first != NONE && *first != wedge;
            *first = wedge;
        }
        Some(has_many)
    }

    fn list_edges(&self, has_many: &[bool]) -> Vec<([u32; 2], [u32; 2])> {
        let mut edges = Vec::new();
        for face in &self.faces {
            for (i, j) in SIDES {
                let (a, b) = (face.vertices[i], face.vertices[j]);
                if has_many[a as usize] || has_many[b as usize] {
                    let (i, j) = if a < b { (i, j) } else { (j, i) };
                    edges.push(([face.vertices[i], face.vertices[j]], [face.wedges[i], face.wedges[j]]));
                }
            }
        }
        edges.sort_unstable();
        edges
    }

    /// Returns the pairs of wedges that the merges of a pass made one; those of one merge may come twice.
    pub(crate) fn find_pairs(&self, rings: &Rings, numbers: &[u32]) -> Vec<WedgePair> {
        let mut pairs = Vec::new();
        for face in &self.faces {
            let new = face.vertices.map(|v| numbers[v as usize]);
            let Some((i, j)) = SIDES.into_iter().find(|&(i, j)| new[i] == new[j]) else { continue };
            let is_first = rings.states[face.vertices[i] as usize] & state::GONE != 0;
            let (i, j) = if is_first { (i, j) } else { (j, i) };
            let vertices = [face.vertices[i], face.vertices[j]];
            pairs.push(WedgePair { goes: face.wedges[i], stays: face.wedges[j], vertices });
        }
        pairs
    }

    /// Drops the faces that vanished, and gives the others the vertices of the next pass.
    pub(crate) fn follow(&mut self, pairs: &[WedgePair], numbers: &[u32]) {
        for pair in pairs {
            let target = &mut self.targets[pair.goes as usize];
            let first = std::mem::replace(target, pair.stays);
            // Where the end of a line went along it, both wedges there become one.
            if first != pair.goes && first != pair.stays {
                self.targets[first as usize] = pair.stays;
            }
        }
        self.faces.retain_mut(|face| {
            face.vertices = face.vertices.map(|v| numbers[v as usize]);
            face.wedges = face.wedges.map(|wedge| self.targets[wedge as usize]);
            is_face(&face.vertices)
        });
        for pair in pairs {
            for wedge in [pair.goes, pair.stays] {
                self.targets[wedge as usize] = wedge;
            }
        }
    }
}
