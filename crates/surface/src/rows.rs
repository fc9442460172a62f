//! Lists of numbers of different lengths, in two arrays.

use std::ops::Range;

/// Lists of numbers, one after the other: row `i` is `entries[starts[i]..starts[i + 1]]`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Rows {
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl Rows {
    /// Sorts pairs of (row, entry) into `rows` rows by counting; the order
    /// within a row is that of the pairs.
    pub(crate) fn new<I: Iterator<Item = (u32, u32)>>(rows: usize, pairs: impl Fn() -> I) -> Self {
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

    /// # Panics
    ///
    /// When there is no such row.
    pub(crate) fn row(&self, row: u32) -> &[u32] {
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
