//! Compressed sparse rows (CSR).

/// Variable-length lists of `u32` in compressed sparse rows: row `i` is
/// `entries[starts[i]..starts[i + 1]]`.
///
/// ```
/// use surface::Csr;
///
/// let rows = Csr::new(3, &[(2, 7), (0, 5), (2, 6)]);
/// assert_eq!(rows.row(2), [7, 6]);
/// assert!(rows.row(1).is_empty());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Csr {
    starts: Vec<u32>,
    entries: Vec<u32>,
}

impl Csr {
    /// Sorts pairs of (row, entry) into `rows` rows by counting; the order within a row is
    /// that of the pairs.
    ///
    /// # Panics
    ///
    /// When a row is not below `rows`.
    #[must_use]
    pub fn new(rows: usize, pairs: &[(u32, u32)]) -> Self {
        let mut sorted = Self::default();
        sorted.refill(rows, pairs.iter().copied());
        sorted
    }

    /// Sorts pairs as [`new`](Self::new) does, in the memory that is there.
    ///
    /// # Panics
    ///
    /// When a row is not below `rows`.
    pub fn refill(&mut self, rows: usize, pairs: impl Iterator<Item = (u32, u32)> + Clone) {
        // Count the entries of each row two places behind it, and sum the counts.
        let Self { starts, entries } = self;
        starts.clear();
        starts.resize(rows + 2, 0);
        let mut count = 0;
        pairs.clone().for_each(|(row, _)| {
            starts[row as usize + 2] += 1;
            count += 1;
        });
        for row in 2..rows + 2 {
            starts[row] += starts[row - 1];
        }

        // One place behind a row is its start, which moves on to its end as entries are added.
        entries.clear();
        entries.resize(count, 0);
        pairs.for_each(|(row, entry)| {
            let next = &mut starts[row as usize + 1];
            entries[*next as usize] = entry;
            *next += 1;
        });
        starts.pop();
    }

    /// Takes rows as they are: `starts` has the start of each, and the end of the last.
    pub(crate) fn from_parts(starts: Vec<u32>, entries: Vec<u32>) -> Self {
        Self { starts, entries }
    }

    /// Concatenates rows, of fewer than 2³² entries in all.
    pub(crate) fn from_rows(rows: &[Vec<u32>]) -> Self {
        let mut starts = vec![0];
        let mut end = 0;
        for row in rows {
            end += u32::try_from(row.len()).unwrap_or(u32::MAX);
            starts.push(end);
        }
        Self { starts, entries: rows.concat() }
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

    /// Returns its memory, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        size_of_val(&self.starts[..]) + size_of_val(&self.entries[..])
    }

    /// Returns all rows in order.
    pub(crate) fn iter(&self) -> impl ExactSizeIterator<Item = &[u32]> {
        self.starts.windows(2).map(|ends| &self.entries[ends[0] as usize..ends[1] as usize])
    }
}
