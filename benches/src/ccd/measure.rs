//! Times of methods that take turns, and counts of wrong answers.

use std::hint::black_box;
use std::time::Instant;

use super::queries::Query;

/// A way to answer a query: the time of the first contact, if any.
pub type Method<'a> = &'a dyn Fn(&Query) -> Option<f64>;

/// Queries that are timed at once: long enough for the clock, short enough that
/// most blocks are not interrupted in one round or another.
const BLOCK: usize = 256;

/// Mean time of each method a query \[ns\].
///
/// Methods take turns block by block; of each block the least time over all
/// rounds counts, so that what else the machine does falls on no method.
#[must_use]
pub fn mean_times(queries: &[Query], rounds: usize, methods: &[Method<'_>]) -> Vec<f64> {
    let mut totals = vec![0.0; methods.len()];
    for block in queries.chunks(BLOCK) {
        let mut least = vec![f64::INFINITY; methods.len()];
        for _ in 0..rounds {
            for (least, method) in least.iter_mut().zip(methods) {
                *least = least.min(nanoseconds(|| {
                    for query in block {
                        black_box(method(black_box(query)));
                    }
                }));
            }
        }
        for (total, least) in totals.iter_mut().zip(least) {
            *total += least;
        }
    }
    totals.into_iter().map(|total| total / as_f64(queries.len())).collect()
}

/// Time of the query that takes longest \[ns\], the least of five runs each.
#[must_use]
pub fn worst_time(queries: &[Query], method: Method<'_>) -> f64 {
    let of = |query: &Query| {
        let run = || {
            nanoseconds(|| {
                black_box(method(black_box(query)));
            })
        };
        (0..5).map(|_| run()).fold(f64::INFINITY, f64::min)
    };
    queries.iter().map(of).fold(0.0, f64::max)
}

/// How long something takes \[ns\].
pub fn nanoseconds(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64() * 1e9
}

/// Answers beside the exact ones.
#[derive(Clone, Debug, Default)]
pub struct Answers {
    /// Contacts not found.
    pub missed: usize,
    /// Contacts found after they happen.
    pub late: usize,
    /// Contacts found where there are none.
    pub false_alarms: usize,
    /// Exact time less the one given, ascending, for contacts found.
    earliness: Vec<f64>,
}

impl Answers {
    /// Asks a method all queries.
    #[must_use]
    pub fn of(queries: &[Query], method: Method<'_>) -> Self {
        let mut answers = Self::default();
        answers.add(queries, method);
        answers
    }

    /// Asks a method more queries.
    pub fn add(&mut self, queries: &[Query], method: Method<'_>) {
        let answers = self;
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
    }

    /// The earliness that `percent` of the contacts found do not exceed.
    #[must_use]
    pub fn earliness(&self, percent: usize) -> f64 {
        let last = self.earliness.len().saturating_sub(1);
        self.earliness.get(last * percent / 100).copied().unwrap_or(0.0)
    }
}

/// A count as a number to divide by.
#[expect(clippy::cast_precision_loss, reason = "counts are far below 2^53")]
#[must_use]
pub fn as_f64(count: usize) -> f64 {
    count as f64
}
