//! Wedges of files whose corners have more than a vertex: each distinct corner, numbered by first use.

use crate::mesh::{DistinctKeys, Fans};

/// Index of no vertex; cleanup drops faces with such an index.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Vertex of each wedge, or [`NOWHERE`], and two more numbers of the corner.
#[derive(Debug, Default)]
pub(super) struct CornerWedges {
    triplets: DistinctKeys<[u32; 3]>,
}

impl CornerWedges {
    pub fn from_vertices(faces: &mut [[u32; 3]]) -> Self {
        let mut wedges = Self::default();
        for vertex in faces.iter_mut().flatten() {
            *vertex = wedges.number([*vertex, NOWHERE, NOWHERE]);
        }
        wedges
    }

    pub fn number(&mut self, triplet: [u32; 3]) -> u32 {
        self.triplets.number(triplet)
    }

    pub fn keys(&self) -> &[[u32; 3]] {
        &self.triplets.keys
    }

    /// Triangulates polygons of wedges, turns their faces into faces of vertices and returns the wedges.
    pub fn finish_faces(&self, fans: Fans, positions: &[[f64; 3]], faces: &mut [[u32; 3]]) -> Vec<[u32; 3]> {
        let vertex = |wedge: u32| self.keys().get(wedge as usize).map_or(NOWHERE, |triplet| triplet[0]);
        // Wedges and vertices change together.
        fans.triangulate_with(|wedge| positions.get(vertex(wedge) as usize).copied(), faces);
        let wedges = faces.to_vec();
        faces.iter_mut().flatten().for_each(|corner| *corner = vertex(*corner));
        wedges
    }

    /// Gathers wedge values, n_wedges x `width`, from the table that number `part` of the corners refers to.
    ///
    /// Missing values are zeros; `None` if all are missing.
    pub fn values(&self, part: usize, table: &[f32], width: usize) -> Option<Vec<f32>> {
        // Indices come from the file, so the arithmetic is checked.
        let row = |index: u32| (index as usize).checked_mul(width).and_then(|at| table.get(at..at.checked_add(width)?));
        if !self.keys().iter().any(|triplet| row(triplet[part]).is_some()) {
            return None;
        }
        let mut values = vec![0.0; self.keys().len() * width];
        for (value, triplet) in values.chunks_exact_mut(width).zip(self.keys()) {
            if let Some(row) = row(triplet[part]) {
                value.copy_from_slice(row);
            }
        }
        Some(values)
    }
}
