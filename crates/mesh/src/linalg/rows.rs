//! Items sorted into rows by counting.

/// Items in rows, one row after the other.
///
/// ```
/// # use neural_mesh_mesh as neural_mesh;
/// use neural_mesh::linalg::Rows;
/// let rows = Rows::new(3, [(2, 'a'), (0, 'b'), (2, 'c')].into_iter());
/// assert_eq!((rows.row(0), rows.row(1), rows.row(2)), (&['b'][..], &[][..], &['a', 'c'][..]));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rows<T> {
    /// Start of each row in `items`, and the end of the last, n_rows + 1.
    pub(crate) starts: Vec<u32>,
    pub(crate) items: Vec<T>,
}

impl<T: Copy + Default> Rows<T> {
    /// Sorts (row, item) entries by row; items of a row keep their order.
    ///
    /// # Panics
    /// If there are 2^32 entries or more.
    pub fn new(n_rows: usize, entries: impl Iterator<Item = (u32, T)> + Clone) -> Self {
        // Counts are two places after their row, so that the next free place of a row, one after it, ends as the start of
        // the next row.
        let mut starts = vec![0u32; n_rows + 2];
        entries.clone().for_each(|(row, _)| starts[row as usize + 2] += 1);
        for row in 0..n_rows {
            starts[row + 2] = starts[row + 1].checked_add(starts[row + 2]).expect("at most 2^32 - 1 entries");
        }
        let mut items = vec![T::default(); starts[n_rows + 1] as usize];
        entries.for_each(|(row, item)| {
            let slot = &mut starts[row as usize + 1];
            items[*slot as usize] = item;
            *slot += 1;
        });
        starts.pop();
        Self { starts, items }
    }
}

impl<T> Rows<T> {
    /// Returns the number of rows.
    pub fn n_rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns the items of a row.
    #[inline]
    pub fn row(&self, row: usize) -> &[T] {
        &self.items[self.starts[row] as usize..self.starts[row + 1] as usize]
    }

    /// Returns the items of all rows.
    pub fn into_items(self) -> Vec<T> {
        self.items
    }

    /// Returns the items of a row.
    #[inline]
    pub fn row_mut(&mut self, row: usize) -> &mut [T] {
        &mut self.items[self.starts[row] as usize..self.starts[row + 1] as usize]
    }
}
