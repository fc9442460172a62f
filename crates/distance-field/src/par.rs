//! Loops over parts of the grid, in parallel where the `rayon` feature is on.
//!
//! Parts never share a node and every node's result depends on the input
//! alone, so the bits are the same for any number of threads.

#[cfg(feature = "rayon")]
use rayon::prelude::*;

/// Runs `work(i, part)` for every part.
pub(crate) fn for_each<T: Send>(parts: Vec<T>, work: impl Fn(usize, T) + Sync) {
    #[cfg(feature = "rayon")]
    parts.into_par_iter().enumerate().for_each(|(i, part)| work(i, part));
    #[cfg(not(feature = "rayon"))]
    parts.into_iter().enumerate().for_each(|(i, part)| work(i, part));
}

/// `work(i)` for `0..count`, in order.
pub(crate) fn map<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    #[cfg(feature = "rayon")]
    return (0..count).into_par_iter().map(work).collect();
    #[cfg(not(feature = "rayon"))]
    return (0..count).map(work).collect();
}
