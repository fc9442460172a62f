//! Levenberg–Marquardt fit of balls to the surface, on both sides of it.
//!
//! Two kinds of residuals are minimized in the least-squares sense:
//!
//! - at samples p of the surface, the signed distance φ(p) of the union. With b the weights of the
//!   foot of p and u the unit vector from its center to p, φ changes by `−b_k u·dc_k − b_k dr_k` when
//!   the balls do: the shift of the foot itself does not count, since φ is minimal there;
//! - at points of the primitives, the distance by which their ball extends outside the surface:
//!   `max(0, r − D)`, with D the depth of its center. Samples of the surface alone do not detect a
//!   slab that leaves the shape between them.

use glam::{DVec3, DVec4};
use surface::progress::Progress;

use super::inscribed::Inscribed;
use super::normal_equations::{MIN_DAMPING, NormalEquations, Residual};
use super::samples::Samples;
use super::tracking::Tracking;
use crate::surface_distance::SurfaceDistance;
use crate::{MedialError, MedialSurface, NearestPrimitive, real};

/// Damping at which no step lowers the cost: the limit of rounding.
const MAX_DAMPING: f64 = 1e6;

/// Factor on the damping after a step that lowers the cost.
const DAMPING_DECREASE: f64 = 0.2;

/// Factor on the damping after a step that does not.
const DAMPING_INCREASE: f64 = 8.0;

/// Number of accepted steps between searches of all primitives for the feet of samples.
const STEPS_PER_SEARCH: u32 = 4;

/// Parameters of one fit.
#[derive(Clone, Copy, Debug)]
pub(super) struct FitParams {
    /// Maximum number of steps.
    pub(super) steps: u32,
    /// Number of samples, up to twice as many.
    pub(super) samples: usize,
    /// Share of the cost whose gain ends the fit.
    pub(super) min_gain: f64,
    /// Importance of balls that extend outside, relative to the samples.
    pub(super) inscribed_importance: f64,
}

/// Samples and balls that the residuals are evaluated at.
pub(super) struct Fit {
    pub(super) tracking: Tracking,
    pub(super) feet: Vec<NearestPrimitive>,
    /// Importance of each sample: its share of the area, relative to the mean share.
    pub(super) importance: Vec<f64>,
    inscribed: Inscribed,
    accepted_steps: u32,
}

impl Fit {
    /// Moves and resizes the balls, and returns the samples with their feet.
    pub(super) fn run(
        medial: &mut MedialSurface,
        distance: &SurfaceDistance<'_>,
        params: &FitParams,
        progress: Progress<'_>,
    ) -> Result<Self, MedialError> {
        let mut fit = Self::new(medial, distance, params, progress.part(0.0, 0.0))?;
        let primitives = medial.primitives().to_vec();
        let mut equations = NormalEquations::new(medial.balls().len(), &primitives);
        let mut damping = MIN_DAMPING;
        for step in 0..params.steps {
            let done = f64::from(step) / f64::from(params.steps);
            let progress = progress.part(done, done);

            // Linearize, solve, and try.
            let residuals = fit.residuals(medial);
            equations.clear();
            for residual in &residuals {
                equations.add(residual);
            }
            let before = cost(&residuals);
            let after = fit.step(medial, &equations, before, &mut damping, progress)?;
            let Some(after) = after else { break };
            if before - after < params.min_gain * before {
                break;
            }
            fit.search(medial, distance, progress)?;
        }
        Ok(fit)
    }

    fn new(
        medial: &MedialSurface,
        distance: &SurfaceDistance<'_>,
        params: &FitParams,
        progress: Progress<'_>,
    ) -> Result<Self, MedialError> {
        let Samples { points, faces, importance } = Samples::new(distance, params.samples);
        let mut tracking = Tracking::new(medial, points, progress)?;
        let feet = tracking.feet(medial, &vec![0.0; medial.balls().len()], progress)?;

        // A face near each primitive shortens the first search.
        let mut face_near = vec![0; medial.primitives().len()];
        for (foot, face) in feet.iter().zip(faces) {
            face_near[foot.primitive as usize] = face;
        }
        let total_importance = params.inscribed_importance * real(feet.len());
        let mut inscribed = Inscribed::new(medial, total_importance, &face_near);
        inscribed.search(medial, distance, progress)?;
        Ok(Self { tracking, feet, importance, inscribed, accepted_steps: 0 })
    }

    /// Sums the squares of the samples' distances, by the primitives that they are nearest to.
    pub(super) fn squares(&self, medial: &MedialSurface) -> Vec<f64> {
        let mut squares = vec![0.0; medial.primitives().len()];
        for (nearest, importance) in self.feet.iter().zip(&self.importance) {
            squares[nearest.primitive as usize] += importance * nearest.foot.distance.powi(2);
        }
        squares
    }

    /// Searches again for closest points and primitives, after a step.
    fn search(
        &mut self,
        medial: &MedialSurface,
        distance: &SurfaceDistance<'_>,
        progress: Progress<'_>,
    ) -> Result<(), MedialError> {
        self.accepted_steps += 1;
        if self.accepted_steps.is_multiple_of(STEPS_PER_SEARCH) {
            self.tracking.rebuild_lists(medial, progress)?;
        }
        Ok(self.inscribed.search(medial, distance, progress)?)
    }

    /// Tries steps of growing damping until one lowers the cost; moves `medial` and returns the cost
    /// there. `None` where no step does.
    ///
    /// The balls are compared with the surface points of the last search, not with new ones: those
    /// are searched for once per step, not once per trial.
    fn step(
        &mut self,
        medial: &mut MedialSurface,
        equations: &NormalEquations<'_>,
        before: f64,
        damping: &mut f64,
        progress: Progress<'_>,
    ) -> Result<Option<f64>, MedialError> {
        while *damping <= MAX_DAMPING {
            // The cost with the balls of the trial, at their own feet.
            let trial = moved(medial, &equations.solve(*damping));
            let traveled = traveled(medial, &trial);
            let feet = self.tracking.feet(&trial, &traveled, progress)?;
            let feet_before = std::mem::replace(&mut self.feet, feet);

            let after = cost(&self.residuals(&trial));
            if after < before {
                self.tracking.add_travel(&traveled);
                *medial = trial;
                *damping = (*damping * DAMPING_DECREASE).max(MIN_DAMPING);
                return Ok(Some(after));
            }
            self.feet = feet_before;
            *damping *= DAMPING_INCREASE;
        }
        Ok(None)
    }

    /// Computes one residual per sample, in their order, then those of balls that extend outside.
    fn residuals(&self, medial: &MedialSurface) -> Vec<Residual> {
        let mut residuals = Vec::with_capacity(self.feet.len());
        let samples = self.tracking.points().iter().zip(&self.importance);
        for (nearest, (&p, &importance)) in self.feet.iter().zip(samples) {
            residuals.push(sample_residual(nearest, p, importance));
        }
        residuals.extend(self.inscribed.residuals(medial));
        residuals
    }
}

/// Returns the residual of the distance of a sample.
fn sample_residual(nearest: &NearestPrimitive, p: DVec3, importance: f64) -> Residual {
    let outward = nearest.foot.normal(p).unwrap_or(DVec3::ZERO);
    Residual {
        primitive: nearest.primitive,
        weights: nearest.foot.weights,
        gradient: (-outward).extend(-1.0),
        value: nearest.foot.distance,
        importance,
    }
}

/// Returns the medial surface with its balls moved by a step.
fn moved(medial: &MedialSurface, steps: &[DVec4]) -> MedialSurface {
    let mut trial = medial.clone();
    for (ball, &step) in trial.balls_mut().iter_mut().zip(steps) {
        *ball = ball.stepped(step);
    }
    trial
}

/// Computes the move and growth of each ball.
fn traveled(from: &MedialSurface, to: &MedialSurface) -> Vec<f64> {
    let balls = from.balls().iter().zip(to.balls());
    balls.map(|(a, b)| a.center.distance(b.center) + (a.radius - b.radius).abs()).collect()
}

fn cost(residuals: &[Residual]) -> f64 {
    residuals.iter().map(|r| r.importance * r.value * r.value).sum()
}
