//! Search for the first time at which no direction separates.
//!
//! Where the cubic is zero for long (coplanar motion, parallel edges), grazes,
//! or stands for a separation, time is crossed in pieces. From each time the
//! direction to the closest point is kept for as long as it separates
//! (directional conservative advancement). Where that is short because the
//! direction turns, a longer piece is tried with the direction of its middle,
//! quartered until it holds: bisection, with the same certificate.
//!
//! Source for the advancement: B. Mirtich, "Impulse-based dynamic simulation of
//! rigid body systems", doctoral thesis, 1996, section 2.3.2. Here the step is the
//! closed form for linear motion along one direction, rounded down and checked.

use std::ops::Range;

use crate::polygon::{Corners, MovingPolygon, Shape};
use crate::search::Search;

/// A step this short is no step: times in `0..=1` are no finer than half of it.
const LEAST_STEP: f64 = 4.0e-16;

/// A direction that holds for less than this share of the piece that was last
/// possible is taken to be turning.
const SLOW: f64 = 0.25;

/// How far beyond the separation is near enough, relative to it: a contact may
/// be reported up to this much too far away, and the search is spared the last
/// steps of its convergence.
const SEPARATION_SLACK: f64 = 1e-10;

impl<const N: usize> Search<'_, N>
where
    Shape<N>: Corners<N>,
{
    /// The first time from `lo` on at which contact cannot be excluded, or at
    /// which the work allowed is used up; `None` if it can be up to `hi`.
    pub(crate) fn advance(&self, polygon: &MovingPolygon<'_, N>, lo: f64, hi: f64) -> Option<f64> {
        let (mut t, mut piece) = (lo, hi - lo);
        let mut left = self.params.max_directions;
        while left > 0 {
            left -= 1;
            let direction = polygon.closest(t).point;
            if direction.length() <= self.separation * (1.0 + SEPARATION_SLACK) {
                return Some(t);
            }
            let Some(until) = polygon.clear_until(direction, t, hi, self.separation) else {
                return Some(t);
            };
            if until >= hi {
                return None;
            }
            let from = std::mem::replace(&mut t, until);
            if until - from < SLOW * piece {
                t = self.leap(polygon, t..hi, &mut piece, &mut left);
            }
            if t >= hi {
                return None;
            }
            if t - from < LEAST_STEP {
                return Some(t);
            }
        }
        Some(t)
    }

    /// Crosses pieces from `t` on with the direction of their middles, for as
    /// long as that goes.
    fn leap(
        &self,
        polygon: &MovingPolygon<'_, N>,
        time: Range<f64>,
        piece: &mut f64,
        left: &mut u32,
    ) -> f64 {
        let (mut t, hi) = (time.start, time.end);
        while *left > 0 && t < hi && *piece >= LEAST_STEP {
            *left -= 1;
            let until = hi.min(t + *piece);
            let direction = polygon.closest(0.5 * (t + until)).point;
            if polygon.direction_separates(direction, t, until, self.separation) {
                t = until;
                *piece *= 2.0;
            } else {
                *piece *= 0.25;
                return t;
            }
        }
        t
    }
}
