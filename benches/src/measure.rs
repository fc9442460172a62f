//! Timing harness and figures: costs measured in one run, compared, and held to a bound.
//!
//! Absolute times depend on the machine and its load. The sides of a comparison therefore take
//! turns, and their minimum times are compared, since other work on the machine only adds time.
//!
//! A [`Report`] prints each figure as one line of JSON, which `cargo xtask ratios` and
//! `cargo xtask verify` format and check. The bench target `figures` runs the same functions with a
//! [`Timer`] of its own.

use std::fmt::Debug;
use std::hint::black_box;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};
use serde_json::json;

/// Name and work of one side of a comparison. The value that the work returns depends on all of
/// it, so that none of it is optimized away.
pub type Side<'a> = (&'a str, &'a mut dyn FnMut() -> usize);

/// Our work, then that of the other side.
pub type Sides<'a> = [&'a mut dyn FnMut() -> usize; 2];

/// Amount and clock of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Turns per side, at least.
    pub min_turns: u32,
    /// Calls per turn. The first finds the caches as the other sides left them.
    pub calls: u32,
    /// Time for all turns, at least.
    pub budget: Duration,
    /// Clock of the calls.
    pub clock: fn() -> Duration,
}

impl Pace {
    /// Measures wall time for about `budget`.
    #[must_use]
    pub const fn within(budget: Duration) -> Self {
        Self { min_turns: 5, calls: 3, budget, clock: wall_time }
    }

    /// Measures processor time of this thread over a number of calls, for calls so long that other
    /// load on the machine interrupts them.
    #[must_use]
    pub const fn long_calls(rounds: u32) -> Self {
        Self { min_turns: rounds, calls: 1, budget: Duration::ZERO, clock: thread_time }
    }

    /// Returns the time of one call \[ns\].
    pub fn call_time(&self, work: impl FnOnce() -> usize) -> f64 {
        let start = (self.clock)();
        black_box(work());
        ((self.clock)() - start).as_secs_f64() * 1e9
    }
}

/// Method to time the sides of a comparison.
pub trait Timer: Debug + Send {
    /// Returns the minimum time per call \[ns\] of each side.
    fn times(&mut self, name: &str, pace: Pace, sides: &mut [Side<'_>]) -> Vec<f64>;
}

/// Time of one call of every side above which a turn is one call.
const LONG_CALLS: Duration = Duration::from_millis(100);

/// Timer whose sides take turns, after one unmeasured call each.
#[derive(Clone, Copy, Debug, Default)]
pub struct TakingTurns;

impl Timer for TakingTurns {
    fn times(&mut self, _: &str, pace: Pace, sides: &mut [Side<'_>]) -> Vec<f64> {
        let mut least = vec![f64::INFINITY; sides.len()];
        let first_calls = Instant::now();
        for (_, work) in sides.iter_mut() {
            black_box(work());
        }

        // Long calls replace what is in the caches themselves.
        let is_long = first_calls.elapsed() > LONG_CALLS;
        let calls = if is_long { 1 } else { pace.calls };

        // Full turns only, so that every side has the same number of calls.
        let start = Instant::now();
        let mut turns = 0;
        while turns < pace.min_turns || start.elapsed() < pace.budget {
            for ((_, work), least) in sides.iter_mut().zip(&mut least) {
                for _ in 0..calls {
                    *least = least.min(pace.call_time(&mut **work));
                }
            }
            turns += 1;
        }
        least
    }
}

/// Returns the minimum times per call \[ns\] of sides that take turns for about `milliseconds`.
#[must_use]
pub fn interleave<const N: usize>(milliseconds: u64, sides: [Side<'_>; N]) -> [f64; N] {
    Report::new(1.0).interleave("", milliseconds, sides)
}

/// Returns the wall time of one call \[ns\].
pub fn nanoseconds(work: impl FnOnce() -> usize) -> f64 {
    Pace::within(Duration::ZERO).call_time(work)
}

/// Returns the time since the first call.
#[must_use]
pub fn wall_time() -> Duration {
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

/// Returns the processor time of this thread; wall time where the system does not report it.
///
/// Other load on the machine does not add to it, but for what it takes of shared caches.
#[must_use]
pub fn thread_time() -> Duration {
    // The system brings its account of a thread up to date where that lets others run; else it
    // advances in steps of milliseconds.
    std::thread::yield_now();

    // Nanoseconds on the processor, then on its run queue, then time slices.
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let running = statistics.and_then(|line| line.split(' ').next()?.parse().ok());
    running.map_or_else(wall_time, Duration::from_nanos)
}

/// Starts a pool of threads.
///
/// # Errors
///
/// When a thread cannot be started.
pub fn pool(threads: usize) -> Result<ThreadPool, ThreadPoolBuildError> {
    ThreadPoolBuilder::new().num_threads(threads).build()
}

/// Returns the processor time \[ms\] of the busiest thread of each pool, the minimum over rounds in
/// which the pools take turns.
///
/// Everything that only one thread can do is part of it, but not the wait for a processor that
/// other programs use.
pub fn busiest_times<R: Send>(
    rounds: u32,
    pools: &[ThreadPool; 2],
    mut work: impl FnMut() -> R + Send,
) -> [f64; 2] {
    let mut busiest = [f64::INFINITY; 2];
    for _ in 0..rounds {
        for (pool, busiest) in pools.iter().zip(&mut busiest) {
            let before = pool.broadcast(|_| thread_time());
            pool.install(|| black_box(work()));
            let after = pool.broadcast(|_| thread_time());
            let mut max = Duration::ZERO;
            for (after, before) in after.iter().zip(before) {
                max = max.max(*after - before);
            }
            *busiest = busiest.min(max.as_secs_f64() * 1e3);
        }
    }
    busiest
}

/// Converts a count to a number to calculate with.
#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
#[must_use]
pub const fn as_f64(count: usize) -> f64 {
    count as f64
}

/// Printer of figures, which counts those beyond their bounds.
#[derive(Debug)]
pub struct Report {
    timer: Box<dyn Timer>,
    group: &'static str,
    effort: f64,
    prints: bool,
    /// Beginning of the names that are printed.
    only: String,
    shortfalls: Vec<String>,
}

impl Report {
    /// Starts a report that gives each comparison `effort` times its budget.
    #[must_use]
    pub fn new(effort: f64) -> Self {
        let timer = Box::new(TakingTurns);
        let (only, shortfalls) = (String::new(), Vec::new());
        Self { timer, group: "", effort, prints: true, only, shortfalls }
    }

    /// Reports figures alone whose names begin with a text.
    #[must_use]
    pub fn only(self, beginning: impl Into<String>) -> Self {
        Self { only: beginning.into(), ..self }
    }

    /// Returns true if some figure whose name begins with a text is reported: others need not be
    /// measured.
    #[must_use]
    pub fn wants(&self, beginning: &str) -> bool {
        beginning.starts_with(&self.only) || self.only.starts_with(beginning)
    }

    /// Starts a report that prints nothing: its timer does.
    #[must_use]
    pub fn with_timer(timer: Box<dyn Timer>) -> Self {
        Self { timer, prints: false, ..Self::new(1.0) }
    }

    /// Starts a group of figures.
    pub const fn begin(&mut self, group: &'static str) {
        self.group = group;
    }

    /// Returns the minimum time per call \[ns\] of each side within a budget \[ms\], which is
    /// scaled by the effort as the number of turns is.
    pub fn interleave<const N: usize>(
        &mut self,
        name: &str,
        milliseconds: u64,
        sides: [Side<'_>; N],
    ) -> [f64; N] {
        let budget = Duration::from_millis(milliseconds).mul_f64(self.effort);
        let pace = Pace::within(budget);
        self.measure(name, Pace { min_turns: self.rounds(pace.min_turns), ..pace }, sides)
    }

    /// Returns the minimum times per call \[ns\] of each side at a pace.
    pub fn measure<const N: usize>(
        &mut self,
        name: &str,
        pace: Pace,
        mut sides: [Side<'_>; N],
    ) -> [f64; N] {
        let times = self.measure_all(name, pace, &mut sides);
        std::array::from_fn(|side| times[side])
    }

    /// Returns the minimum times per call \[ns\] of any number of sides at a pace.
    pub fn measure_all(&mut self, name: &str, pace: Pace, sides: &mut [Side<'_>]) -> Vec<f64> {
        // Timers that report by themselves name the crate, too.
        self.timer.times(&format!("{}: {name}", self.group), pace, sides)
    }

    /// Returns true if figures are printed, and not by the timer.
    #[must_use]
    pub const fn prints(&self) -> bool {
        self.prints
    }

    /// Returns the number of rounds to measure, out of `rounds` at full effort.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small counts")]
    pub fn rounds(&self, rounds: u32) -> u32 {
        ((f64::from(rounds) * self.effort).ceil() as u32).max(1)
    }

    /// Times two sides within a budget \[ms\], adds the ratio of their times, and returns them
    /// \[ns\]. The name is that of our side, then of the other, as in `refit / parry`.
    pub fn compare(
        &mut self,
        name: &str,
        milliseconds: u64,
        allowed: f64,
        [ours, other]: Sides<'_>,
    ) -> [f64; 2] {
        let other_name = name.rsplit(" / ").next().unwrap_or(name);
        let times = self.interleave(name, milliseconds, [("ours", ours), (other_name, other)]);
        self.times(name, times, allowed);
        times
    }

    /// Adds the ratio of two times \[ns\], shown in microseconds.
    pub fn times(&mut self, name: impl Into<String>, times: [f64; 2], allowed: f64) {
        self.ratio(name, times.map(|time| time * 1e-3), "us", allowed);
    }

    /// Adds the ratio of our cost to another.
    pub fn ratio(
        &mut self,
        name: impl Into<String>,
        [ours, other]: [f64; 2],
        unit: &'static str,
        allowed: f64,
    ) {
        self.add(name.into(), ours, Some(other), unit, allowed);
    }

    /// Adds a cost beside nothing.
    pub fn cost(&mut self, name: impl Into<String>, ours: f64, unit: &'static str, allowed: f64) {
        self.add(name.into(), ours, None, unit, allowed);
    }

    /// Prints a figure: our cost, that of something else if any, and the bound on their ratio.
    #[expect(clippy::print_stdout, reason = "the purpose of a report")]
    fn add(
        &mut self,
        name: String,
        ours: f64,
        other: Option<f64>,
        unit: &'static str,
        allowed: f64,
    ) {
        if !name.starts_with(&self.only) {
            return;
        }
        // A ratio that is not a number keeps no bound.
        let measured = other.map_or(ours, |other| ours / other);
        let holds = measured <= allowed;
        if self.prints {
            // An infinite bound, where nothing is promised, is written as null.
            let figure = json!({
                "group": self.group,
                "name": name,
                "ours": ours,
                "other": other,
                "unit": unit,
                "measured": measured,
                "allowed": allowed,
                "verdict": if holds { "ok" } else { "SHORT" },
            });
            println!("{figure}");
        }
        if !holds {
            self.shortfalls.push(name);
        }
    }

    /// Returns the names of the figures beyond their bounds.
    #[must_use]
    pub fn shortfalls(&self) -> &[String] {
        &self.shortfalls
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts calls of two sides of a duration each, in two turns of three calls.
    fn calls_of(milliseconds: u64) -> [u32; 2] {
        let mut counts = [0; 2];
        let [first, second] = &mut counts;
        let call = |count: &mut u32| {
            *count += 1;
            std::thread::sleep(Duration::from_millis(milliseconds));
            1
        };
        let pace = Pace { min_turns: 2, ..Pace::within(Duration::ZERO) };
        let sides: &mut [Side<'_>] = &mut [("", &mut || call(first)), ("", &mut || call(second))];
        TakingTurns.times("", pace, sides);
        counts
    }

    #[test]
    fn long_calls_are_made_once_per_turn() {
        assert_eq!(calls_of(0), [7; 2]);
        assert_eq!(calls_of(60), [3; 2]);
    }

    #[test]
    fn a_slower_side_falls_short() {
        let work = |n: usize| (0..n).fold(0, |sum, i| black_box(sum ^ i));
        let mut report = Report::new(1.0);
        let [slow, fast] =
            report.compare("slow / fast", 20, 2.0, [&mut || work(50_000), &mut || work(5_000)]);
        assert_eq!(report.shortfalls(), ["slow / fast"]);
        report.times("fast / slow", [fast, slow], 2.0);
        assert_eq!(report.shortfalls().len(), 1, "{:?}", report.shortfalls());
    }

    #[test]
    fn figures_of_one_beginning_are_reported_alone() {
        let mut report = Report::new(1.0).only("rest exact, velocity");
        assert!(report.wants("rest") && report.wants("rest exact, velocity: overlap"));
        assert!(!report.wants("gait") && !report.wants("rest exact, sequence"));
        report.cost("rest exact, sequence: overlap", 3.0, "mm", 2.0);
        report.cost("rest exact, velocity: overlap", 3.0, "mm", 2.0);
        assert_eq!(report.shortfalls(), ["rest exact, velocity: overlap"]);
    }

    #[test]
    fn a_cost_without_a_bound_always_holds() {
        let mut report = Report::new(1.0);
        report.cost("any", 3.0, "ms", f64::INFINITY);
        assert!(report.shortfalls().is_empty());
        report.cost("3 ms of 2 ms", 3.0, "ms", 2.0);
        assert_eq!(report.shortfalls(), ["3 ms of 2 ms"]);
    }
}
