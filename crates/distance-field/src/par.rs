//! Loops over parts of the grid, in parallel where the `rayon` feature is on.
//!
//! Parts never share a node and every node's result depends on the input
//! alone, so the bits are the same for any number of threads.

#[cfg(feature = "rayon")]
use rayon::prelude::*;

/// Pieces of a loop that threads take in turn. Left to itself, rayon cuts it in four
/// for two threads, and then waits for the one that holds the thick end of a bone.
#[cfg(feature = "rayon")]
const PIECES: usize = 64;

/// Runs `work(i, part)` for every part.
pub(crate) fn for_each<T: Send>(parts: Vec<T>, work: impl Fn(usize, T) + Sync) {
    #[cfg(feature = "rayon")]
    {
        let piece = parts.len().div_ceil(PIECES).max(1);
        let parts = parts.into_par_iter().enumerate().with_max_len(piece);
        parts.for_each(|(i, part)| work(i, part));
    }
    #[cfg(not(feature = "rayon"))]
    parts.into_iter().enumerate().for_each(|(i, part)| work(i, part));
}

/// `work(i)` for `0..count`, in order.
pub(crate) fn map<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    #[cfg(feature = "rayon")]
    {
        let piece = count.div_ceil(PIECES).max(1);
        (0..count).into_par_iter().with_max_len(piece).map(work).collect()
    }
    #[cfg(not(feature = "rayon"))]
    (0..count).map(work).collect()
}

/// The rows of a grid, each one's place along y by its number: one list for each plane across y.
pub(crate) fn walls<T>(rows: impl Iterator<Item = T>, ny: usize) -> Vec<Vec<T>> {
    let mut walls: Vec<Vec<T>> = (0..ny).map(|_| Vec::new()).collect();
    for (r, row) in rows.enumerate() {
        walls[r % ny].push(row);
    }
    walls
}

/// Sorts; which of two equals comes first is not told.
pub(crate) fn sort<T: Ord + Send>(list: &mut [T]) {
    #[cfg(feature = "rayon")]
    list.par_sort_unstable();
    #[cfg(not(feature = "rayon"))]
    list.sort_unstable();
}
