//! Answers of methods: all of a set, the slowest, and counts of wrong ones.

use std::hint::black_box;
use std::time::Duration;

use super::queries::CcdQuery;
use crate::measure::{Pace, Report, Side, as_f64, nanoseconds};

/// Answer to a query: the time of the first contact, if any.
pub type Method<'a> = &'a dyn Fn(&CcdQuery) -> Option<f64>;

/// Queries that are timed at once: long enough for the clock, and short enough that most blocks
/// are not interrupted in one round or another.
const BLOCK: usize = 256;

/// A method with its name.
pub type NamedMethod<'a> = (&'a str, Method<'a>);

/// Returns the mean time of each method per query \[ns\].
///
/// Methods take turns block by block. The minimum time of each block over all rounds counts, so
/// that other load on the machine falls on no method. A timer that reports by itself gets all
/// queries as one block.
#[must_use]
pub fn mean_times(
    name: &str,
    queries: &[CcdQuery],
    rounds: u32,
    methods: &[NamedMethod<'_>],
    report: &mut Report,
) -> Vec<f64> {
    let pace = Pace { min_turns: rounds, calls: 1, ..Pace::within(Duration::ZERO) };
    let block = if report.prints() { BLOCK } else { queries.len() };
    let mut totals = vec![0.0; methods.len()];
    for block in queries.chunks(block) {
        // All methods in turns on each block.
        let mut work = Vec::new();
        for &(name, method) in methods {
            work.push((name, move || answer_all(block, method)));
        }
        let mut sides: Vec<Side<'_>> = Vec::new();
        for (name, answer) in &mut work {
            sides.push((*name, answer));
        }

        for (total, time) in totals.iter_mut().zip(report.measure_all(name, pace, &mut sides)) {
            *total += time / as_f64(queries.len());
        }
    }
    totals
}

/// Answers all queries by a method; returns the number of contacts.
pub fn answer_all(queries: &[CcdQuery], method: Method<'_>) -> usize {
    let mut contacts = 0;
    for query in queries {
        contacts += usize::from(method(black_box(query)).is_some());
    }
    contacts
}

/// Returns the time of the slowest query \[ns\], the minimum of five runs each.
#[must_use]
pub fn max_time(queries: &[CcdQuery], method: Method<'_>) -> f64 {
    let mut slowest = 0.0_f64;
    for query in queries {
        let mut least = f64::INFINITY;
        for _ in 0..5 {
            least = least.min(nanoseconds(|| answer_all(std::slice::from_ref(query), method)));
        }
        slowest = slowest.max(least);
    }
    slowest
}

/// Answers beside the exact ones.
#[derive(Clone, Debug, Default)]
pub struct Answers {
    /// Contacts not found.
    pub missed: usize,
    /// Contacts reported only after they happen.
    pub late: usize,
    /// Contacts reported where there are none.
    pub false_alarms: usize,
    /// Exact time less the one reported, ascending, for contacts found.
    earliness: Vec<f64>,
}

impl Answers {
    /// Compares the answers of a method with the exact ones.
    #[must_use]
    pub fn new(queries: &[CcdQuery], method: Method<'_>) -> Self {
        let mut answers = Self::default();
        for query in queries {
            match (method(query), query.time.is_finite()) {
                (None, true) => answers.missed += 1,
                (Some(_), false) => answers.false_alarms += 1,
                (Some(time), true) => {
                    answers.late += usize::from(time > query.time);
                    answers.earliness.push(query.time - time);
                }
                (None, false) => {}
            }
        }
        answers.earliness.sort_by(f64::total_cmp);
        answers
    }

    /// Returns the earliness that `percent` of the contacts found do not exceed.
    #[must_use]
    pub fn earliness(&self, percent: usize) -> f64 {
        let last = self.earliness.len().saturating_sub(1);
        self.earliness.get(last * percent / 100).copied().unwrap_or(0.0)
    }
}
