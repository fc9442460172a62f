//! Best place of a neighbor that takes the place of a ball.
//!
//! All primitives at either of the two are then at the neighbor alone. Its place is a small fit of its
//! own: of one ball, to the samples whose foot was at one of the two, while all other balls stay.

use std::collections::BTreeSet;

use glam::{DVec3, DVec4};

use super::normal_equations::MIN_DAMPING;
use super::sample_map::FittedSurface;
use crate::symmetric::{DIAGONAL, Symmetric4};
use crate::{Ball, Foot, FootRule, foot, real};

/// Number of samples of the fit, up to twice as many.
///
/// With a third of them, the fit follows these and leaves the rest: the error of 400 balls is a
/// twentieth larger.
const MAX_SAMPLES: usize = 150;

/// Number of steps of the fit.
const STEPS: u32 = 3;

/// Neighbor that stands for a ball and itself.
pub(super) struct Replacement<'a> {
    fitted: &'a FittedSurface<'a>,
    neighbor: u32,
    /// Primitives that move with the neighbor.
    moving: Vec<[u32; 3]>,
    samples: Vec<NearSample>,
    /// Interval at which samples were taken.
    interval: usize,
}

/// Sample whose foot was at one of the two balls.
struct NearSample {
    point: DVec3,
    importance: f64,
    /// Its distance from the union.
    before: f64,
    /// Its distance from the primitives near it that stay; infinite without one.
    staying: f64,
}

/// Place of the neighbor, with the increase of the squares of the errors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) ball: Ball,
    pub(super) cost: f64,
}

/// Place of the neighbor, with the step to the minimum for constant feet; `None` where it is not
/// defined.
struct Linearized {
    placed: Placed,
    step: Option<DVec4>,
}

impl<'a> Replacement<'a> {
    /// Prepares the fit of a neighbor that takes the place of a ball.
    pub(super) fn new(fitted: &'a FittedSurface<'a>, ball: u32, neighbor: u32) -> Self {
        let of_balls = [ball, neighbor].map(|b| &fitted.at_ball[b as usize]);
        let at_either: BTreeSet<u32> = of_balls.into_iter().flatten().copied().collect();

        // Primitives of both vanish.
        let mut moving = Vec::new();
        for &primitive in &at_either {
            let balls = fitted.medial.primitives()[primitive as usize];
            if !(balls.contains(&ball) && balls.contains(&neighbor)) {
                moving.push(balls.map(|b| if b == ball { neighbor } else { b }));
            }
        }
        if moving.is_empty() {
            moving.push([neighbor; 3]);
        }

        // A part of the samples at either is sufficient.
        let mut all: Vec<u32> = Vec::new();
        for &primitive in &at_either {
            all.extend(&fitted.samples[primitive as usize]);
        }
        let interval = (all.len() / MAX_SAMPLES).max(1);
        let mut samples = Vec::with_capacity(all.len() / interval + 1);
        for &sample in all.iter().step_by(interval) {
            samples.push(NearSample::new(fitted, sample, &at_either));
        }
        Self { fitted, neighbor, moving, samples, interval }
    }

    /// Fits the place of the neighbor.
    pub(super) fn fit(&self) -> Placed {
        let start = self.fitted.medial.balls()[self.neighbor as usize];
        let mut best = self.linearize(start);
        for _ in 0..STEPS {
            let Some(step) = best.step else { break };
            let found = self.linearize(best.placed.ball.stepped(step));
            if found.placed.cost >= best.placed.cost {
                break;
            }
            best = found;
        }
        best.placed
    }

    /// Computes the squares with the neighbor at `place`, and the step from there.
    fn linearize(&self, place: Ball) -> Linearized {
        let primitives: Vec<[Ball; 3]> =
            self.moving.iter().map(|&balls| self.balls_at(balls, place)).collect();

        // Normal equations of the samples that are nearest to a primitive that moves.
        let (mut matrix, mut right_side) = (Symmetric4::default(), DVec4::ZERO);
        let mut cost = 0.0;
        for sample in &self.samples {
            let nearest = sample.nearest_of(&primitives);
            let distance = nearest.map_or(sample.staying, |(_, foot)| foot.distance);
            cost += sample.importance * (distance * distance - sample.before * sample.before);
            if let Some((k, foot)) = nearest {
                let gradient = self.gradient(sample.point, self.moving[k], &foot);
                matrix.add_scaled(sample.importance, &Symmetric4::outer(gradient));
                right_side -= sample.importance * distance * gradient;
            }
        }

        // The same damping as in the fit of all balls.
        for place in DIAGONAL {
            matrix.0[place] *= 1.0 + MIN_DAMPING;
        }
        let placed = Placed { ball: place, cost: cost * real(self.interval) };
        Linearized { placed, step: matrix.solve(right_side) }
    }

    /// Returns the balls of a primitive with the neighbor at `place`.
    fn balls_at(&self, primitive: [u32; 3], place: Ball) -> [Ball; 3] {
        let balls = self.fitted.medial.balls();
        primitive.map(|b| if b == self.neighbor { place } else { balls[b as usize] })
    }

    /// Computes the gradient of a sample's distance with respect to the neighbor's center and radius.
    fn gradient(&self, p: DVec3, primitive: [u32; 3], foot: &Foot) -> DVec4 {
        let weights = primitive.iter().zip(foot.weights);
        let weight: f64 = weights.filter(|(b, _)| **b == self.neighbor).map(|(_, w)| w).sum();
        let outward = foot.normal(p).unwrap_or(DVec3::ZERO);
        weight * (-outward).extend(-1.0)
    }
}

impl NearSample {
    fn new(fitted: &FittedSurface<'_>, sample: u32, moving: &BTreeSet<u32>) -> Self {
        let near = fitted.tracking.near(sample).iter();
        let staying = near.filter(|primitive| !moving.contains(primitive));
        Self {
            point: fitted.tracking.points()[sample as usize],
            importance: fitted.importance[sample as usize],
            before: fitted.feet[sample as usize].foot.distance,
            staying: fitted.distance(sample, staying),
        }
    }

    /// Finds the nearest of the primitives, with its place among them, if one is nearer than those
    /// that stay.
    fn nearest_of(&self, primitives: &[[Ball; 3]]) -> Option<(usize, Foot)> {
        let mut best = None;
        let mut limit = self.staying;
        for (k, balls) in primitives.iter().enumerate() {
            let found = foot(self.point, balls, FootRule::Exact);
            if found.distance < limit {
                limit = found.distance;
                best = Some((k, found));
            }
        }
        best
    }
}
