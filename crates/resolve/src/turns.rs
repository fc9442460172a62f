//! Turns of bodies in Gauss–Seidel sweeps over all of them, on several threads (level scheduling).
//!
//! A sweep is short, and a parallel loop takes long to begin: one begins before the first sweep and ends after
//! the last. Threads take turns in order, and each turn waits until those of other levels are finished, so that
//! results are those of one thread. A thread that comes late, or never, delays nothing, and a helper without a
//! turn for long leaves.
//!
//! Source: E. Anderson and Y. Saad, "Solving sparse triangular linear systems on parallel computers",
//! International Journal of High Speed Computing 1(1), 1989. Differs in levels of whole bodies, and in
//! counters that are polled in place of barriers.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use surface::parallel;

/// Polls of a counter between two yields of the core.
const POLLS_PER_YIELD: u32 = 64;

/// Polls for a turn after which a helper leaves: one or two milliseconds. Below, it leaves while the leader is
/// between two sweeps; above, it takes longer from a leader with which it shares a core.
const MAX_POLLS: u32 = 65_536;

/// Turns of all bodies: in the order of their levels in the first sweep, backward in the second, and so on.
#[derive(Debug)]
pub(crate) struct Turns {
    /// Forward, and backward.
    orders: [Vec<Turn>; 2],
    /// Number of bodies of the widest level.
    widest: usize,
    /// Number of the first turn that is not taken, over all sweeps.
    next: AtomicUsize,
    /// Number of turns that may be taken by now.
    released: AtomicUsize,
    finished: AtomicUsize,
    is_over: AtomicBool,
}

/// Turn of one body in a sweep.
#[derive(Clone, Copy, Debug)]
struct Turn {
    body: usize,
    /// Number of turns of the sweep that are to be finished before: those of other levels.
    after: usize,
}

impl Turns {
    /// Orders bodies by their levels. Those of one level have nothing in common.
    pub(crate) fn new(levels: &[usize]) -> Self {
        let mut forward: Vec<usize> = (0..levels.len()).collect();
        forward.sort_by_key(|body| levels[*body]);
        let backward = forward.iter().rev().copied().collect();
        let orders = [forward, backward].map(|order: Vec<usize>| {
            let mut turns = Vec::with_capacity(order.len());
            for level in order.chunk_by(|p, q| levels[*p] == levels[*q]) {
                let after = turns.len();
                turns.extend(level.iter().map(|&body| Turn { body, after }));
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
    /// body, given its number and true in a forward sweep.
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

    /// Takes the turn of each body once; returns when all are finished.
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
        let Turn { body, after } = self.orders[sweep % 2][place];
        let before = number - place + after;
        wait(|| self.finished.load(Ordering::Acquire) >= before);
        run(body, sweep % 2 == 0);
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

    /// Levels of seven bodies; the widest has three.
    const LEVELS: [usize; 7] = [0, 1, 0, 2, 1, 1, 2];

    #[test]
    fn each_turn_waits_for_those_of_other_levels() {
        let turns = Turns::new(&LEVELS);
        assert_eq!(turns.widest, 3);
        let (started, ended) = (Mutex::new(Vec::new()), Mutex::new(Vec::new()));
        let run = |body: usize, is_forward: bool| {
            // What has ended when a turn begins.
            let before = ended.lock().unwrap().len();
            started.lock().unwrap().push((body, is_forward, before));
            // Long enough for others to come.
            std::thread::sleep(Duration::from_micros(100));
            ended.lock().unwrap().push(body);
        };
        let sweeps = 100;
        turns.share(&run, || {
            for sweep in 1..=sweeps {
                turns.sweep(&run);
                // A sweep ends once all its turns have.
                assert_eq!(ended.lock().unwrap().len(), sweep * LEVELS.len());
            }
        });

        let (started, ended) = (started.into_inner().unwrap(), ended.into_inner().unwrap());
        for (number, own) in started.chunks(LEVELS.len()).enumerate() {
            let mut bodies: Vec<usize> = own.iter().map(|(body, ..)| *body).collect();
            bodies.sort_unstable();
            assert_eq!(bodies, [0, 1, 2, 3, 4, 5, 6]);
            for &(body, is_forward, before) in own {
                assert_eq!(is_forward, number % 2 == 0);
                let done = &ended[number * LEVELS.len()..before];
                let is_before = |other: usize| {
                    let (own, other) = (LEVELS[body], LEVELS[other]);
                    if is_forward { other < own } else { other > own }
                };
                for other in (0..LEVELS.len()).filter(|other| is_before(*other)) {
                    assert!(done.contains(&other), "{other} before {body} in sweep {number}");
                }
            }
        }
    }

    #[test]
    fn sweeps_without_help_run_all() {
        let turns = Turns::new(&LEVELS);
        let order = Mutex::new(Vec::new());
        let run = |body: usize, _: bool| order.lock().unwrap().push(body);
        turns.sweep(&run);
        turns.sweep(&run);
        assert_eq!(order.into_inner().unwrap(), [0, 2, 1, 4, 5, 3, 6, 6, 3, 5, 4, 1, 2, 0]);
    }
}
