//! Loops that run on the caller's thread pool with the feature `rayon`, and on the calling
//! thread without it or [where asked](on_calling_thread).
//!
//! Results stand in the order of the items and each depends on its item alone, so the bits
//! are the same for any number of threads and without the feature.

use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

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
const PIECES: usize = 64;

/// Returns the number of items per piece of a loop over `count` items; all of them on one thread.
fn piece(count: usize) -> usize {
    let pieces = if threads() > 1 { PIECES } else { 1 };
    count.div_ceil(pieces).max(1)
}

/// Calls `run` with each of the numbers `0..count`, on the threads that share a loop.
///
/// Loops over items of any type end here, so that rayon is compiled for one type of loop. Compiled
/// for each loop alone, it takes longer than everything else in a crate with a dozen of them.
fn share(count: usize, run: &(dyn Fn(usize) + Sync)) {
    #[cfg(feature = "rayon")]
    if count > 1 && threads() > 1 {
        return (0..count).into_par_iter().with_max_len(1).for_each(run);
    }
    (0..count).for_each(run);
}

/// Calls `run` with the first number and the items of each piece of a slice. Allocates nothing.
fn share_pieces<T: Send>(items: &mut [T], run: impl Fn(usize, &mut [T]) + Sync) {
    let size = piece(items.len());
    let count = items.len().div_ceil(size);
    let mut rest = items.chunks_mut(size);

    // Each piece has one owner, so that no lock is ever waited for.
    let pieces: [Mutex<&mut [T]>; PIECES] =
        std::array::from_fn(|_| Mutex::new(rest.next().unwrap_or_default()));
    share(count, &|number| run(number * size, &mut lock(&pieces[number])));
}

/// Locks a value. A thread that panicked with the lock ends the whole loop with its panic.
fn lock<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Results of the pieces of a loop.
struct PieceResults<R>([Mutex<Vec<R>>; PIECES]);

impl<R> PieceResults<R> {
    const fn new() -> Self {
        Self([const { Mutex::new(Vec::new()) }; PIECES])
    }

    /// Stores the results of the piece with the given number.
    fn set(&self, piece: usize, results: Vec<R>) {
        *lock(&self.0[piece]) = results;
    }

    /// Returns all results in the order of the pieces.
    fn in_order(self) -> Vec<R> {
        let pieces = self.0.map(|piece| piece.into_inner().unwrap_or_else(PoisonError::into_inner));
        let count: usize = pieces.iter().map(Vec::len).sum();

        // The only piece of a loop on one thread is returned as it is.
        let mut pieces = pieces.into_iter();
        let mut all = pieces.next().unwrap_or_default();
        all.reserve_exact(count - all.len());
        for mut piece in pieces {
            all.append(&mut piece);
        }
        all
    }
}

/// Failure of the item with the smallest number.
struct FirstFailure<E>(Mutex<Option<(usize, E)>>);

impl<E> FirstFailure<E> {
    const fn none() -> Self {
        Self(Mutex::new(None))
    }

    /// Adds the failure of an item. Threads fail in any order.
    fn add(&self, item: usize, error: E) {
        let mut first = lock(&self.0);
        if first.as_ref().is_none_or(|(other, _)| item < *other) {
            *first = Some((item, error));
        }
    }

    fn result(self) -> Result<(), E> {
        let first = self.0.into_inner().unwrap_or_else(PoisonError::into_inner);
        first.map_or(Ok(()), |(_, error)| Err(error))
    }
}

/// Numbers of items, of which each thread takes the next.
struct Queue {
    order: Vec<usize>,
    taken: AtomicUsize,
}

impl Queue {
    /// Queues items by descending costs; equal ones by their numbers.
    fn costly_first(costs: &[f64]) -> Self {
        let mut order: Vec<usize> = (0..costs.len()).collect();
        order.sort_by(|&i, &j| costs[j].total_cmp(&costs[i]));
        Self { order, taken: AtomicUsize::new(0) }
    }

    /// Queues items by their numbers.
    fn in_order(count: usize) -> Self {
        Self { order: (0..count).collect(), taken: AtomicUsize::new(0) }
    }

    fn next(&self) -> Option<usize> {
        self.order.get(self.taken.fetch_add(1, Ordering::Relaxed)).copied()
    }
}

/// Computes two values, side by side where there are two threads.
pub fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    #[cfg(feature = "rayon")]
    if threads() > 1 {
        return rayon::join(a, b);
    }
    (a(), b())
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
    let size = piece(count);
    let results = PieceResults::new();
    share(count.div_ceil(size), &|number| {
        let mut scratch = scratch();
        let first = number * size;
        let items = first..count.min(first + size);
        results.set(number, items.map(|i| f(&mut scratch, i)).collect());
    });
    results.in_order()
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
    // Without threads the order of the items has no effect on the time.
    let queue = if is_alone() {
        Queue::in_order(items.len())
    } else {
        Queue::costly_first(&items.iter().map(cost).collect::<Vec<f64>>())
    };

    let mut results = Vec::new();
    results.resize_with(items.len(), || Mutex::new(None));
    share(threads(), &|_| {
        let mut scratch = scratch();
        while let Some(i) = queue.next() {
            let result = f(&mut scratch, &items[i]);
            *lock(&results[i]) = Some(result);
        }
    });

    // Every item has been taken.
    let results = results.into_iter().map(Mutex::into_inner);
    results.filter_map(|result| result.unwrap_or_else(PoisonError::into_inner)).collect()
}

/// Maps the items of a slice, in order, by a function that changes them.
pub fn map_mut<T: Send, R: Send>(items: &mut [T], f: impl Fn(&mut T) -> R + Sync + Send) -> Vec<R> {
    let size = piece(items.len());
    let results = PieceResults::new();
    share_pieces(items, |first, items| {
        results.set(first / size, items.iter_mut().map(&f).collect());
    });
    results.in_order()
}

/// Maps the items of a slice, in order, by a function that changes them. Items with higher costs begin first, as in
/// [`map_costly_first`].
pub fn map_mut_costly_first<T: Send, R: Send>(
    items: &mut [T],
    cost: impl Fn(&T) -> f64,
    f: impl Fn(&mut T) -> R + Sync + Send,
) -> Vec<R> {
    let items: Vec<Mutex<&mut T>> = items.iter_mut().map(Mutex::new).collect();
    map_costly_first(&items, |item| cost(&lock(item)), || (), |(), item| f(&mut lock(item)))
}

/// Calls `f` on every item with its number: disjoint parts of an array, for instance.
pub fn for_each<T: Send>(items: Vec<T>, f: impl Fn(usize, T) + Sync + Send) {
    let mut items: Vec<Option<T>> = items.into_iter().map(Some).collect();
    share_pieces(&mut items, |first, items| {
        for (i, item) in (first..).zip(items) {
            if let Some(item) = item.take() {
                f(i, item);
            }
        }
    });
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
    let failure = FirstFailure::none();
    share_pieces(items, |first, items| {
        for (i, item) in (first..).zip(items) {
            if let Err(error) = f(i, item) {
                return failure.add(i, error);
            }
        }
    });
    failure.result()
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
    // On one thread the order of the items has no effect on the time.
    if threads() == 1 {
        return try_for_each_mut(items, f);
    }
    let mut costs = Vec::with_capacity(items.len());
    let mut owned = Vec::with_capacity(items.len());
    for (i, item) in items.iter_mut().enumerate() {
        costs.push(cost(i, item));
        owned.push(Mutex::new(item));
    }

    // The queue goes on after a failure: one of an item with a smaller number may follow.
    let (queue, failure) = (Queue::costly_first(&costs), FirstFailure::none());
    share(threads(), &|_| {
        while let Some(i) = queue.next() {
            if let Err(error) = f(i, &mut lock(&owned[i])) {
                failure.add(i, error);
            }
        }
    });
    failure.result()
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
            let add = |i: &mut usize| std::mem::replace(i, *i + 1).pow(2);
            assert_eq!(map_mut_costly_first(&mut items, cost, add), squares);
            assert!(items.iter().enumerate().all(|(i, item)| *item == i + 1));
        }
    }

    #[test]
    fn both_values_are_computed() {
        assert_eq!(join(|| 3, || "five"), (3, "five"));
        assert_eq!(on_calling_thread(|| join(|| 3, || "five")), (3, "five"));
    }

    #[test]
    fn costly_items_begin_first() {
        let items = [1.0, 3.0, 2.0, 5.0, 4.0];
        let begun = Mutex::new(Vec::new());
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
            let begun = || has_begun.load(Ordering::Relaxed);
            has_begun.fetch_or(*item > 4.5, Ordering::Relaxed);
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
