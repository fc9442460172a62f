//! Ratios of costs, taken in one run and held to a bound.
//!
//! Absolute times depend on the machine and on what else it does. Here the sides of a comparison
//! take turns, and the least time of each is compared: other work on the machine only ever adds.

use std::fmt;
use std::hint::black_box;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// What one side of a comparison took.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// Least time of one call \[ns\].
    pub least: f64,
    /// Median time of one call \[ns\].
    pub median: f64,
}

/// Calls of a turn.
const CALLS: usize = 3;

/// One side of a comparison.
pub type Side<'a> = &'a mut dyn FnMut() -> usize;

/// Runs all sides in turn for about `budget` (but at least five turns each), after one unmeasured
/// call. A turn is three calls: the first finds the caches as the others left them. A side returns something that depends on its work, so that the work is done.
pub fn interleave<const N: usize>(budget: Duration, mut sides: [Side<'_>; N]) -> [Timing; N] {
    let mut times = [const { Vec::new() }; N];
    for side in &mut sides {
        black_box(side());
    }
    let start = Instant::now();
    while start.elapsed() < budget || times[0].len() < 5 * CALLS {
        for (side, times) in sides.iter_mut().zip(&mut times) {
            for _ in 0..CALLS {
                let start = Instant::now();
                black_box(side());
                times.push(start.elapsed().as_secs_f64() * 1e9);
            }
        }
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        Timing { least: times[0], median: times[times.len() / 2] }
    })
}

/// A count, to be divided by another.
#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
#[must_use]
pub const fn amount(count: usize) -> f64 {
    count as f64
}

/// One figure: ours, another's, their ratio and what is allowed of it.
#[derive(Clone, Debug)]
pub struct Ratio {
    /// What was compared.
    pub name: String,
    /// Our cost, in `unit`.
    pub ours: f64,
    /// The other's cost, in `unit`.
    pub theirs: f64,
    /// Unit of both, for the reader.
    pub unit: &'static str,
    /// The ratio may not exceed this.
    pub allowed: f64,
}

impl Ratio {
    /// Compares least times \[ns\], shown in microseconds.
    #[must_use]
    pub fn of_times(name: &str, ours: Timing, theirs: Timing, allowed: f64) -> Self {
        let [ours, theirs] = [ours.least * 1e-3, theirs.least * 1e-3];
        Self { name: name.to_owned(), ours, theirs, unit: "us", allowed }
    }

    /// Compares two amounts of anything.
    #[must_use]
    pub fn new(name: &str, ours: f64, theirs: f64, unit: &'static str, allowed: f64) -> Self {
        Self { name: name.to_owned(), ours, theirs, unit, allowed }
    }

    /// Ours over the other's.
    #[must_use]
    pub fn ratio(&self) -> f64 {
        self.ours / self.theirs
    }

    /// Whether the ratio is what is allowed, or less.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.ratio() <= self.allowed
    }
}

/// `ratio`, then name, ours, the other's, ratio, allowed and `ok` or `SHORT`, with tabs between.
impl fmt::Display for Ratio {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, ours, theirs, unit, allowed } = self;
        let verdict = if self.holds() { "ok" } else { "SHORT" };
        let ratio = self.ratio();
        write!(
            f,
            "ratio\t{name:<44}\t{ours:>9.1} {unit}\t{theirs:>9.1} {unit}\t{ratio:.3}\t{allowed}\t{verdict}"
        )
    }
}

/// Prints figures as they come, and remembers whether one falls short.
#[derive(Debug, Default)]
pub struct Report {
    short: Vec<String>,
}

impl Report {
    /// Prints one figure.
    #[expect(clippy::print_stdout, reason = "what a report is for")]
    pub fn add(&mut self, ratio: &Ratio) {
        println!("{ratio}");
        if !ratio.holds() {
            self.short.push(ratio.name.clone());
        }
    }

    /// Success, or failure where a figure fell short; names those.
    #[expect(clippy::print_stderr, reason = "what a report is for")]
    #[must_use]
    pub fn finish(&self) -> ExitCode {
        if self.short.is_empty() {
            return ExitCode::SUCCESS;
        }
        eprintln!("short: {}", self.short.join(", "));
        ExitCode::FAILURE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slower_side_is_seen_and_reported() {
        let work = |n: usize| (0..n).fold(0, |sum, i| black_box(sum ^ i));
        let budget = Duration::from_millis(20);
        let [slow, fast] = interleave(budget, [&mut || work(50_000), &mut || work(5_000)]);
        let ratio = Ratio::of_times("slow over fast", slow, fast, 2.0);
        assert!(!ratio.holds() && ratio.to_string().ends_with("SHORT"), "{ratio}");
        let ratio = Ratio::of_times("fast over slow", fast, slow, 2.0);
        assert!(ratio.holds() && ratio.to_string().ends_with("ok"), "{ratio}");
    }
}
