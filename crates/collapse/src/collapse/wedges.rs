//! Wedges: vertices of the caller that share one position, such as the two sides of a seam of texture coordinates.
//!
//! The mesh of a pass knows positions alone. Beside it go the input's faces with a wedge per corner:
//!
//! ```text
//!        |          |             Where v is merged into u, the faces at their edge vanish. In each of these the wedge
//!     v0 | v1       |             of v becomes that of u: one pair inside a side, two along a seam. All other faces
//!   -----+----   u0 | u1          around v have one of these wedges, as v goes along the seam only.
//!     u0 | u1     --+--
//! ```

use crate::collapse::build::is_face;
use crate::collapse::rings::{NONE, Rings, state};

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
    /// What each wedge became in the pass; itself if nothing.
    targets: Vec<u32>,
}

impl Wedges {
    /// `faces` by vertices of the rings, `wedges` by those of the input; faces that use a vertex twice are left out.
    pub(crate) fn new(faces: impl Iterator<Item = [u32; 3]>, wedges: &[[u32; 3]], n_wedges: usize) -> Wedges {
        let all = faces.zip(wedges).zip(0..);
        let faces = all.map(|((vertices, &wedges), source)| WedgeFace { vertices, wedges, source });
        Wedges { faces: faces.filter(|face| is_face(&face.vertices)).collect(), targets: (0..n_wedges as u32).collect() }
    }

    /// Marks vertices on lines, where wedges of neighbouring faces differ; where lines end, branch or meet a boundary, a
    /// vertex is locked.
    pub(crate) fn mark_lines(&self, rings: &mut Rings) {
        let mut wedge_of = vec![NONE; rings.vertices.len()];
        let mut has_many = vec![false; rings.vertices.len()];
        for (&v, &wedge) in self.faces.iter().flat_map(|face| face.vertices.iter().zip(&face.wedges)) {
            let first = &mut wedge_of[v as usize];
            has_many[v as usize] |= *first != NONE && *first != wedge;
            *first = wedge;
        }
        if !has_many.contains(&true) {
            return;
        }
        // Both wedges of each directed edge that may be on a line, from its lower vertex.
        let mut edges = Vec::new();
        for face in &self.faces {
            for (i, j) in [(0, 1), (1, 2), (2, 0)] {
                let (a, b) = (face.vertices[i], face.vertices[j]);
                if has_many[a as usize] || has_many[b as usize] {
                    let (i, j) = if a < b { (i, j) } else { (j, i) };
                    edges.push(([face.vertices[i], face.vertices[j]], [face.wedges[i], face.wedges[j]]));
                }
            }
        }
        edges.sort_unstable();
        rings.lines = vec![[NONE; 2]; rings.vertices.len()];
        let mut n_lines = vec![0u8; rings.vertices.len()];
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
            if n == 2 && *state & (state::BOUNDARY | state::LOCKED) == 0 {
                *state |= state::LINE;
            } else {
                rings.lines[v] = [NONE; 2];
                // A boundary vertex may have two wedges of chains that were joined at it.
                *state |= if n > 0 || has_many[v] { state::LOCKED } else { 0 };
            }
        }
    }

    /// Returns the pairs of wedges that the merges of a pass made one; those of one merge may come twice.
    pub(crate) fn find_pairs(&self, rings: &Rings, numbers: &[u32]) -> Vec<WedgePair> {
        let mut pairs = Vec::new();
        for face in &self.faces {
            let [a, b, c] = face.vertices.map(|v| numbers[v as usize]);
            let (i, j) = if a == b {
                (0, 1)
            } else if b == c {
                (1, 2)
            } else if c == a {
                (2, 0)
            } else {
                continue;
            };
            let is_first = rings.states[face.vertices[i] as usize] & state::GONE != 0;
            let (i, j) = if is_first { (i, j) } else { (j, i) };
            pairs.push(WedgePair {
                goes: face.wedges[i],
                stays: face.wedges[j],
                vertices: [face.vertices[i], face.vertices[j]],
            });
        }
        pairs
    }

    /// Drops the faces that vanished, and gives the others the vertices of the next pass.
    pub(crate) fn follow(&mut self, pairs: &[WedgePair], numbers: &[u32]) {
        for pair in pairs {
            self.targets[pair.goes as usize] = pair.stays;
        }
        self.faces.retain_mut(|face| {
            face.vertices = face.vertices.map(|v| numbers[v as usize]);
            face.wedges = face.wedges.map(|wedge| self.targets[wedge as usize]);
            is_face(&face.vertices)
        });
        for pair in pairs {
            self.targets[pair.goes as usize] = pair.goes;
        }
    }
}

/// Returns the neighbours along lines after a pass, by the numbers of the next.
pub(crate) fn follow_lines(rings: &Rings, numbers: &[u32]) -> Vec<[u32; 2]> {
    let mut lines = Vec::new();
    if rings.lines.is_empty() {
        return lines;
    }
    for (u, &ends) in rings.lines.iter().enumerate() {
        if rings.states[u] & state::GONE != 0 {
            continue;
        }
        lines.push(ends.map(|end| {
            if end == NONE {
                return NONE;
            }
            // What was merged into u has its own other end there.
            let is_merged = rings.states[end as usize] & state::GONE != 0
                && rings.vertices[end as usize].survivor as usize == u;
            let [one, other] = rings.lines[end as usize];
            let end = if !is_merged {
                end
            } else if one as usize == u {
                other
            } else {
                one
            };
            numbers[end as usize]
        }));
    }
    lines
}
