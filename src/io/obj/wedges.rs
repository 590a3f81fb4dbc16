//! Corners of an OBJ as wedges: each distinct `v/vt/vn`, in the order of first use.

use rustc_hash::FxHashMap;

use super::NOWHERE;

/// The wedges met so far.
#[derive(Debug, Default)]
pub(super) struct Wedges {
    numbers: FxHashMap<[u32; 3], u32>,
    /// Vertex, texture coordinate and normal of each wedge, from zero; [`NOWHERE`] for those that it has not.
    pub triplets: Vec<[u32; 3]>,
}

impl Wedges {
    /// The wedges of faces (vertex indices) that have neither texture coordinates nor normals; they then name the wedges.
    pub fn of_plain(faces: &mut [[u32; 3]]) -> Self {
        let mut wedges = Self::default();
        for vertex in faces.iter_mut().flatten() {
            *vertex = wedges.number([*vertex, NOWHERE, NOWHERE]);
        }
        wedges
    }

    /// The number of a wedge.
    pub fn number(&mut self, triplet: [u32; 3]) -> u32 {
        *self.numbers.entry(triplet).or_insert_with(|| {
            self.triplets.push(triplet);
            self.triplets.len() as u32 - 1
        })
    }

    /// Where a wedge lies.
    pub fn position(&self, wedge: u32, positions: &[[f64; 3]]) -> Option<[f64; 3]> {
        positions.get(self.vertex(wedge) as usize).copied()
    }

    /// The vertex of a wedge.
    pub fn vertex(&self, wedge: u32) -> u32 {
        self.triplets.get(wedge as usize).map_or(NOWHERE, |triplet| triplet[0])
    }

    /// The values at the wedges, n_wedges x `width`, out of a table of values; `part`: 0 for a table of vertices, 1 of
    /// texture coordinates, 2 of normals. Zeros where a wedge has none; `None` where none has one.
    pub fn values(&self, part: usize, table: &[f32], width: usize) -> Option<Vec<f32>> {
        let row = |index: u32| (index as usize).checked_mul(width).and_then(|at| table.get(at..at.checked_add(width)?));
        if !self.triplets.iter().any(|triplet| row(triplet[part]).is_some()) {
            return None;
        }
        let mut values = vec![0.0; self.triplets.len() * width];
        for (value, triplet) in values.chunks_exact_mut(width).zip(&self.triplets) {
            if let Some(row) = row(triplet[part]) {
                value.copy_from_slice(row);
            }
        }
        Some(values)
    }
}
