//! Times of methods that take turns, and counts of wrong answers.

use std::hint::black_box;

use super::queries::CcdQuery;
use crate::measure::{as_f64, nanoseconds};

/// Answer to a query: the time of the first contact, if any.
pub type Method<'a> = &'a dyn Fn(&CcdQuery) -> Option<f64>;

/// Queries that are timed at once: long enough for the clock, and short enough that most blocks
/// are not interrupted in one round or another.
const BLOCK: usize = 256;

/// Returns the mean time of each method per query \[ns\].
///
/// Methods take turns block by block. The minimum time of each block over all rounds counts, so
/// that other load on the machine falls on no method.
#[must_use]
pub fn mean_times(queries: &[CcdQuery], rounds: usize, methods: &[Method<'_>]) -> Vec<f64> {
    // The minimum over the rounds is per block, so that one interruption spoils one block only.
    let mut totals = vec![0.0; methods.len()];
    for block in queries.chunks(BLOCK) {
        let mut least = vec![f64::INFINITY; methods.len()];
        for _ in 0..rounds {
            for (least, method) in least.iter_mut().zip(methods) {
                *least = least.min(answer_time(block, method));
            }
        }
        for (total, least) in totals.iter_mut().zip(least) {
            *total += least;
        }
    }
    totals.into_iter().map(|total| total / as_f64(queries.len())).collect()
}

/// Returns the time of the slowest query \[ns\], the minimum of five runs each.
#[must_use]
pub fn max_time(queries: &[CcdQuery], method: Method<'_>) -> f64 {
    let least = |query: &[CcdQuery]| {
        (0..5).map(|_| answer_time(query, &method)).fold(f64::INFINITY, f64::min)
    };
    queries.chunks(1).map(least).fold(0.0, f64::max)
}

/// Returns the time to answer all of the queries \[ns\].
fn answer_time(queries: &[CcdQuery], method: &Method<'_>) -> f64 {
    nanoseconds(|| {
        for query in queries {
            black_box(method(black_box(query)));
        }
        queries.len()
    })
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
        answers.add(queries, method);
        answers
    }

    /// Adds the answers to more queries.
    pub fn add(&mut self, queries: &[CcdQuery], method: Method<'_>) {
        for query in queries {
            match (method(query), query.time.is_finite()) {
                (None, true) => self.missed += 1,
                (Some(_), false) => self.false_alarms += 1,
                (Some(time), true) => {
                    self.late += usize::from(time > query.time);
                    self.earliness.push(query.time - time);
                }
                (None, false) => {}
            }
        }
        self.earliness.sort_by(f64::total_cmp);
    }

    /// Returns the earliness that `percent` of the contacts found do not exceed.
    #[must_use]
    pub fn earliness(&self, percent: usize) -> f64 {
        let last = self.earliness.len().saturating_sub(1);
        self.earliness.get(last * percent / 100).copied().unwrap_or(0.0)
    }
}
