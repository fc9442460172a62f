//! Moving balls so that the union fits the surface best, on both sides of it, and
//! [taking away](super::thin) those that are missed the least in between.
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
use super::thin::Thinning;
use super::tracking::Tracking;
use crate::surface_distance::SurfaceDistance;
use crate::{Ball, MedialError, MedialSurface, NearestPrimitive, real};

/// How a fit is run.
#[derive(Clone, Copy, Debug)]
pub(super) struct RefitParams {
    /// How many are to be left.
    pub(super) balls: usize,
    pub(super) steps: u32,
    pub(super) inscribed_weight: f64,
}

/// Damping of the first step, relative to the diagonal. No step has less. With less,
/// balls slide along flat parts of the sheet until the feet of samples are other ones
/// than the step was solved for, and it has to be tried again; with ten times more the
/// fit creeps.
const LEAST_DAMPING: f64 = 1e-2;

/// Damping at which no step lowers the cost: rounding is reached.
const LAST_DAMPING: f64 = 1e6;

/// Share of the cost whose gain ends the fit: 0.2 % of the cost is 0.1 % of the
/// root mean square error.
const LEAST_GAIN: f64 = 2e-3;

/// Samples for each ball that is to be left, beyond which more hardly improve the
/// fit. With 60 the balls follow the samples, and what is between them is off by a
/// twentieth more.
const SAMPLES_PER_BALL: usize = 160;

/// Samples that are always taken, if the surface has them.
const LEAST_SAMPLES: usize = 5_000;

/// Samples of which one is taken while there still are too many balls, on a surface
/// that has fewer samples than are wanted in the end.
const THINNED_OUT: usize = 2;

/// Accepted steps between searches of all primitives for the feet of samples.
const SEARCH_EVERY: u32 = 4;

/// Steps of the fit between the removal of some balls and of the next.
const STEPS_BETWEEN: u32 = 2;

/// Steps before the first.
const STEPS_BEFORE: u32 = 6;

/// Balls to start from, for `count` to be left: more by three quarters from
/// [`MANY_BALLS`] on and by a lesser share for fewer, which would take long on a large
/// surface; and only as far as the surface has the samples to tell which balls are
/// missed the least. With half as many more, two hundred balls are off by a hundredth
/// more; with twice as many the fit takes half as long again.
pub(super) fn balls_at_first(distance: &SurfaceDistance<'_>, count: usize) -> usize {
    let wanted = SAMPLES_PER_BALL.saturating_mul(count).max(1);
    let more = count.saturating_mul(count.min(MANY_BALLS)) * 3 / (4 * MANY_BALLS);
    count + more.saturating_mul(sample_count(distance).min(wanted)) / wanted
}

/// Numbers from here on start from three quarters more.
const MANY_BALLS: usize = 200;

/// Balls that go at a time. Half as many take twice as long.
fn at_a_time(balls: usize) -> usize {
    10.max(balls / 20)
}

/// Moves and resizes the balls of `medial`, and takes away those that are missed the
/// least until as few are left as asked for; calls `progress` with the share done.
pub(super) fn refit(
    medial: &mut MedialSurface,
    distance: &SurfaceDistance<'_>,
    params: RefitParams,
    mut progress: impl FnMut(f64),
) -> Result<(), MedialError> {
    let wanted = LEAST_SAMPLES.max(SAMPLES_PER_BALL * params.balls);
    let all = sample_count(distance);
    let fewer = if all < wanted { LEAST_SAMPLES.max(all / THINNED_OUT) } else { wanted };
    let at_first = medial.balls().len();
    let mut steps = STEPS_BEFORE;
    progress(0.0);
    while medial.balls().len() > params.balls {
        let left = medial.balls().len() - params.balls;
        progress(0.5 - 0.5 * real(left) / real(at_first - params.balls));
        let fit = settle(medial, distance, params.inscribed_weight, steps, fewer)?;
        let thinning = Thinning {
            medial,
            points: fit.tracking.points(),
            importance: &fit.importance,
            feet: &fit.feet,
        };
        let Some(thinned) = thinning.thinned(left.min(at_a_time(params.balls)))? else { break };
        *medial = thinned;
        steps = STEPS_BETWEEN;
    }
    progress(0.5);
    settle(medial, distance, params.inscribed_weight, params.steps, wanted)?;
    Ok(())
}

/// Moves and resizes the balls in up to so many steps.
fn settle(
    medial: &mut MedialSurface,
    distance: &SurfaceDistance<'_>,
    inscribed_weight: f64,
    steps: u32,
    wanted: usize,
) -> Result<Fit, MedialError> {
    let mut fit = Fit::new(medial, distance, inscribed_weight, wanted)?;
    let primitives = medial.primitives().to_vec();
    let mut equations = NormalEquations::new(medial.balls().len(), &primitives);
    let mut damping = LEAST_DAMPING;
    for _ in 0..steps {
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
    Ok(fit)
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
        inscribed_weight: f64,
        wanted: usize,
    ) -> Result<Self, MedialError> {
        let Samples { points, faces, importance } = Samples::of(distance, wanted);
        let mut tracking = Tracking::new(medial, points)?;
        let feet = tracking.feet(medial, &vec![0.0; medial.balls().len()])?;
        let mut beside = vec![0; medial.primitives().len()];
        for (foot, face) in feet.iter().zip(faces) {
            beside[foot.primitive as usize] = face;
        }
        let of_all = inscribed_weight * real(feet.len());
        let mut inscribed = Inscribed::new(medial, of_all, &beside);
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

fn sample_count(distance: &SurfaceDistance<'_>) -> usize {
    distance.surface.faces().len() + distance.surface.vertex_count()
}

/// Vertices and face centres, thinned out evenly in their order.
struct Samples {
    points: Vec<DVec3>,
    /// A face that each is on.
    faces: Vec<u32>,
    /// Shares of the area, in units of the mean share.
    importance: Vec<f64>,
}

impl Samples {
    /// As many as `wanted`, up to twice; all that there are, if these are fewer.
    fn of(distance: &SurfaceDistance<'_>, wanted: usize) -> Self {
        let faces = distance.surface.faces();
        let mut at_vertices: Vec<(DVec3, u32, f64)> =
            distance.x.as_slice().iter().map(|&p| (p, 0, 0.0)).collect();
        let mut samples = Vec::with_capacity(faces.len() + at_vertices.len());
        for (face, corners) in (0_u32..).zip(faces) {
            let [a, b, c] = distance.corners(face);
            let area = 0.5 * (b - a).cross(c - a).length();
            // Half of a face's area to its centre, half to its corners.
            samples.push(((a + b + c) / 3.0, face, 0.5 * area));
            for &corner in corners {
                let (_, of_vertex, share) = &mut at_vertices[corner as usize];
                *of_vertex = face;
                *share += area / 6.0;
            }
        }
        samples.append(&mut at_vertices);
        let every = (samples.len() / wanted).max(1);
        let mut chosen = Self { points: Vec::new(), faces: Vec::new(), importance: Vec::new() };
        for (point, face, area) in samples.into_iter().step_by(every) {
            chosen.points.push(point);
            chosen.faces.push(face);
            chosen.importance.push(area);
        }
        let mean = chosen.importance.iter().sum::<f64>() / real(chosen.importance.len());
        chosen.importance.iter_mut().for_each(|area| *area /= mean);
        chosen
    }
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
