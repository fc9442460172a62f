//! Compressed sparse rows (CSR).

use std::ops::Range;

/// Variable-length lists of `u32` in compressed sparse rows: row `i` is
/// `entries[starts[i]..starts[i + 1]]`.
///
/// ```
/// use surface::Rows;
///
/// let rows = Rows::new(3, || [(2, 7), (0, 5), (2, 6)].into_iter());
/// assert_eq!(rows.row(2), [7, 6]);
/// assert!(rows.row(1).is_empty());
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rows {
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl Rows {
    /// Sorts pairs of (row, entry) into `rows` rows by counting; the order within a row is that
    /// of the pairs.
    ///
    /// # Panics
    ///
    /// When a row is not below `rows`.
    #[must_use]
    pub fn new<I: Iterator<Item = (u32, u32)>>(rows: usize, pairs: impl Fn() -> I) -> Self {
        let mut starts = vec![0_u32; rows + 1];
        for (row, _) in pairs() {
            starts[row as usize + 1] += 1;
        }
        for row in 0..rows {
            starts[row + 1] += starts[row];
        }
        let mut next = starts.clone();
        let mut entries = vec![0; starts[rows] as usize];
        for (row, entry) in pairs() {
            entries[next[row as usize] as usize] = entry;
            next[row as usize] += 1;
        }
        Self { starts, entries }
    }

    /// Returns the entries of a row.
    ///
    /// # Panics
    ///
    /// When there is no such row.
    #[must_use]
    #[inline]
    pub fn row(&self, row: u32) -> &[u32] {
        let row = row as usize;
        &self.entries[self.starts[row] as usize..self.starts[row + 1] as usize]
    }

    /// Where a row stands among all entries.
    ///
    /// # Panics
    ///
    /// When there is no such row.
    pub(crate) fn range(&self, row: u32) -> Range<u32> {
        self.starts[row as usize]..self.starts[row as usize + 1]
    }

    /// All rows in order.
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        let slice = |ends: &[u32]| &self.entries[ends[0] as usize..ends[1] as usize];
        self.starts.windows(2).map(slice)
    }
}
