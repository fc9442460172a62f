//! Progress reports of long calls, and their interruption.
//!
//! A long call takes a [`Progress`], reports the completed fraction at least every 0.1 s,
//! and returns early with [`Interrupted`] when the handler requests it. Results never
//! depend on the handler, except that an interrupted call returns none.

use std::fmt;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The handler of a [`Progress`] ended the call early.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the call was interrupted by its progress handler")]
pub struct Interrupted;

/// Handle by which a long call reports its completed fraction and polls for interruption.
///
/// Cheap to copy: pass it by value. The handler may be called from several threads at
/// once; fractions then arrive out of order.
///
/// ```
/// use std::ops::ControlFlow;
/// use surface::progress::{Interrupted, Progress};
///
/// fn sum(values: &[f64], progress: Progress<'_>) -> Result<f64, Interrupted> {
///     let mut sum = 0.0;
///     let steps = progress.steps(values.len());
///     for value in values {
///         sum += value;
///         steps.advance(1)?;
///     }
///     Ok(sum)
/// }
///
/// let stop_halfway = |fraction: f64| {
///     if fraction < 0.5 { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
/// };
/// assert_eq!(sum(&[1.0, 2.0, 3.0], Progress::none()), Ok(6.0));
/// assert_eq!(sum(&[1.0, 2.0, 3.0], Progress::new(&stop_halfway)), Err(Interrupted));
/// ```
#[derive(Clone, Copy)]
pub struct Progress<'a> {
    handler: Option<&'a Handler<'a>>,
    lower: f64,
    upper: f64,
}

type Handler<'a> = dyn Fn(f64) -> ControlFlow<()> + Sync + 'a;

impl<'a> Progress<'a> {
    /// Returns a handle that calls `handler` with the completed fraction, in `0.0..=1.0`.
    ///
    /// The call ends early once the handler returns [`ControlFlow::Break`]; a handler that
    /// has done so must keep doing so.
    #[must_use]
    pub const fn new(handler: &'a Handler<'a>) -> Self {
        Self { handler: Some(handler), lower: 0.0, upper: 1.0 }
    }

    /// Returns a handle that reports to nobody and never interrupts.
    #[must_use]
    pub const fn none() -> Self {
        Self { handler: None, lower: 0.0, upper: 1.0 }
    }

    /// Reports the completed fraction of this handle's range, clamped to `0.0..=1.0`.
    ///
    /// # Errors
    ///
    /// [`Interrupted`] when the handler ends the call.
    pub fn report(self, fraction: f64) -> Result<(), Interrupted> {
        let Some(handler) = self.handler else { return Ok(()) };

        match handler(self.overall(fraction)) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Interrupted),
        }
    }

    /// Returns a handle for a sub-range of the work: its fractions 0 and 1 are reported as
    /// the fractions `lower` and `upper` of this handle.
    #[must_use]
    pub fn part(self, lower: f64, upper: f64) -> Self {
        Self { lower: self.overall(lower), upper: self.overall(upper), ..self }
    }

    /// Returns a counter that reports after each of `count` equal steps.
    #[must_use]
    pub const fn steps(self, count: usize) -> ProgressSteps<'a> {
        ProgressSteps { progress: self, count, done: AtomicUsize::new(0) }
    }

    /// Returns a counter that polls for interruption once in `interval` steps of a loop.
    #[must_use]
    pub const fn every(self, interval: u32) -> Polls<'a> {
        Polls { progress: self, interval, left: 0 }
    }

    /// Maps a fraction of this handle's range to a fraction of the whole call.
    fn overall(self, fraction: f64) -> f64 {
        self.lower + (self.upper - self.lower) * fraction.clamp(0.0, 1.0)
    }
}

impl fmt::Debug for Progress<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Progress")
            .field("handler", &self.handler.is_some())
            .field("range", &(self.lower..=self.upper))
            .finish()
    }
}

/// Counter of equal steps, shared by the threads that complete them.
///
/// Made by [`Progress::steps`].
#[derive(Debug)]
pub struct ProgressSteps<'a> {
    progress: Progress<'a>,
    count: usize,
    done: AtomicUsize,
}

impl ProgressSteps<'_> {
    /// Counts `steps` more completed steps and reports their sum.
    ///
    /// # Errors
    ///
    /// [`Interrupted`] when the handler ends the call.
    pub fn advance(&self, steps: usize) -> Result<(), Interrupted> {
        if self.progress.handler.is_none() {
            return Ok(());
        }
        let done = self.done.fetch_add(steps, Ordering::Relaxed) + steps;
        self.progress.report(self.fraction(done))
    }

    /// Returns a handle that reports the present sum, for polls within a step that takes long.
    #[must_use]
    pub fn within(&self) -> Progress<'_> {
        let fraction = self.fraction(self.done.load(Ordering::Relaxed));
        self.progress.part(fraction, fraction)
    }

    #[expect(clippy::cast_precision_loss, reason = "a fraction needs few digits")]
    fn fraction(&self, done: usize) -> f64 {
        done as f64 / self.count.max(1) as f64
    }
}

/// Counter of the steps of one loop, which polls for interruption at some of them.
///
/// Made by [`Progress::every`].
#[derive(Debug)]
pub struct Polls<'a> {
    progress: Progress<'a>,
    interval: u32,
    /// Steps to go without a poll.
    left: u32,
}

impl Polls<'_> {
    /// Counts a step that begins; polls at the first one, and then once per interval.
    ///
    /// # Errors
    ///
    /// [`Interrupted`] when the handler ends the call.
    #[inline]
    pub fn step(&mut self) -> Result<(), Interrupted> {
        if self.left == 0 {
            self.left = self.interval;
            self.progress.report(0.0)?;
        }
        self.left = self.left.saturating_sub(1);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Mutex;

    use super::*;

    /// Fractions that `work` reports.
    fn reported(work: impl Fn(Progress<'_>)) -> Vec<f64> {
        let fractions = Mutex::new(Vec::new());
        work(Progress::new(&|fraction| {
            fractions.lock().unwrap().push(fraction);
            ControlFlow::Continue(())
        }));
        fractions.into_inner().unwrap()
    }

    #[test]
    fn parts_report_their_share_of_the_whole() {
        let fractions = reported(|progress| {
            let second_half = progress.part(0.5, 1.0);
            progress.report(0.25).unwrap();
            second_half.report(0.0).unwrap();
            second_half.part(0.5, 1.0).report(0.5).unwrap();
            second_half.report(7.0).unwrap();
        });
        assert_eq!(fractions, [0.25, 0.5, 0.875, 1.0]);
    }

    #[test]
    fn steps_report_the_completed_share() {
        let fractions = reported(|progress| {
            let steps = progress.part(0.0, 0.5).steps(4);
            steps.advance(1).unwrap();
            steps.within().report(0.7).unwrap();
            steps.advance(3).unwrap();
        });
        assert_eq!(fractions, [0.125, 0.125, 0.5]);
    }

    #[test]
    fn loops_poll_once_per_interval() {
        for (interval, polls) in [(1, 7), (3, 3), (7, 1), (100, 1), (0, 7)] {
            let fractions = reported(|progress| {
                let mut polls = progress.part(0.5, 1.0).every(interval);
                (0..7).for_each(|_| polls.step().unwrap());
            });
            assert_eq!(fractions, vec![0.5; polls], "{interval}");
        }
    }

    #[test]
    fn no_steps_are_complete_at_once() {
        assert_eq!(reported(|progress| progress.steps(0).advance(1).unwrap()), [1.0]);
    }

    #[test]
    fn a_handler_that_breaks_interrupts() {
        let stop = |_| ControlFlow::Break(());
        let progress = Progress::new(&stop);
        assert_eq!(progress.report(0.0), Err(Interrupted));
        assert_eq!(progress.part(0.2, 0.3).steps(3).advance(1), Err(Interrupted));
    }

    #[test]
    fn no_handler_never_interrupts() {
        assert_eq!(Progress::none().report(1.0), Ok(()));
        assert_eq!(Progress::none().steps(2).advance(1), Ok(()));
    }
}
