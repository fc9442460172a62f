//! Loops that run on the caller's thread pool with the feature `rayon`, and on the calling
//! thread without it or [where asked](on_calling_thread).
//!
//! Results stand in the order of the items and each depends on its item alone, so the bits
//! are the same for any number of threads and without the feature.

use std::cell::Cell;

#[cfg(feature = "rayon")]
use rayon::prelude::*;

thread_local! {
    /// True while loops of this thread stay on it.
    static IS_ALONE: Cell<bool> = const { Cell::new(!cfg!(feature = "rayon")) };
}

/// Runs a computation whose loops all stay on the calling thread.
///
/// A pool of one thread is another thread: computations of several callers would queue for it.
///
/// ```
/// use surface::parallel;
///
/// let caller = std::thread::current().id();
/// let threads = || parallel::map(1000, |_| std::thread::current().id());
/// assert!(parallel::on_calling_thread(threads).into_iter().all(|thread| thread == caller));
/// ```
pub fn on_calling_thread<R>(compute: impl FnOnce() -> R) -> R {
    /// Restores the state on return, and on a panic that the caller catches.
    struct Restore(bool);

    impl Drop for Restore {
        fn drop(&mut self) {
            IS_ALONE.set(self.0);
        }
    }

    let _restore = Restore(IS_ALONE.replace(true));
    compute()
}

/// Returns true if loops of this thread stay on it.
#[must_use]
pub fn is_alone() -> bool {
    IS_ALONE.get()
}

/// Pieces that a parallel loop is cut into.
///
/// Fewer leave threads waiting for the one that holds the expensive items: by default rayon
/// cuts a loop in four for two threads. More create more scratch values, one per piece.
#[cfg(feature = "rayon")]
const PIECES: usize = 64;

/// Returns the largest number of items per piece of a loop over `count` items.
#[cfg(feature = "rayon")]
fn piece(count: usize) -> usize {
    count.div_ceil(PIECES).max(1)
}

/// Maps the numbers `0..count`, in order.
pub fn map<R: Send>(count: usize, f: impl Fn(usize) -> R + Sync + Send) -> Vec<R> {
    map_with(count, || (), |(), i| f(i))
}

/// Maps the numbers `0..count`, in order, with a scratch value that is reused.
///
/// Results must not depend on what earlier items left in the scratch value.
pub fn map_with<S, R: Send>(
    count: usize,
    scratch: impl Fn() -> S + Sync + Send,
    f: impl Fn(&mut S, usize) -> R + Sync + Send,
) -> Vec<R> {
    #[cfg(feature = "rayon")]
    if !is_alone() {
        let numbers = (0..count).into_par_iter().with_max_len(piece(count));
        return numbers.map_init(scratch, f).collect();
    }
    let mut scratch = scratch();
    (0..count).map(|i| f(&mut scratch, i)).collect()
}

/// Maps the items of a slice, in order, with a scratch value that is reused.
///
/// Results must not depend on what earlier items left in the scratch value.
pub fn map_slice_with<T: Sync, S, R: Send>(
    items: &[T],
    scratch: impl Fn() -> S + Sync + Send,
    f: impl Fn(&mut S, &T) -> R + Sync + Send,
) -> Vec<R> {
    map_with(items.len(), scratch, |scratch, i| f(scratch, &items[i]))
}

/// Maps the items of a slice, in order, with a scratch value per thread that is reused. Items
/// with higher costs begin first, so that no thread ends long after the others.
///
/// Costs need no unit, and only affect the time. Results must not depend on what earlier items
/// left in the scratch value.
pub fn map_costly_first<T: Sync, S, R: Send>(
    items: &[T],
    cost: impl Fn(&T) -> f64,
    scratch: impl Fn() -> S + Sync + Send,
    f: impl Fn(&mut S, &T) -> R + Sync + Send,
) -> Vec<R> {
    #[cfg(feature = "rayon")]
    if !is_alone() {
        let mut order: Vec<(f64, usize)> = Vec::with_capacity(items.len());
        for (i, item) in items.iter().enumerate() {
            order.push((cost(item), i));
        }
        order.sort_by(|p, q| q.0.total_cmp(&p.0));

        // Each thread takes the next item of the queue, and results are put in order again.
        let queue = order.into_iter().par_bridge();
        let mut found: Vec<(usize, R)> =
            queue.map_init(scratch, |scratch, (_, i)| (i, f(scratch, &items[i]))).collect();
        found.sort_unstable_by_key(|(i, _)| *i);
        return found.into_iter().map(|(_, result)| result).collect();
    }
    // Without threads the order of the items has no effect on the time.
    let _ = cost;
    let mut scratch = scratch();
    items.iter().map(|item| f(&mut scratch, item)).collect()
}

/// Maps the items of a slice, in order, by a function that changes them.
pub fn map_mut<T: Send, R: Send>(items: &mut [T], f: impl Fn(&mut T) -> R + Sync + Send) -> Vec<R> {
    #[cfg(feature = "rayon")]
    if !is_alone() {
        let piece = piece(items.len());
        return items.par_iter_mut().with_max_len(piece).map(f).collect();
    }
    items.iter_mut().map(f).collect()
}

/// Calls `f` on every item with its number: disjoint parts of an array, for instance.
pub fn for_each<T: Send>(items: Vec<T>, f: impl Fn(usize, T) + Sync + Send) {
    #[cfg(feature = "rayon")]
    if !is_alone() {
        let piece = piece(items.len());
        let numbered = items.into_par_iter().enumerate().with_max_len(piece);
        return numbered.for_each(|(i, item)| f(i, item));
    }
    for (i, item) in items.into_iter().enumerate() {
        f(i, item);
    }
}

/// Calls `f` on every item with its number. Allocates nothing.
///
/// # Errors
///
/// The error of the first item that has one. Items after it may have been changed or not.
pub fn try_for_each_mut<T: Send, E: Send>(
    items: &mut [T],
    f: impl Fn(usize, &mut T) -> Result<(), E> + Sync + Send,
) -> Result<(), E> {
    #[cfg(feature = "rayon")]
    if !is_alone() {
        let piece = piece(items.len());
        // Threads fail in any order: the failure with the smallest number is returned.
        let numbered = items.par_iter_mut().enumerate().with_max_len(piece);
        let failures = numbered.filter_map(|(i, item)| Some((i, f(i, item).err()?)));
        return failures.min_by_key(|failure| failure.0).map_or(Ok(()), |failure| Err(failure.1));
    }
    for (i, item) in items.iter_mut().enumerate() {
        f(i, item)?;
    }
    Ok(())
}

/// Calls `f` on every item with its number. Items with higher costs begin first, so that no thread
/// ends long after the others.
///
/// Costs need no unit, and only affect the time. On one thread nothing is allocated.
///
/// # Errors
///
/// The error of the first item that has one. Other items may have been changed or not.
pub fn try_for_each_costly_first<T: Send, E: Send>(
    items: &mut [T],
    cost: impl Fn(usize, &T) -> f64,
    f: impl Fn(usize, &mut T) -> Result<(), E> + Sync + Send,
) -> Result<(), E> {
    #[cfg(feature = "rayon")]
    if threads() > 1 {
        let mut order: Vec<(f64, usize, &mut T)> = Vec::with_capacity(items.len());
        for (i, item) in items.iter_mut().enumerate() {
            order.push((cost(i, item), i, item));
        }
        order.sort_by(|p, q| q.0.total_cmp(&p.0));

        // Each thread takes the next item of the queue, also after a failure: the one with the
        // smallest number is returned.
        let queue = order.into_iter().par_bridge();
        let failures = queue.filter_map(|(_, i, item)| Some((i, f(i, item).err()?)));
        return failures.min_by_key(|failure| failure.0).map_or(Ok(()), |failure| Err(failure.1));
    }
    // On one thread the order of the items has no effect on the time.
    let _ = cost;
    for (i, item) in items.iter_mut().enumerate() {
        f(i, item)?;
    }
    Ok(())
}

/// Sorts a list; the order of equal items is unspecified.
pub fn sort_unstable<T: Ord + Send>(list: &mut [T]) {
    #[cfg(feature = "rayon")]
    if !is_alone() {
        return list.par_sort_unstable();
    }
    list.sort_unstable();
}

/// Returns the number of threads that share a loop.
#[must_use]
pub fn threads() -> usize {
    #[cfg(feature = "rayon")]
    if !is_alone() {
        return rayon::current_num_threads();
    }
    1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_stand_in_the_order_of_the_items() {
        for count in [0, 1, 7, 64, 1000] {
            let squares: Vec<usize> = (0..count).map(|i| i * i).collect();
            let mut items: Vec<usize> = (0..count).collect();
            assert_eq!(map(count, |i| i * i), squares);
            assert_eq!(map_slice_with(&items, || (), |(), &i| i * i), squares);
            let cost = |&i: &usize| f64::from(u32::try_from(i * 7919 % 13).unwrap());
            assert_eq!(map_costly_first(&items, cost, || (), |(), &i| i * i), squares);
            assert_eq!(map_mut(&mut items, |i| *i * *i), squares);
        }
    }

    #[test]
    fn costly_items_begin_first() {
        let items = [1.0, 3.0, 2.0, 5.0, 4.0];
        let begun = std::sync::Mutex::new(Vec::new());
        let note = |(): &mut (), &item: &f64| begun.lock().unwrap().push(item);
        let one_thread = || map_costly_first(&items, |&item| item, || (), note);
        #[cfg(feature = "rayon")]
        {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            pool.install(one_thread);
            assert_eq!(begun.into_inner().unwrap(), [5.0, 4.0, 3.0, 2.0, 1.0]);
        }
        #[cfg(not(feature = "rayon"))]
        {
            one_thread();
            assert_eq!(begun.into_inner().unwrap(), items);
        }
    }

    #[cfg(feature = "rayon")]
    #[test]
    fn costly_items_that_change_begin_first() {
        // Cheap items wait for the dearest, which two of them on both threads would keep waiting.
        let has_begun = std::sync::atomic::AtomicBool::new(false);
        let wait = |_: usize, item: &mut f64| {
            let begun = || has_begun.load(std::sync::atomic::Ordering::Relaxed);
            has_begun.fetch_or(*item > 4.5, std::sync::atomic::Ordering::Relaxed);
            for _ in 0..1000 {
                if begun() {
                    return Ok(());
                }
                std::thread::sleep(std::time::Duration::from_millis(1));
            }
            Err(*item)
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let mut items = [1.0, 3.0, 2.0, 5.0, 4.0];
        let done = pool.install(|| try_for_each_costly_first(&mut items, |_, &item| item, wait));
        assert_eq!(done, Ok(()));
    }

    #[test]
    fn every_part_is_visited_once_with_its_number() {
        let mut values = vec![0; 1000];
        for_each(values.chunks_mut(3).collect(), |i, part| part.iter_mut().for_each(|v| *v += i));
        assert!(values.iter().enumerate().all(|(i, value)| *value == i / 3));
    }

    #[test]
    fn the_error_of_the_first_item_is_returned() {
        let mut items = vec![0; 500];
        let fail_from = |first: usize| {
            move |i: usize, item: &mut i32| {
                *item += 1;
                if i < first { Ok(()) } else { Err(i) }
            }
        };
        assert_eq!(try_for_each_mut(&mut items, fail_from(123)), Err(123));
        assert_eq!(try_for_each_mut(&mut items, fail_from(500)), Ok(()));

        let cost = |i: usize, _: &i32| f64::from(u32::try_from(i * 7919 % 13).unwrap());
        assert_eq!(try_for_each_costly_first(&mut items, cost, fail_from(123)), Err(123));
        items.fill(0);
        assert_eq!(try_for_each_costly_first(&mut items, cost, fail_from(500)), Ok(()));
        assert_eq!(items, [1; 500]);
    }

    #[test]
    fn loops_stay_on_the_calling_thread_where_asked() {
        let caller = std::thread::current().id();
        let is_here = |_: usize| std::thread::current().id() == caller;
        on_calling_thread(|| {
            assert_eq!(threads(), 1);
            assert!(map(1000, is_here).into_iter().all(|is_here| is_here));
            for_each(vec![(); 1000], |i, ()| assert!(is_here(i)));

            // A computation within one leaves the state as it was.
            on_calling_thread(|| ());
            assert!(is_alone());
        });
        assert_eq!(is_alone(), !cfg!(feature = "rayon"));
    }

    #[test]
    fn sorts() {
        let mut list: Vec<u32> = (0..5000).map(|i| i * 7919 % 5003).collect();
        sort_unstable(&mut list);
        assert!(list.is_sorted());
        assert!(threads() >= 1);
    }
}
