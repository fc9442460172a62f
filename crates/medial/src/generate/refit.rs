//! Refit of balls that are still too many: fits in turn with the [removal](super::removal) of some
//! balls. Of many, some are then [added](super::split) where the error is largest, and as many are
//! removed.

use surface::progress::Progress;

use super::fit::{Fit, FitParams};
use super::removal::Removals;
use super::sample_map::FittedSurface;
use super::samples::sample_count;
use super::split::split;
use crate::surface_distance::SurfaceDistance;
use crate::{MedialError, MedialSurface, real};

/// Number of balls up to which they are fitted quickly; more are worth more time.
const MANY_BALLS: usize = 200;

/// Number of samples per ball that is left, beyond which more hardly improve the fit.
///
/// With 60 the balls follow the samples, and the error between these is a twentieth larger.
const SAMPLES_PER_BALL: usize = 160;

/// Number of samples that are always taken, if the surface has them.
const MIN_SAMPLES: usize = 5_000;

/// Interval of samples while there are too many balls, where up to [`MANY_BALLS`] are left on a
/// surface that has fewer samples than the last fit takes. The error of more balls is a hundredth
/// smaller if all are taken.
const SAMPLE_INTERVAL: usize = 2;

/// Number of steps of the fit before the first removal.
const STEPS_BEFORE: u32 = 6;

/// Effort of a refit, by the number of balls that are left.
struct Effort {
    /// Share of the cost whose gain ends a fit: 0.2 % of the cost is 0.1 % of the root mean square
    /// error.
    min_gain: f64,
    /// Number of steps of the fit between two removals: after a careful removal, a second one is of
    /// little use.
    steps_between: u32,
    /// Number of rounds in which balls are added where the error is largest, and as many removed.
    /// All together reduce the error by about a hundredth.
    exchanges: u32,
    /// True if a neighbor is moved to the best place before a removal is assessed.
    is_careful: bool,
}

const FEW: Effort = Effort { min_gain: 2e-3, steps_between: 2, exchanges: 0, is_careful: false };
const MANY: Effort = Effort { min_gain: 2e-4, steps_between: 1, exchanges: 10, is_careful: true };

/// Fractions of the refit at which the exchanges and the last fit begin.
const THINNED_OUT: f64 = 0.5;
const EXCHANGED: f64 = 0.75;

/// Refit of one medial surface.
pub(super) struct Refit<'a> {
    pub(super) distance: &'a SurfaceDistance<'a>,
    /// Number of balls that are left.
    pub(super) balls: usize,
    /// Maximum number of steps of the last fit.
    pub(super) steps: u32,
    pub(super) inscribed_weight: f64,
}

/// Returns the number of balls to start from, for `count` to be left.
///
/// These are three quarters more at [`MANY_BALLS`], up to twice as many for more, and a smaller share
/// for fewer, which would take long on a large surface; and only as far as the surface has the
/// samples to assess removals.
pub(super) fn initial_balls(distance: &SurfaceDistance<'_>, count: usize) -> usize {
    let samples = SAMPLES_PER_BALL.saturating_mul(count).max(1);
    let share = count.saturating_mul(3).min(4 * MANY_BALLS);
    let more = count.saturating_mul(share) / (4 * MANY_BALLS);
    count + more.saturating_mul(sample_count(distance).min(samples)) / samples
}

impl Refit<'_> {
    /// Moves and resizes the balls of `medial`, and removes those that increase the error least until
    /// the requested number is left.
    pub(super) fn run(
        &self,
        medial: &mut MedialSurface,
        progress: Progress<'_>,
    ) -> Result<(), MedialError> {
        self.thin_out(medial, STEPS_BEFORE, progress.part(0.0, THINNED_OUT))?;

        // Exchange, unless some could not be removed.
        let is_complete = medial.balls().len() == self.balls;
        let rounds = if is_complete { self.effort().exchanges } else { 0 };
        for round in 0..rounds {
            let done = f64::from(round) / f64::from(rounds);
            self.exchange(medial, progress.part(THINNED_OUT, EXCHANGED).part(done, done))?;
        }

        let params = self.fit_params(self.steps, self.samples());
        Fit::run(medial, self.distance, &params, progress.part(EXCHANGED, 1.0))?;
        Ok(())
    }

    /// Removes balls until the requested number is left or none can be removed, after fits of `steps`
    /// steps at first.
    fn thin_out(
        &self,
        medial: &mut MedialSurface,
        mut steps: u32,
        progress: Progress<'_>,
    ) -> Result<(), MedialError> {
        let total = medial.balls().len().saturating_sub(self.balls);
        let params = self.fit_params(steps, self.samples_before());
        while medial.balls().len() > self.balls {
            let excess = medial.balls().len() - self.balls;
            let done = 1.0 - real(excess) / real(total);
            let progress = progress.part(done, done);

            let params = FitParams { steps, ..params };
            let fit = Fit::run(medial, self.distance, &params, progress)?;
            let fitted = FittedSurface::new(medial, &fit.tracking, &fit.importance, &fit.feet);
            let removals = Removals { fitted: &fitted, is_careful: self.effort().is_careful };
            let count = excess.min(self.removals_at_once());
            let Some(thinned) = removals.apply(count, progress)? else { break };
            *medial = thinned;
            steps = self.effort().steps_between;
        }
        Ok(())
    }

    /// Adds balls where the error is largest, and removes as many.
    fn exchange(
        &self,
        medial: &mut MedialSurface,
        progress: Progress<'_>,
    ) -> Result<(), MedialError> {
        let steps = self.effort().steps_between;
        let params = self.fit_params(steps, self.samples_before());
        let fit = Fit::run(medial, self.distance, &params, progress)?;
        *medial = split(medial, &fit.squares(medial), self.removals_at_once())?;
        self.thin_out(medial, steps, progress)
    }

    fn are_many(&self) -> bool {
        self.balls > MANY_BALLS
    }

    fn effort(&self) -> &'static Effort {
        if self.are_many() { &MANY } else { &FEW }
    }

    fn fit_params(&self, steps: u32, samples: usize) -> FitParams {
        let inscribed_importance = self.inscribed_importance();
        FitParams { steps, samples, min_gain: self.effort().min_gain, inscribed_importance }
    }

    /// Returns the importance of balls that extend outside. Slabs between many balls are small, and
    /// leave the shape by little between samples.
    fn inscribed_importance(&self) -> f64 {
        self.inscribed_weight * (real(MANY_BALLS) / real(self.balls)).min(1.0).powi(3)
    }

    /// Returns the number of balls that are removed at once: half as many take twice as long.
    fn removals_at_once(&self) -> usize {
        10.max(self.balls / 20)
    }

    /// Returns the number of samples of the last fit.
    fn samples(&self) -> usize {
        MIN_SAMPLES.max(SAMPLES_PER_BALL * self.balls)
    }

    /// Returns the number of samples while there are too many balls.
    fn samples_before(&self) -> usize {
        let all = sample_count(self.distance);
        if all < self.samples() && !self.are_many() {
            MIN_SAMPLES.max(all / SAMPLE_INTERVAL)
        } else {
            self.samples()
        }
    }
}
