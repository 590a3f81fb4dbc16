//! The record of a collapse: pass by pass, which vertices became one.

use crate::collapse::merges::PassMerge;

/// The numbering from the input's vertices to those of the result, in passes.
///
/// A pass is an array: at each vertex of the mesh before it, the number of the vertex that it is in the mesh after it.
/// Vertices that were merged have the same number. The mesh after any pass is an intermediate result, so a prefix of the
/// record leads to a larger mesh.
#[derive(Clone, Debug, Default)]
pub struct CollapseRecord {
    /// Positions of the first mesh's vertices along the curve, in the order of the input.
    pub(crate) ranks: Vec<u32>,
    pub(crate) passes: Vec<Vec<u32>>,
    pub(crate) n_input: usize,
    pub(crate) merges: Vec<Vec<PassMerge>>,
}

impl CollapseRecord {
    /// Returns the number of passes.
    pub fn n_passes(&self) -> usize {
        self.passes.len()
    }

    /// Returns the merges of a pass in their order, if they were recorded; a pass places all by the mesh before it.
    pub fn merges(&self, pass: usize) -> &[PassMerge] {
        self.merges.get(pass).map_or(&[], |merges| merges)
    }

    /// Returns the number of vertices before a pass, or after the last one.
    pub fn n_vertices(&self, pass: usize) -> usize {
        match self.passes.get(pass) {
            Some(numbers) => numbers.len(),
            None => self.passes.last().map_or(self.ranks.len(), |last| count_numbers(last)),
        }
    }

    /// Returns the vertex of the result that each input vertex became, after the first `n_passes` passes.
    ///
    /// A vertex that was cut into copies has the number of its first copy. A vertex without a face has any number.
    ///
    /// # Shapes
    /// One number per input vertex.
    pub fn vertices_after(&self, n_passes: usize) -> Vec<u32> {
        let mut numbers = self.compose(n_passes);
        numbers.truncate(self.n_input);
        numbers
    }

    // For all vertices, copies included.
    pub(crate) fn compose(&self, n_passes: usize) -> Vec<u32> {
        compose_passes(&self.ranks, &self.passes[..n_passes.min(self.passes.len())])
    }
}

/// Returns the number after some passes of each vertex, copies included, from its place along the curve.
pub(crate) fn compose_passes(ranks: &[u32], passes: &[Vec<u32>]) -> Vec<u32> {
    let Some((last, before)) = passes.split_last() else { return ranks.to_vec() };
    // From the last pass back: arrays grow, and each is read in order.
    let mut composed = last.clone();
    for numbers in before.iter().rev() {
        composed = numbers.iter().map(|&v| composed.get(v as usize).copied().unwrap_or(0)).collect();
    }
    ranks.iter().map(|&rank| composed[rank as usize]).collect()
}

fn count_numbers(numbers: &[u32]) -> usize {
    numbers.iter().max().map_or(0, |&last| last as usize + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_passes_are_composed() {
        let record = CollapseRecord {
            ranks: vec![2, 0, 1, 3],
            passes: vec![vec![0, 0, 1, 2], vec![0, 1, 1]],
            n_input: 4,
            merges: Vec::new(),
        };
        assert_eq!(record.vertices_after(0), [2, 0, 1, 3]);
        assert_eq!(record.vertices_after(1), [1, 0, 0, 2]);
        assert_eq!(record.vertices_after(2), [1, 0, 0, 1]);
        assert_eq!((record.n_vertices(0), record.n_vertices(1), record.n_vertices(2)), (4, 3, 2));
    }
}
