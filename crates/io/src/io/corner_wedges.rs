//! Wedges of an OBJ: each distinct `v/vt/vn`, numbered by first use.

use super::NOWHERE;
use crate::mesh::DistinctKeys;

#[derive(Debug, Default)]
pub(super) struct ObjWedges {
    // Vertex, texture coordinate and normal of each wedge, from zero, or `NOWHERE`.
    triplets: DistinctKeys<[u32; 3]>,
}

impl ObjWedges {
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

    pub fn position(&self, wedge: u32, positions: &[[f64; 3]]) -> Option<[f64; 3]> {
        positions.get(self.vertex(wedge) as usize).copied()
    }

    pub fn vertex(&self, wedge: u32) -> u32 {
        self.triplets.keys.get(wedge as usize).map_or(NOWHERE, |triplet| triplet[0])
    }

    /// Gathers wedge values, n_wedges x `width`, from the table of vertices (`part` 0), coordinates (1) or normals (2).
    ///
    /// Missing values are zeros; `None` if all are missing.
    pub fn values(&self, part: usize, table: &[f32], width: usize) -> Option<Vec<f32>> {
        // Indices come from the file, so the arithmetic is checked.
        let row = |index: u32| (index as usize).checked_mul(width).and_then(|at| table.get(at..at.checked_add(width)?));
        if !self.triplets.keys.iter().any(|triplet| row(triplet[part]).is_some()) {
            return None;
        }
        let mut values = vec![0.0; self.triplets.keys.len() * width];
        for (value, triplet) in values.chunks_exact_mut(width).zip(&self.triplets.keys) {
            if let Some(row) = row(triplet[part]) {
                value.copy_from_slice(row);
            }
        }
        Some(values)
    }
}
