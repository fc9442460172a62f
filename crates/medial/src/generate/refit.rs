//! Moving balls of fixed connectivity so that the union fits the surface best,
//! on both sides of it.
//!
//! Two kinds of residuals are made small in the least-squares sense by the
//! method of Levenberg and Marquardt:
//!
//! - at samples p of the surface, the signed distance φ(p) of the union. With b
//!   the weights of p's foot and u the unit vector from its centre to p, φ
//!   changes by `−b_k u·dc_k − b_k dr_k` when the balls do: the foot's own shift
//!   does not count, since φ is least there;
//! - at points of the primitives, how far their ball reaches out of the
//!   surface: `max(0, r − D)`, with D the depth of its centre. Samples of the
//!   surface alone do not see a slab that leaves the shape between them.

use glam::DVec3;

use super::inscribed::Inscribed;
use super::normal_equations::{NormalEquations, Residual};
use super::tracking::Tracking;
use crate::surface_distance::SurfaceDistance;
use crate::{Ball, MedialError, MedialSurface, NearestPrimitive, real};

/// How a fit is run.
#[derive(Clone, Copy, Debug)]
pub(super) struct RefitParams {
    pub(super) steps: u32,
    pub(super) inscribed_weight: f64,
}

/// Damping of the first step, relative to the diagonal. No step has less. With less, balls slide along flat parts of the sheet
/// until the feet of samples are other ones than the step was solved for, and it
/// has to be tried again; with ten times more the fit creeps.
const LEAST_DAMPING: f64 = 1e-2;

/// Damping at which no step lowers the cost: rounding is reached.
const LAST_DAMPING: f64 = 1e6;

/// Share of the cost whose gain ends the fit: 0.2 % of the cost is 0.1 % of the
/// root mean square error.
const LEAST_GAIN: f64 = 2e-3;

/// Samples for each ball, beyond which more do not improve the fit but only
/// slow it.
const SAMPLES_PER_BALL: usize = 60;

/// Samples that are always taken, if the surface has them.
const LEAST_SAMPLES: usize = 5_000;

/// Accepted steps between searches of all primitives for the feet of samples.
const SEARCH_EVERY: u32 = 4;

/// Moves and resizes the balls of `medial`; calls `progress` with the share done.
pub(super) fn refit(
    medial: &mut MedialSurface,
    distance: &SurfaceDistance<'_>,
    params: RefitParams,
    mut progress: impl FnMut(f64),
) -> Result<(), MedialError> {
    let mut fit = Fit::new(medial, distance, params)?;
    let primitives = medial.primitives().to_vec();
    let mut equations = NormalEquations::new(medial.balls().len(), &primitives);
    let mut damping = LEAST_DAMPING;
    for step in 0..params.steps {
        progress(f64::from(step) / f64::from(params.steps));
        let residuals = fit.residuals(medial);
        equations.clear();
        residuals.iter().for_each(|residual| equations.add(residual));
        let before = total(&residuals);
        let Some(after) = fit.step(medial, &equations, before, &mut damping)? else { break };
        if before - after < LEAST_GAIN * before {
            break;
        }
        fit.search(medial, distance)?;
    }
    Ok(())
}

/// What the residuals are taken at.
struct Fit {
    tracking: Tracking,
    feet: Vec<NearestPrimitive>,
    /// Importance of each tracked sample: its share of the area, in units of
    /// the mean share.
    importance: Vec<f64>,
    inscribed: Inscribed,
    searches: u32,
}

impl Fit {
    fn new(
        medial: &MedialSurface,
        distance: &SurfaceDistance<'_>,
        params: RefitParams,
    ) -> Result<Self, MedialError> {
        let (points, importance) = samples(distance, medial.balls().len());
        let mut tracking = Tracking::new(medial, points)?;
        let feet = tracking.feet(medial, &vec![0.0; medial.balls().len()])?;
        let mut inscribed = Inscribed::new(medial, params.inscribed_weight * real(feet.len()));
        inscribed.search(medial, distance);
        Ok(Self { tracking, feet, importance, inscribed, searches: 0 })
    }

    /// Searches anew for what touches what, after a step.
    fn search(
        &mut self,
        medial: &MedialSurface,
        distance: &SurfaceDistance<'_>,
    ) -> Result<(), MedialError> {
        self.searches += 1;
        if self.searches.is_multiple_of(SEARCH_EVERY) {
            self.tracking.search(medial)?;
        }
        self.inscribed.search(medial, distance);
        Ok(())
    }

    /// Tries steps of growing damping until one lowers the cost; moves `medial`
    /// and returns the cost there. `None` where no step does.
    ///
    /// The balls are compared with the surface points that last entered them,
    /// not with new ones: those are searched for once a step, not once a try.
    fn step(
        &mut self,
        medial: &mut MedialSurface,
        equations: &NormalEquations<'_>,
        cost: f64,
        damping: &mut f64,
    ) -> Result<Option<f64>, MedialError> {
        while *damping <= LAST_DAMPING {
            let trial = moved(medial, &equations.solve(*damping));
            let travelled = travelled(medial, &trial);
            let feet = std::mem::take(&mut self.feet);
            self.feet = self.tracking.feet(&trial, &travelled)?;
            let found = total(&self.residuals(&trial));
            if found < cost {
                self.tracking.moved(&travelled);
                *medial = trial;
                *damping = (*damping * 0.2).max(LEAST_DAMPING);
                return Ok(Some(found));
            }
            self.feet = feet;
            *damping *= 8.0;
        }
        Ok(None)
    }

    /// One residual a sample, in their order, then those of balls reaching out.
    fn residuals(&self, medial: &MedialSurface) -> Vec<Residual> {
        let points = self.tracking.points().iter().zip(&self.importance);
        let samples = self.feet.iter().zip(points).map(|(foot, (&p, &w))| at_sample(foot, p, w));
        samples.chain(self.inscribed.residuals(medial)).collect()
    }
}

fn moved(medial: &MedialSurface, step: &[glam::DVec4]) -> MedialSurface {
    let mut trial = medial.clone();
    for (ball, step) in trial.balls_mut().iter_mut().zip(step) {
        *ball = Ball::new(ball.center + step.truncate(), (ball.radius + step.w).max(0.0));
    }
    trial
}

/// How far each ball moved and grew.
fn travelled(from: &MedialSurface, to: &MedialSurface) -> Vec<f64> {
    let balls = from.balls().iter().zip(to.balls());
    balls.map(|(a, b)| a.center.distance(b.center) + (a.radius - b.radius).abs()).collect()
}

fn total(residuals: &[Residual]) -> f64 {
    residuals.iter().map(|r| r.importance * r.value * r.value).sum()
}

/// Vertices and face centres, thinned out evenly in their order, with shares
/// of the area in units of the mean share.
fn samples(distance: &SurfaceDistance<'_>, balls: usize) -> (Vec<DVec3>, Vec<f64>) {
    let faces = distance.surface.faces();
    let mut vertex_area = vec![0.0; distance.surface.vertex_count()];
    let mut samples = Vec::with_capacity(faces.len() + vertex_area.len());
    for (face, corners) in (0_u32..).zip(faces) {
        let [a, b, c] = distance.corners(face);
        let area = 0.5 * (b - a).cross(c - a).length();
        // Half of a face's area to its centre, half to its corners.
        samples.push(((a + b + c) / 3.0, 0.5 * area));
        for &corner in corners {
            vertex_area[corner as usize] += area / 6.0;
        }
    }
    samples.extend(distance.x.as_slice().iter().copied().zip(vertex_area));
    let wanted = LEAST_SAMPLES.max(SAMPLES_PER_BALL * balls);
    let every = (samples.len() / wanted).max(1);
    let (points, areas): (Vec<DVec3>, Vec<f64>) = samples.into_iter().step_by(every).unzip();
    let mean = areas.iter().sum::<f64>() / real(areas.len());
    (points, areas.into_iter().map(|area| area / mean).collect())
}

fn at_sample(nearest: &NearestPrimitive, p: DVec3, importance: f64) -> Residual {
    let outward = nearest.foot.normal(p).unwrap_or(DVec3::ZERO);
    Residual {
        primitive: nearest.primitive,
        weights: nearest.foot.weights,
        gradient: (-outward).extend(-1.0),
        value: nearest.foot.distance,
        importance,
    }
}
