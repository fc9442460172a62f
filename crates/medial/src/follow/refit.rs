//! Least-squares refit of single balls to the vertices that touch them.

use glam::{DVec3, DVec4};
use surface::Positions;

use super::{FollowScratch, Links};
use crate::symmetric::{DIAGONAL, Symmetric4};
use crate::{Ball, FootRule, MedialSurface};

/// Normal equations of a ball: the least squares of `e − u·dc − dr` over its change `(dc, dr)`, with
/// e the height of a vertex over the union and u the direction outward there.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BallFit {
    /// `Σ b (u, 1)(u, 1)ᵀ`.
    matrix: Symmetric4,
    /// `Σ b e (u, 1)`.
    right_side: DVec4,
}

/// Share of the weights that holds a center where it was carried, in every direction.
///
/// Below, balls slide along the sheet; above, errors remain that differ between its sides.
const HOLD: f64 = 0.05;

impl BallFit {
    fn add(&mut self, outward: DVec3, error: f64, weight: f64) {
        let direction = outward.extend(1.0);
        self.matrix.add_scaled(weight, &Symmetric4::outer(direction));
        self.right_side += weight * error * direction;
    }

    /// Computes the ball with the smallest errors.
    fn fitted(&self, ball: Ball) -> Ball {
        let mut held = self.matrix;
        let [x, y, z, total] = DIAGONAL;
        for place in [x, y, z] {
            held.0[place] += HOLD * self.matrix.0[total];
        }
        held.solve(self.right_side).map_or(ball, |step| ball.stepped(step))
    }
}

impl Links {
    pub(super) fn refit_balls(
        &self,
        medial: &mut MedialSurface,
        x: Positions<'_>,
        passes: u32,
        FollowScratch { fits, .. }: &mut FollowScratch,
    ) {
        for _ in 0..passes {
            // Each vertex adds its error to the balls of its foot.
            fits.clear();
            fits.resize(medial.balls().len(), BallFit::default());
            for (link, &p) in self.links().iter().zip(x.as_slice()) {
                let foot = medial.foot(p, link.primitive, FootRule::Exact);
                let outward = foot.normal(p).unwrap_or(DVec3::ZERO);
                let balls = medial.primitives()[link.primitive as usize];
                for (ball, weight) in balls.into_iter().zip(foot.weights) {
                    fits[ball as usize].add(outward, foot.distance, weight);
                }
            }

            for (ball, fit) in medial.balls_mut().iter_mut().zip(&*fits) {
                *ball = fit.fitted(*ball);
            }
        }
    }
}
