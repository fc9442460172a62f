//! Turns of parts in Gauss–Seidel sweeps over all of them, on several threads (multicoloring).
//!
//! A sweep is short, and a parallel loop takes long to begin: one begins before the first sweep and ends after
//! the last. Threads take turns in order, and each turn waits until those of other colors before it are finished, so that
//! results are those of one thread. A thread that comes late, or never, delays nothing, and a helper without a
//! turn for long leaves.
//!
//! Source: Y. Saad, "Iterative Methods for Sparse Linear Systems", 2nd edition, SIAM, 2003, section 12.4, for
//! sweeps by colors. Differs in coloring parts of many particles, which keep their order, and in counters that are
//! polled in place of barriers.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use surface::parallel;

/// Polls of a counter between two yields of the core.
const POLLS_PER_YIELD: u32 = 64;

/// Polls for a turn after which a helper leaves: one or two milliseconds. Below, it leaves while the leader is
/// between two sweeps; above, it takes longer from a leader with which it shares a core.
const MAX_POLLS: u32 = 65_536;

/// Turns of all parts: in the order of their colors in the first sweep, backward in the second, and so on.
#[derive(Debug)]
pub(crate) struct Turns {
    /// Forward, and backward.
    orders: [Vec<Turn>; 2],
    /// Number of parts of the most frequent color.
    widest: usize,
    /// Number of the first turn that is not taken, over all sweeps.
    next: AtomicUsize,
    /// Number of turns that may be taken by now.
    released: AtomicUsize,
    finished: AtomicUsize,
    is_over: AtomicBool,
}

/// Turn of one part in a sweep.
#[derive(Clone, Copy, Debug)]
struct Turn {
    part: usize,
    /// Number of turns of the sweep that are to be finished before: those of other colors.
    after: usize,
}

impl Turns {
    /// Orders parts by their colors. Those of one color have nothing in common.
    pub(crate) fn new(colors: &[usize]) -> Self {
        let mut forward: Vec<usize> = (0..colors.len()).collect();
        forward.sort_by_key(|part| colors[*part]);
        let backward = forward.iter().rev().copied().collect();
        let orders = [forward, backward].map(|order: Vec<usize>| {
            let mut turns = Vec::with_capacity(order.len());
            for alike in order.chunk_by(|p, q| colors[*p] == colors[*q]) {
                let after = turns.len();
                turns.extend(alike.iter().map(|&part| Turn { part, after }));
            }
            turns
        });
        let widest = orders[0].chunk_by(|p, q| p.after == q.after).map(<[Turn]>::len).max();
        Self {
            orders,
            widest: widest.unwrap_or(0),
            next: AtomicUsize::new(0),
            released: AtomicUsize::new(0),
            finished: AtomicUsize::new(0),
            is_over: AtomicBool::new(false),
        }
    }

    /// Runs `lead`, which [sweeps](Self::sweep), while helpers on other threads take turns as well. `run` relaxes a
    /// part, given its number and true in a forward sweep.
    pub(crate) fn share(&self, run: &(impl Fn(usize, bool) + Sync), lead: impl Fn() + Sync) {
        /// Ends all turns, also when `lead` panics.
        struct End<'a>(&'a AtomicBool);

        impl Drop for End<'_> {
            fn drop(&mut self) {
                self.0.store(true, Ordering::Release);
            }
        }

        let threads = parallel::threads().min(self.widest).max(1);
        parallel::map(threads, |thread| {
            if thread == 0 {
                let _end = End(&self.is_over);
                lead();
            } else {
                self.help(run);
            }
        });
    }

    /// Takes the turn of each part once; returns when all are finished.
    pub(crate) fn sweep(&self, run: &impl Fn(usize, bool)) {
        let all = self.released.load(Ordering::Relaxed) + self.orders[0].len();
        self.released.store(all, Ordering::Release);
        while self.take(run) {}
        wait(|| self.finished.load(Ordering::Acquire) >= all);
    }

    /// Takes turns until all sweeps are over, or there has been none for [`MAX_POLLS`].
    fn help(&self, run: &impl Fn(usize, bool)) {
        let is_over = || self.is_over.load(Ordering::Acquire);
        let is_released =
            || self.next.load(Ordering::Relaxed) < self.released.load(Ordering::Acquire);
        while !is_over() && poll(MAX_POLLS, || is_over() || is_released()) {
            while self.take(run) {}
        }
    }

    /// Takes the next turn, unless another thread does; returns false where there is none by now.
    fn take(&self, run: &impl Fn(usize, bool)) -> bool {
        /// Counts a turn as finished, also when it panics.
        struct Finish<'a>(&'a AtomicUsize);

        impl Drop for Finish<'_> {
            fn drop(&mut self) {
                self.0.fetch_add(1, Ordering::Release);
            }
        }

        let number = self.next.load(Ordering::Relaxed);
        if number >= self.released.load(Ordering::Acquire) {
            return false;
        }
        let relaxed = Ordering::Relaxed;
        if self.next.compare_exchange(number, number + 1, relaxed, relaxed).is_err() {
            return true;
        }

        // Turns before this one are taken by threads that run, and that do not wait for this one.
        let _finish = Finish(&self.finished);
        let (sweep, place) = (number / self.orders[0].len(), number % self.orders[0].len());
        let Turn { part, after } = self.orders[sweep % 2][place];
        let before = number - place + after;
        wait(|| self.finished.load(Ordering::Acquire) >= before);
        run(part, sweep % 2 == 0);
        true
    }
}

/// Waits until another thread, which runs, has done something.
fn wait(is_done: impl Fn() -> bool) {
    while !poll(MAX_POLLS, &is_done) {}
}

/// Polls a condition, at most a number of times; returns true once it holds.
fn poll(count: u32, is_done: impl Fn() -> bool) -> bool {
    for number in 1..=count {
        if is_done() {
            return true;
        }
        if number % POLLS_PER_YIELD == 0 {
            std::thread::yield_now();
        } else {
            std::hint::spin_loop();
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;
    use std::time::Duration;

    use super::*;

    /// Colors of seven parts; the most frequent one has three.
    const COLORS: [usize; 7] = [0, 1, 0, 2, 1, 1, 2];

    #[test]
    fn each_turn_waits_for_those_of_other_colors() {
        let turns = Turns::new(&COLORS);
        assert_eq!(turns.widest, 3);
        let (started, ended) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
        let run = |part: usize, is_forward: bool| {
            // What has ended when a turn begins.
            let before = ended.lock().unwrap().len();
            started.lock().unwrap().push((part, is_forward, before));
            // Long enough for others to come.
            std::thread::sleep(Duration::from_micros(100));
            ended.lock().unwrap().push(part);
        };
        let sweeps = 100;
        turns.share(&run, || {
            for sweep in 1..=sweeps {
                turns.sweep(&run);
                // A sweep ends once all its turns have.
                assert_eq!(ended.lock().unwrap().len(), sweep * COLORS.len());
            }
        });

        let (started, ended) = (started.into_inner().unwrap(), ended.into_inner().unwrap());
        for (number, own) in started.chunks(COLORS.len()).enumerate() {
            let mut parts: Vec<usize> = own.iter().map(|(part, ..)| *part).collect();
            parts.sort_unstable();
            assert_eq!(parts, [0, 1, 2, 3, 4, 5, 6]);
            for &(part, is_forward, before) in own {
                assert_eq!(is_forward, number % 2 == 0);
                let done = &ended[number * COLORS.len()..before];
                let is_before = |other: usize| {
                    let (own, other) = (COLORS[part], COLORS[other]);
                    if is_forward { other < own } else { other > own }
                };
                for other in (0..COLORS.len()).filter(|other| is_before(*other)) {
                    assert!(done.contains(&other), "{other} before {part} in sweep {number}");
                }
            }
        }
    }

    #[test]
    fn sweeps_without_help_run_all() {
        let turns = Turns::new(&COLORS);
        let order = Mutex::new(Vec::new());
        let run = |part: usize, _: bool| order.lock().unwrap().push(part);
        turns.sweep(&run);
        turns.sweep(&run);
        assert_eq!(order.into_inner().unwrap(), [0, 2, 1, 4, 5, 3, 6, 6, 3, 5, 4, 1, 2, 0]);
    }
}
