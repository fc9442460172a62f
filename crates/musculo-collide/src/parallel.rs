//! Maps over slices that use threads where the `rayon` feature is on.
//!
//! Results stand in the order of the items, so that no thread count changes them.

/// `items.map(f)` with a scratch value that is reused within a thread.
#[cfg(feature = "rayon")]
pub(crate) fn map_with<T: Sync, S, R: Send>(
    items: &[T],
    scratch: impl Fn() -> S + Sync + Send,
    f: impl Fn(&mut S, &T) -> R + Sync + Send,
) -> Vec<R> {
    use rayon::prelude::*;
    // One item at a time: pairs differ by orders of magnitude in cost.
    items.par_iter().with_max_len(1).map_init(scratch, |scratch, item| f(scratch, item)).collect()
}

/// `items.map(f)` with a scratch value that is reused.
#[cfg(not(feature = "rayon"))]
pub(crate) fn map_with<T: Sync, S, R: Send>(
    items: &[T],
    scratch: impl Fn() -> S + Sync + Send,
    f: impl Fn(&mut S, &T) -> R + Sync + Send,
) -> Vec<R> {
    let mut scratch = scratch();
    items.iter().map(|item| f(&mut scratch, item)).collect()
}

/// `items.map(f)` where `f` changes the items.
#[cfg(feature = "rayon")]
pub(crate) fn map_mut<T: Send, R: Send>(
    items: &mut [T],
    f: impl Fn(&mut T) -> R + Sync + Send,
) -> Vec<R> {
    use rayon::prelude::*;
    items.par_iter_mut().with_max_len(1).map(f).collect()
}

/// `items.map(f)` where `f` changes the items.
#[cfg(not(feature = "rayon"))]
pub(crate) fn map_mut<T: Send, R: Send>(
    items: &mut [T],
    f: impl Fn(&mut T) -> R + Sync + Send,
) -> Vec<R> {
    items.iter_mut().map(f).collect()
}
