//! Compressed sparse rows.

use std::ops::Range;

use super::Rows;
use crate::parallel;

/// The pattern of a sparse matrix in compressed rows, each with ascending, distinct columns.
///
/// Row `i` holds `columns[offsets[i]..offsets[i + 1]]`; values are kept separately, one per entry.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::Csr;
/// let path = Csr::from_edges(3, [[0, 1], [2, 1]]);
/// assert_eq!(path.row(1), [0, 2]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Csr {
    offsets: Vec<u32>,
    columns: Vec<u32>,
    n_cols: usize,
}

const BLOCK: usize = 1024;

/// Reasons why offsets and columns make no [`Csr`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InvalidCsr {
    /// Offsets do not rise from 0 to the number of entries.
    BadOffsets,
    /// Columns of the row are out of range or not ascending.
    BadRow {
        /// The row's index.
        row: usize,
    },
}

impl std::fmt::Display for InvalidCsr {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::BadOffsets => write!(f, "offsets must begin at 0, never fall, and end at the number of entries"),
            Self::BadRow { row } => write!(f, "row {row} must name existing columns, ascending and each once"),
        }
    }
}

impl std::error::Error for InvalidCsr {}

impl Csr {
    /// Builds rows from offsets (n_rows + 1) and columns (n_entries).
    ///
    /// # Errors
    /// [`InvalidCsr`] names the first bad row.
    pub fn new(offsets: Vec<u32>, columns: Vec<u32>, n_cols: usize) -> Result<Self, InvalidCsr> {
        let ends_match = offsets.first() == Some(&0) && offsets.last().map(|&end| end as usize) == Some(columns.len());
        if !ends_match || !offsets.is_sorted() {
            return Err(InvalidCsr::BadOffsets);
        }
        let csr = Self { offsets, columns, n_cols };
        let is_bad = |row: &[u32]| row.last().is_some_and(|&c| c as usize >= n_cols) || !row.is_sorted_by(|a, b| a < b);
        match (0..csr.n_rows()).find(|&row| is_bad(csr.row(row))) {
            Some(row) => Err(InvalidCsr::BadRow { row }),
            None => Ok(csr),
        }
    }

    /// Builds the symmetric graph over `n` nodes with these edges; drops loops and repeats.
    pub fn from_edges(n: usize, edges: impl IntoIterator<Item = [u32; 2], IntoIter: Clone>) -> Self {
        let edges = edges.into_iter().filter(|[a, b]| a != b);
        let others = Rows::new(n, edges.flat_map(|[a, b]| [(a, b), (b, a)]));
        let Rows { starts, items } = &others;
        let (mut columns, mut ends) = (vec![0u32; items.len()], starts[..n].to_vec());
        // Nodes in order are appended to the rows of their neighbours, so that these ascend: faster than sorting rows.
        for node in 0..n {
            for &row in others.row(node) {
                let (start, end) = (starts[row as usize], &mut ends[row as usize]);
                if *end == start || columns[*end as usize - 1] != node as u32 {
                    columns[*end as usize] = node as u32;
                    *end += 1;
                }
            }
        }
        let mut offsets = vec![0u32; n + 1];
        for row in 0..n {
            let (begin, end, to) = (starts[row] as usize, ends[row] as usize, offsets[row] as usize);
            columns.copy_within(begin..end, to);
            offsets[row + 1] = (to + end - begin) as u32;
        }
        columns.truncate(offsets[n] as usize);
        Self { offsets, columns, n_cols: n }
    }

    /// Builds rows from (row, column) entries; drops repeats.
    pub fn from_entries(n_rows: usize, n_cols: usize, entries: impl Iterator<Item = [u32; 2]> + Clone) -> Self {
        let in_range = |[row, col]: [u32; 2]| {
            assert!((col as usize) < n_cols, "column {col} of {n_cols}");
            (row, col)
        };
        let rows = Rows::new(n_rows, entries.map(in_range));
        Self::from_rows(n_rows, n_cols, |row, columns| columns.extend_from_slice(rows.row(row)))
    }

    /// Builds rows in parallel; `add_columns(row, columns)` appends the columns of a row in any order.
    ///
    /// # Panics
    /// If a column is out of range, or there are too many entries for `u32`.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::linalg::Csr;
    /// let band = Csr::from_rows(3, 3, |row, columns| columns.extend([(row as u32 + 1) % 3, row as u32]));
    /// assert_eq!((band.row(0), band.row(2)), ([0, 1].as_slice(), [0, 2].as_slice()));
    /// ```
    pub fn from_rows(n_rows: usize, n_cols: usize, add_columns: impl Fn(usize, &mut Vec<u32>) + Sync) -> Self {
        let block = |begin: usize| {
            let (mut ends, mut columns, mut row) = (Vec::with_capacity(BLOCK), Vec::new(), Vec::new());
            for at in begin..(begin + BLOCK).min(n_rows) {
                row.clear();
                add_columns(at, &mut row);
                row.sort_unstable();
                row.dedup();
                assert!(row.last().is_none_or(|&col| (col as usize) < n_cols), "columns of {n_cols}");
                columns.extend_from_slice(&row);
                ends.push(columns.len());
            }
            (ends, columns)
        };
        let blocks = parallel::each((0..n_rows).step_by(BLOCK), block);
        let size = blocks.iter().map(|(_, columns)| columns.len()).sum();
        assert!(size <= u32::MAX as usize, "at most 2^32 - 1 entries");
        let (mut offsets, mut columns) = (Vec::with_capacity(n_rows + 1), Vec::with_capacity(size));
        offsets.push(0);
        for (ends, of_block) in blocks {
            offsets.extend(ends.iter().map(|end| (columns.len() + end) as u32));
            columns.extend_from_slice(&of_block);
        }
        Self { offsets, columns, n_cols }
    }

    /// Builds the symmetric graph over `n` nodes with the `neighbours` of each, in any order.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::linalg::Csr;
    /// let rows: [&[u32]; 3] = [&[2, 1], &[0], &[0]];
    /// assert_eq!(Csr::from_neighbours(3, |i| rows[i]), Csr::from_edges(3, [[0, 1], [0, 2]]));
    /// ```
    pub fn from_neighbours<'a>(n: usize, neighbours: impl Fn(usize) -> &'a [u32]) -> Self {
        let mirrored = Rows::new(n, (0..n).flat_map(|i| neighbours(i).iter().map(move |&j| (j, i as u32))));
        assert!((0..n).all(|i| mirrored.row(i).len() == neighbours(i).len()), "the graph must be symmetric");
        let Rows { starts: offsets, items: columns } = mirrored;
        Self { offsets, columns, n_cols: n }
    }

    /// Builds rows of `k` columns each, in any order but distinct within a row.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::linalg::Csr;
    /// let nearest = Csr::from_equal_rows(2, 3, 2, vec![2, 0, 1, 2]);
    /// assert_eq!((nearest.row(0), nearest.row(1)), ([0, 2].as_slice(), [1, 2].as_slice()));
    /// ```
    pub fn from_equal_rows(n_rows: usize, n_cols: usize, k: usize, mut columns: Vec<u32>) -> Self {
        assert_eq!(columns.len(), n_rows * k, "k columns for each row");
        assert!(columns.len() <= u32::MAX as usize, "at most 2^32 - 1 entries");
        parallel::rows_mut(&mut columns, k, BLOCK, |_, row| {
            row.sort_unstable();
            assert!(row.last().is_none_or(|&col| (col as usize) < n_cols), "columns of {n_cols}");
            debug_assert!(row.is_sorted_by(|a, b| a < b), "each column once in a row");
        });
        Self { offsets: (0..=n_rows).map(|row| (row * k) as u32).collect(), columns, n_cols }
    }

    /// Returns the square graph with a loop at every node.
    ///
    /// ```
    /// # use neural_mesh_mesh as neural_mesh;
    /// use neural_mesh::linalg::Csr;
    /// let edge = Csr::from_edges(2, [[0, 1]]).with_loops();
    /// assert_eq!((edge.row(0), edge.row(1)), ([0, 1].as_slice(), [0, 1].as_slice()));
    /// ```
    pub fn with_loops(&self) -> Self {
        Self::from_rows(self.n_rows(), self.n_cols, |row, columns| {
            columns.extend_from_slice(self.row(row));
            columns.push(row as u32);
        })
    }

    /// Returns the number of rows.
    pub fn n_rows(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Returns the number of columns.
    pub fn n_cols(&self) -> usize {
        self.n_cols
    }

    /// Returns the number of entries.
    pub fn n_entries(&self) -> usize {
        self.columns.len()
    }

    /// Returns the columns of a row, ascending.
    #[inline]
    pub fn row(&self, row: usize) -> &[u32] {
        &self.columns[self.range(row)]
    }

    /// Returns the range of a row's entries.
    #[inline]
    pub fn range(&self, row: usize) -> Range<usize> {
        self.offsets[row] as usize..self.offsets[row + 1] as usize
    }

    /// Returns the range of several rows' entries.
    #[inline]
    pub fn rows_range(&self, rows: Range<usize>) -> Range<usize> {
        self.offsets[rows.start] as usize..self.offsets[rows.end] as usize
    }

    /// Splits `values`, one per entry, into those of `block` rows each.
    pub(super) fn split_rows<'a, T>(&self, block: usize, mut values: &'a mut [T]) -> Vec<(Range<usize>, &'a mut [T])> {
        let starts = (0..self.n_rows()).step_by(block);
        let blocks = starts.map(|begin| {
            let rows = begin..(begin + block).min(self.n_rows());
            let head;
            (head, values) = std::mem::take(&mut values).split_at_mut(self.rows_range(rows.clone()).len());
            (rows, head)
        });
        blocks.collect()
    }

    /// Returns the index of entry (`row`, `col`), `None` if absent.
    pub fn position(&self, row: usize, col: u32) -> Option<usize> {
        Some(self.range(row).start + self.row(row).binary_search(&col).ok()?)
    }

    /// Returns all entries as (row, column), row by row.
    pub fn entries(&self) -> impl Iterator<Item = [u32; 2]> + Clone {
        (0..self.n_rows()).flat_map(|row| self.row(row).iter().map(move |&col| [row as u32, col]))
    }

    /// Returns the transposed rows, and each entry's index in this pattern.
    pub fn transpose(&self) -> (Self, Vec<u32>) {
        // Rows in order keep the transposed rows ascending.
        let entries = |row| self.range(row).map(move |at| (self.columns[at], (row as u32, at as u32)));
        let Rows { starts: offsets, items } = Rows::new(self.n_cols, (0..self.n_rows()).flat_map(entries));
        let (columns, origin) = items.into_iter().unzip();
        (Self { offsets, columns, n_cols: self.n_rows() }, origin)
    }

    /// Returns whether every entry has its mirror image.
    pub fn is_symmetric(&self) -> bool {
        self.n_rows() == self.n_cols && self.transpose().0 == *self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_make_a_symmetric_graph_without_loops_and_repeats() {
        let graph = Csr::from_edges(4, [[0, 1], [1, 0], [2, 2], [3, 1]]);
        assert_eq!((0..4).map(|i| graph.row(i).to_vec()).collect::<Vec<_>>(), [vec![1], vec![0, 3], vec![], vec![1]]);
        assert!(graph.is_symmetric());
        assert_eq!(graph.position(1, 3), Some(2));
        assert_eq!(graph.position(0, 3), None);
    }

    #[test]
    fn edges_in_any_order_give_the_entries_of_both_directions() {
        let mut state = 1u64;
        let mut draw = |n: u64| {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            ((state >> 33) % n) as u32
        };
        for n in [1, 2, 7, 40] {
            let edges: Vec<[u32; 2]> = (0..5 * n).map(|_| [draw(n), draw(n)]).collect();
            let both = edges.iter().filter(|[a, b]| a != b).flat_map(|&[a, b]| [[a, b], [b, a]]);
            assert_eq!(Csr::from_edges(n as usize, edges.clone()), Csr::from_entries(n as usize, n as usize, both));
        }
        assert_eq!(Csr::from_edges(0, []).n_rows(), 0);
    }

    #[test]
    fn transposing_remembers_where_entries_stood() {
        let csr = Csr::from_entries(2, 3, [[0, 2], [1, 0], [1, 2]].into_iter());
        let (transposed, origin) = csr.transpose();
        assert_eq!(transposed.entries().collect::<Vec<_>>(), [[0, 1], [2, 0], [2, 1]]);
        assert_eq!(origin, [1, 0, 2]);
        assert!(!csr.is_symmetric());
    }

    #[test]
    fn wrong_rows_are_refused() {
        assert_eq!(Csr::new(vec![], vec![], 0), Err(InvalidCsr::BadOffsets));
        assert_eq!(Csr::new(vec![0, 2, 1], vec![0], 1), Err(InvalidCsr::BadOffsets));
        assert_eq!(Csr::new(vec![0, 1, 2], vec![0, 1], 1), Err(InvalidCsr::BadRow { row: 1 }));
        assert_eq!(Csr::new(vec![0, 2], vec![1, 1], 2), Err(InvalidCsr::BadRow { row: 0 }));
        assert!(Csr::new(vec![0, 2], vec![0, 1], 2).is_ok());
    }
}
