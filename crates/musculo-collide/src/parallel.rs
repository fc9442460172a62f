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

/// Calls `f` on every item with its number, and returns the error of the first
/// item that has one. Allocates nothing.
#[cfg(feature = "rayon")]
pub(crate) fn try_each_mut<T: Send, E: Send>(
    items: &mut [T],
    f: impl Fn(usize, &mut T) -> Result<(), E> + Sync + Send,
) -> Result<(), E> {
    use rayon::prelude::*;
    let first = items
        .par_iter_mut()
        .enumerate()
        .with_max_len(1)
        .filter_map(|(number, item)| f(number, item).err().map(|error| (number, error)))
        .reduce_with(|p, q| if q.0 < p.0 { q } else { p });
    first.map_or(Ok(()), |(_, error)| Err(error))
}

/// Calls `f` on every item with its number, and returns the first error.
#[cfg(not(feature = "rayon"))]
pub(crate) fn try_each_mut<T: Send, E: Send>(
    items: &mut [T],
    f: impl Fn(usize, &mut T) -> Result<(), E> + Sync + Send,
) -> Result<(), E> {
    items.iter_mut().enumerate().try_for_each(|(number, item)| f(number, item))
}
