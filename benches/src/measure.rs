//! Timing and figures: costs measured in one run, compared, and held to a bound.
//!
//! Absolute times depend on the machine and its load. The sides of a comparison therefore take
//! turns, and their minimum times are compared, since other work on the machine only adds time.
//!
//! A [`Report`] prints each [`Figure`] as one line of JSON, which `cargo xtask ratios` and
//! `cargo xtask verify` format and check.

use std::hint::black_box;
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use serde_json::json;

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

/// A cost, that of something else, and a bound on their ratio.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Name of the comparison.
    pub name: String,
    /// Our cost, in `unit`.
    pub ours: f64,
    /// The other cost, in `unit`; `None` where `ours` itself is bounded.
    pub other: Option<f64>,
    /// Unit of both costs.
    pub unit: &'static str,
    /// Upper bound on the ratio, or on `ours` without another cost; infinite where nothing is
    /// promised.
    pub allowed: f64,
}

impl Figure {
    /// Returns the value that is bounded.
    #[must_use]
    pub fn measured(&self) -> f64 {
        self.other.map_or(self.ours, |other| self.ours / other)
    }

    /// Returns true if the bound is kept.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.measured() <= self.allowed
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

    /// Adds the ratio of two times \[ns\], shown in microseconds.
    pub fn times(&mut self, name: impl Into<String>, ours: f64, other: f64, allowed: f64) {
        self.ratio(name, [ours * 1e-3, other * 1e-3], "us", allowed);
    }

    /// Adds the ratio of our cost to another.
    pub fn ratio(
        &mut self,
        name: impl Into<String>,
        [ours, other]: [f64; 2],
        unit: &'static str,
        allowed: f64,
    ) {
        self.add(&Figure { name: name.into(), ours, other: Some(other), unit, allowed });
    }

    /// Prints one figure.
    #[expect(clippy::print_stdout, reason = "the purpose of a report")]
    pub fn add(&mut self, figure: &Figure) {
        let Figure { name, ours, other, unit, allowed } = figure;
        let line = json!({
            "group": self.group,
            "name": name,
            "ours": ours,
            "other": other,
            "unit": unit,
            "allowed": allowed,
        });
        println!("{line}");
        if !figure.holds() {
            self.shortfalls.push(name.clone());
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
        let sides: [Side<'_>; 2] = [&mut || work(50_000), &mut || work(5_000)];
        let [slow, fast] = interleave(Duration::from_millis(20), sides);

        let mut report = Report::new(1.0);
        report.times("fast over slow", fast, slow, 2.0);
        assert!(report.shortfalls().is_empty(), "{:?}", report.shortfalls());
        report.times("slow over fast", slow, fast, 2.0);
        assert_eq!(report.shortfalls().len(), 1, "{:?}", report.shortfalls());
    }

    #[test]
    fn a_cost_without_a_bound_always_holds() {
        let mut figure = Figure {
            name: String::new(),
            ours: 3.0,
            other: None,
            unit: "ms",
            allowed: f64::INFINITY,
        };
        assert!(figure.holds());
        figure.allowed = 2.0;
        assert!(!figure.holds(), "3 ms of 2 ms");
    }
}
