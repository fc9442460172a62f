//! Timing and figures: costs measured in one run, compared, and held to a bound.
//!
//! Absolute times depend on the machine and its load. The sides of a comparison therefore take
//! turns, and their minimum times are compared, since other work on the machine only adds time.
//!
//! A [`Report`] prints each `Figure` as one line of JSON, which `cargo xtask ratios` and
//! `cargo xtask verify` format and check.

use std::hint::black_box;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use serde::Serialize;

/// One side of a comparison: returns a value that depends on all of its work, so that none of it
/// is optimized away.
pub type Side<'a> = &'a mut dyn FnMut() -> usize;

/// Calls per turn. The first finds the caches as the other sides left them.
const CALLS: usize = 3;

/// Turns per side, at least.
const MIN_TURNS: usize = 5;

/// Returns the minimum time per call \[ns\] of each side, which take turns for about `budget`.
///
/// One unmeasured call per side comes first.
pub fn interleave<const N: usize>(budget: Duration, mut sides: [Side<'_>; N]) -> [f64; N] {
    let mut least = [f64::INFINITY; N];
    for side in &mut sides {
        black_box(side());
    }

    // Full turns only, so that every side has the same number of calls.
    let start = Instant::now();
    let mut turns = 0;
    while turns < MIN_TURNS || start.elapsed() < budget {
        for (side, least) in sides.iter_mut().zip(&mut least) {
            for _ in 0..CALLS {
                *least = least.min(nanoseconds(&mut **side));
            }
        }
        turns += 1;
    }
    least
}

/// Returns the time of one call \[ns\].
pub fn nanoseconds(work: impl FnOnce() -> usize) -> f64 {
    let start = Instant::now();
    black_box(work());
    start.elapsed().as_secs_f64() * 1e9
}

/// Returns the processor time of this thread; wall time where the system does not report it.
///
/// Other load on the machine does not add to it, but it advances in steps of up to milliseconds.
#[must_use]
pub fn thread_time() -> Duration {
    static START: OnceLock<Instant> = OnceLock::new();

    // Nanoseconds on the processor, then on its run queue, then time slices.
    let statistics = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let running = statistics.and_then(|line| line.split(' ').next()?.parse().ok());
    running.map_or_else(|| START.get_or_init(Instant::now).elapsed(), Duration::from_nanos)
}

/// Converts a count to a number to calculate with.
#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
#[must_use]
pub const fn as_f64(count: usize) -> f64 {
    count as f64
}

/// A cost, that of something else, and a bound on their ratio: one line of JSON.
#[derive(Clone, Debug, Serialize)]
struct Figure {
    group: &'static str,
    name: String,
    ours: f64,
    /// The other cost; `None` where `ours` itself is bounded.
    other: Option<f64>,
    unit: &'static str,
    /// Upper bound; infinite, written as null, where nothing is promised.
    allowed: f64,
}

impl Figure {
    /// Returns true if the bound is kept.
    fn holds(&self) -> bool {
        self.other.map_or(self.ours, |other| self.ours / other) <= self.allowed
    }
}

/// Printer of figures, which counts those beyond their bounds.
#[derive(Debug)]
pub struct Report {
    group: &'static str,
    effort: f64,
    shortfalls: Vec<String>,
}

impl Report {
    /// Starts a report that gives each comparison `effort` times its budget.
    #[must_use]
    pub const fn new(effort: f64) -> Self {
        Self { group: "", effort, shortfalls: Vec::new() }
    }

    /// Starts a group of figures.
    pub const fn begin(&mut self, group: &'static str) {
        self.group = group;
    }

    /// Returns the minimum time per call \[ns\] of each side within a budget, scaled by the effort.
    pub fn interleave<const N: usize>(&self, milliseconds: u64, sides: [Side<'_>; N]) -> [f64; N] {
        interleave(Duration::from_millis(milliseconds).mul_f64(self.effort), sides)
    }

    /// Returns how many rounds to measure, out of `rounds` at full effort.
    #[must_use]
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small counts")]
    pub fn rounds(&self, rounds: usize) -> usize {
        ((as_f64(rounds) * self.effort).ceil() as usize).max(1)
    }

    /// Times two sides within a budget \[ms\], adds the ratio of their times, and returns them
    /// \[ns\].
    pub fn compare(
        &mut self,
        name: impl Into<String>,
        milliseconds: u64,
        allowed: f64,
        sides: [Side<'_>; 2],
    ) -> [f64; 2] {
        let times = self.interleave(milliseconds, sides);
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
        let (group, name, other) = (self.group, name.into(), Some(other));
        self.add(Figure { group, name, ours, other, unit, allowed });
    }

    /// Adds a cost beside nothing.
    pub fn cost(&mut self, name: impl Into<String>, ours: f64, unit: &'static str, allowed: f64) {
        let (group, name) = (self.group, name.into());
        self.add(Figure { group, name, ours, other: None, unit, allowed });
    }

    /// Prints one figure.
    #[expect(clippy::print_stdout, reason = "the purpose of a report")]
    fn add(&mut self, figure: Figure) {
        println!("{}", serde_json::to_string(&figure).unwrap_or_default());
        if !figure.holds() {
            self.shortfalls.push(figure.name);
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

    #[test]
    fn a_slower_side_falls_short() {
        let work = |n: usize| (0..n).fold(0, |sum, i| black_box(sum ^ i));
        let mut report = Report::new(1.0);
        let sides: [Side<'_>; 2] = [&mut || work(50_000), &mut || work(5_000)];
        let [slow, fast] = report.compare("slow over fast", 20, 2.0, sides);
        assert_eq!(report.shortfalls().len(), 1, "{:?}", report.shortfalls());
        report.times("fast over slow", [fast, slow], 2.0);
        assert_eq!(report.shortfalls().len(), 1, "{:?}", report.shortfalls());
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
