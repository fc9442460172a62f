//! A ball's neighbor in its place, moved to where the surface misses the ball the
//! least.
//!
//! All primitives at either of the two then are at the neighbor alone. How far it
//! should move is a small fit of its own: of one ball, to the samples whose foot was
//! at one of them, while all other balls stay.

use std::collections::BTreeSet;

use glam::{DVec3, DVec4};

use super::quadric::{outer, solve};
use super::refit::MIN_DAMPING;
use super::thin::{Places, Thinning};
use crate::{Ball, Foot, FootRule, foot, real};

/// Samples that are looked at, up to twice as many. With a third of them, the fit follows
/// what it sees and misses the rest: 400 balls are off by a twentieth more.
const LOOKED_AT: usize = 150;

/// Steps of the fit.
const STEPS: u32 = 3;

/// What is to stand in for a ball and one of its neighbors.
pub(super) struct Replacement<'a> {
    thinning: &'a Thinning<'a>,
    neighbor: u32,
    /// Primitives that move with the neighbor.
    moving: Vec<[u32; 3]>,
    seen: Vec<Seen>,
    /// Samples for each that is looked at.
    every: usize,
}

/// A sample that was at one of the two.
struct Seen {
    point: DVec3,
    importance: f64,
    /// Its distance from the union, and from what is near it and stays, if anything is.
    before: f64,
    staying: f64,
}

/// Where the neighbor could be, and what that adds to the squares of the errors.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub(super) ball: Ball,
    pub(super) cost: f64,
}

impl<'a> Replacement<'a> {
    pub(super) fn new(
        thinning: &'a Thinning<'a>,
        places: &Places,
        [ball, neighbor]: [u32; 2],
    ) -> Self {
        let at_either = [ball, neighbor].map(|b| &places.at_ball[b as usize]);
        let at_either: BTreeSet<u32> = at_either.into_iter().flatten().copied().collect();
        let primitives = at_either.iter().map(|&p| thinning.medial.primitives()[p as usize]);
        let left = primitives.filter(|balls| !(balls.contains(&ball) && balls.contains(&neighbor)));
        let mut moving: Vec<[u32; 3]> =
            left.map(|balls| balls.map(|b| if b == ball { neighbor } else { b })).collect();
        if moving.is_empty() {
            moving.push([neighbor; 3]);
        }
        let samples = at_either.iter().flat_map(|&p| &places.samples[p as usize]);
        let every = (samples.clone().count() / LOOKED_AT).max(1);
        let stays = |primitive: &&u32| !at_either.contains(primitive);
        let seen = samples.step_by(every).map(|&s| Seen::new(thinning, s, stays)).collect();
        Self { thinning, neighbor, moving, seen, every }
    }

    /// The neighbor where it is missed the least.
    pub(super) fn fitted(&self) -> Placed {
        let start = self.thinning.medial.balls()[self.neighbor as usize];
        let (mut best, mut step) = self.at(start);
        for _ in 0..STEPS {
            let Some(by) = step else { break };
            let moved =
                Ball::new(best.ball.center + by.truncate(), (best.ball.radius + by.w).max(0.0));
            let (found, next) = self.at(moved);
            if found.cost >= best.cost {
                break;
            }
            (best, step) = (found, next);
        }
        best
    }

    /// The squares with the neighbor at `place`, and the step from there that would
    /// make them the least if feet stayed where they are.
    fn at(&self, place: Ball) -> (Placed, Option<DVec4>) {
        let primitives: Vec<[Ball; 3]> =
            self.moving.iter().map(|&b| self.balls(b, place)).collect();
        let (mut matrix, mut right_side, mut cost) = ([0.0; 10], DVec4::ZERO, 0.0);
        for seen in &self.seen {
            let on_moving = nearest(seen, &primitives);
            let distance = on_moving.map_or(seen.staying, |(_, foot)| foot.distance);
            cost += seen.importance * (distance * distance - seen.before * seen.before);
            if let Some((primitive, foot)) = on_moving {
                let gradient = self.gradient(seen.point, self.moving[primitive], &foot);
                let square = outer(gradient);
                matrix.iter_mut().zip(square).for_each(|(sum, s)| *sum += seen.importance * s);
                right_side -= seen.importance * distance * gradient;
            }
        }
        for k in [0, 4, 7, 9] {
            matrix[k] *= 1.0 + MIN_DAMPING;
        }
        let cost = cost * real(self.every);
        (Placed { ball: place, cost }, solve(&matrix, right_side))
    }

    fn balls(&self, primitive: [u32; 3], place: Ball) -> [Ball; 3] {
        let at =
            |b| if b == self.neighbor { place } else { self.thinning.medial.balls()[b as usize] };
        primitive.map(at)
    }

    /// How a sample's distance changes with the neighbor's center and radius.
    fn gradient(&self, p: DVec3, primitive: [u32; 3], foot: &Foot) -> DVec4 {
        let weights = primitive.iter().zip(foot.weights);
        let weight: f64 = weights.filter(|(b, _)| **b == self.neighbor).map(|(_, w)| w).sum();
        let outward = foot.normal(p).unwrap_or(DVec3::ZERO);
        weight * (-outward).extend(-1.0)
    }
}

impl Seen {
    fn new(thinning: &Thinning<'_>, sample: u32, stays: impl Fn(&&u32) -> bool) -> Self {
        let near = thinning.tracking.near(sample).iter();
        Self {
            point: thinning.tracking.points()[sample as usize],
            importance: thinning.importance[sample as usize],
            before: thinning.feet[sample as usize].foot.distance,
            staying: thinning.distance(sample, near.filter(stays)),
        }
    }
}

/// The nearest of the primitives, if one is nearer than what stays.
fn nearest(seen: &Seen, primitives: &[[Ball; 3]]) -> Option<(usize, Foot)> {
    let mut best = None;
    let mut limit = seen.staying;
    for (k, balls) in primitives.iter().enumerate() {
        let found = foot(seen.point, balls, FootRule::Exact);
        if found.distance < limit {
            limit = found.distance;
            best = Some((k, found));
        }
    }
    best
}
