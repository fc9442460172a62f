//! Moving balls so that the union fits the surface best, on both sides of it, and
//! [taking away](super::thin) those that are missed the least in between. Of many, some
//! are then [added](super::split) where the surface is missed the most, and as many go.
//!
//! Two kinds of residuals are made small in the least-squares sense by the
//! method of Levenberg and Marquardt:
//!
//! - at samples p of the surface, the signed distance φ(p) of the union. With b
//!   the weights of p's foot and u the unit vector from its center to p, φ
//!   changes by `−b_k u·dc_k − b_k dr_k` when the balls do: the foot's own shift
//!   does not count, since φ is least there;
//! - at points of the primitives, how far their ball reaches out of the
//!   surface: `max(0, r − D)`, with D the depth of its center. Samples of the
//!   surface alone do not see a slab that leaves the shape between them.

use glam::DVec3;

use super::inscribed::Inscribed;
use super::normal_equations::{NormalEquations, Residual};
use super::split::split;
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
pub(super) const MIN_DAMPING: f64 = 1e-2;

/// Damping at which no step lowers the cost: rounding is reached.
const LAST_DAMPING: f64 = 1e6;

/// Share of the cost whose gain ends the fit, of up to [`MANY_BALLS`] and of more: 0.2 %
/// of the cost is 0.1 % of the root mean square error.
const MIN_GAINS: [f64; 2] = [2e-3, 2e-4];

/// Samples for each ball that is to be left, beyond which more hardly improve the
/// fit. With 60 the balls follow the samples, and what is between them is off by a
/// twentieth more.
const SAMPLES_PER_BALL: usize = 160;

/// Samples that are always taken, if the surface has them.
const MIN_SAMPLES: usize = 5_000;

/// Samples of which one is taken while there still are too many balls, where up to
/// [`MANY_BALLS`] are to be left on a surface that has fewer samples than are wanted in
/// the end. More balls than that are off by a hundredth less if all are taken.
const THINNED_OUT: usize = 2;

/// Accepted steps between searches of all primitives for the feet of samples.
const SEARCH_EVERY: u32 = 4;

/// Steps of the fit between the removal of some balls and of the next, of up to
/// [`MANY_BALLS`] and of more: after a careful removal, a second one is of little use.
const STEPS_BETWEEN: [u32; 2] = [2, 1];

/// Steps before the first.
const STEPS_BEFORE: u32 = 6;

/// Balls to start from, for `count` to be left: more by three quarters at
/// [`MANY_BALLS`], up to twice as many for more, and by a lesser share for fewer, which
/// would take long on a large surface; and only as far as the surface has the samples to
/// tell which balls are missed the least.
pub(super) fn balls_at_first(distance: &SurfaceDistance<'_>, count: usize) -> usize {
    let wanted = SAMPLES_PER_BALL.saturating_mul(count).max(1);
    let share = count.saturating_mul(3).min(4 * MANY_BALLS);
    let more = count.saturating_mul(share) / (4 * MANY_BALLS);
    count + more.saturating_mul(sample_count(distance).min(wanted)) / wanted
}

/// Balls of which two hundred and fewer are found quickly; more are worth more time.
const MANY_BALLS: usize = 200;

/// Rounds in which as many balls as go at a time are added where the surface is missed
/// the most, and as many go, if there are more than [`MANY_BALLS`]. All together take
/// about a hundredth off the error.
const EXCHANGES: u32 = 10;

/// Balls that go at a time. Half as many take twice as long.
fn at_a_time(balls: usize) -> usize {
    10.max(balls / 20)
}

impl RefitParams {
    fn are_many(&self) -> bool {
        self.balls > MANY_BALLS
    }

    /// What balls that reach out count for. Slabs between many balls are small, and
    /// leave the shape by little between samples.
    fn importance_of_reach(&self) -> f64 {
        self.inscribed_weight * (real(MANY_BALLS) / real(self.balls)).min(1.0).powi(3)
    }

    fn least_gain(&self) -> f64 {
        MIN_GAINS[usize::from(self.are_many())]
    }

    fn steps_between(&self) -> u32 {
        STEPS_BETWEEN[usize::from(self.are_many())]
    }

    /// Samples for the last fit.
    fn samples(&self) -> usize {
        MIN_SAMPLES.max(SAMPLES_PER_BALL * self.balls)
    }

    /// Samples while there still are too many balls, of this many that the surface has.
    fn samples_before(&self, all: usize) -> usize {
        if all < self.samples() && !self.are_many() {
            MIN_SAMPLES.max(all / THINNED_OUT)
        } else {
            self.samples()
        }
    }
}

/// Moves and resizes the balls of `medial`, and takes away those that are missed the
/// least until as few are left as asked for; calls `progress` with the share done.
pub(super) fn refit(
    medial: &mut MedialSurface,
    distance: &SurfaceDistance<'_>,
    params: RefitParams,
    mut progress: impl FnMut(f64),
) -> Result<(), MedialError> {
    progress(0.0);
    let at_first = medial.balls().len();
    let done = |left: usize| 0.5 - 0.5 * real(left) / real(at_first - params.balls);
    thin_out(medial, distance, params, STEPS_BEFORE, |left| progress(done(left)))?;
    let all_went = medial.balls().len() == params.balls;
    let rounds = if all_went && params.are_many() { EXCHANGES } else { 0 };
    for round in 0..rounds {
        progress(0.5 + 0.25 * f64::from(round) / f64::from(rounds));
        let samples = params.samples_before(sample_count(distance));
        let fit = settle(medial, distance, params, params.steps_between(), samples)?;
        *medial = split(medial, &fit.squares(medial), at_a_time(params.balls))?;
        thin_out(medial, distance, params, params.steps_between(), |_| {})?;
    }
    progress(0.75);
    settle(medial, distance, params, params.steps, params.samples())?;
    Ok(())
}

/// Fits the balls, in so many steps at first, and takes away those that are missed the
/// least, until as few are left as asked for or none can go; tells how many are still to
/// go.
fn thin_out(
    medial: &mut MedialSurface,
    distance: &SurfaceDistance<'_>,
    params: RefitParams,
    mut steps: u32,
    mut tell: impl FnMut(usize),
) -> Result<(), MedialError> {
    let samples = params.samples_before(sample_count(distance));
    while medial.balls().len() > params.balls {
        let left = medial.balls().len() - params.balls;
        tell(left);
        let fit = settle(medial, distance, params, steps, samples)?;
        let thinning = Thinning {
            medial,
            tracking: &fit.tracking,
            importance: &fit.importance,
            feet: &fit.feet,
            careful: params.are_many(),
        };
        let Some(thinned) = thinning.thinned(left.min(at_a_time(params.balls)))? else { break };
        *medial = thinned;
        steps = params.steps_between();
    }
    Ok(())
}

/// Moves and resizes the balls in up to so many steps, to up to so many samples.
fn settle(
    medial: &mut MedialSurface,
    distance: &SurfaceDistance<'_>,
    params: RefitParams,
    steps: u32,
    samples: usize,
) -> Result<Fit, MedialError> {
    let mut fit = Fit::new(medial, distance, params.importance_of_reach(), samples)?;
    let primitives = medial.primitives().to_vec();
    let mut equations = NormalEquations::new(medial.balls().len(), &primitives);
    let mut damping = MIN_DAMPING;
    for _ in 0..steps {
        let residuals = fit.residuals(medial);
        equations.clear();
        residuals.iter().for_each(|residual| equations.add(residual));
        let before = total(&residuals);
        let Some(after) = fit.step(medial, &equations, before, &mut damping)? else { break };
        if before - after < params.least_gain() * before {
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
        importance_of_reach: f64,
        wanted: usize,
    ) -> Result<Self, MedialError> {
        let Samples { points, faces, importance } = Samples::of(distance, wanted);
        let mut tracking = Tracking::new(medial, points)?;
        let feet = tracking.feet(medial, &vec![0.0; medial.balls().len()])?;
        let mut beside = vec![0; medial.primitives().len()];
        for (foot, face) in feet.iter().zip(faces) {
            beside[foot.primitive as usize] = face;
        }
        let of_all = importance_of_reach * real(feet.len());
        let mut inscribed = Inscribed::new(medial, of_all, &beside);
        inscribed.search(medial, distance);
        Ok(Self { tracking, feet, importance, inscribed, searches: 0 })
    }

    /// Squares of the samples' distances, by the primitives they are nearest to.
    fn squares(&self, medial: &MedialSurface) -> Vec<f64> {
        let mut squares = vec![0.0; medial.primitives().len()];
        for (nearest, importance) in self.feet.iter().zip(&self.importance) {
            squares[nearest.primitive as usize] += importance * nearest.foot.distance.powi(2);
        }
        squares
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
                *damping = (*damping * 0.2).max(MIN_DAMPING);
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

/// Vertices and face centers, thinned out evenly in their order.
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
            // Half of a face's area to its center, half to its corners.
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
