//! Directional conservative advancement: the first time at which no direction separates.
//!
//! Where the cubic is zero for long (coplanar motion, parallel edges), grazes zero, or stands for a
//! separation, time is crossed in pieces. A piece ends where the closest point is expected at the
//! separation. Within it, the direction to the closest point is followed as it turns, for as long
//! as it separates. A direction that is right at both ends of a piece and changes linearly between
//! them loses an amount that falls with the square of the piece. So a contact is approached as by
//! Newton's method, and few pieces pass where a separation is nearly reached.
//!
//! Source: B. Mirtich, "Impulse-based dynamic simulation of rigid body systems", doctoral thesis,
//! 1996, section 2.3.2 (conservative advancement). Differs in that directions turn, and in the
//! step, which is the closed form for linear motion along one, rounded down and certified.

use crate::closest::ClosestToOrigin;
use crate::polygon::{MovingPolygon, TurningDirection};
use crate::scalar::{fast_max, fast_min};
use crate::search::{ContactSearch, OPEN_SLACK};
use crate::shape::{Corners, PolygonShape};

/// Shortest step: times in `0..=1` are no finer than half of it.
const MIN_STEP: f64 = 4.0e-16;

/// Share of a piece below which a direction is considered to turn faster than the closest point
/// did; the next piece is shortened by it.
const SLOW: f64 = 0.25;

/// Maximum number of directions in an interval that exact arithmetic decides if they do not: it
/// takes about as long as a few hundred.
const MAX_DIRECTIONS_BEFORE_EXACT: u32 = 64;

impl<const N: usize> ContactSearch<'_, N>
where
    PolygonShape<N>: Corners<N>,
{
    /// Finds the first time in `lo..=hi` at which contact cannot be excluded, or at which all
    /// directions are used up, and the closest point then; `None` if contact is excluded up to `hi`.
    ///
    /// `is_certain` states that there is a contact.
    pub(crate) fn advance(
        &self,
        polygon: &MovingPolygon<'_, N>,
        lo: f64,
        hi: f64,
        is_certain: bool,
    ) -> Option<(f64, ClosestToOrigin<N>)> {
        let slack = if is_certain { self.certain_slack } else { OPEN_SLACK };
        let near = self.separation * (1.0 + slack);
        let (mut t, mut piece) = (lo, hi - lo);
        let mut from = polygon.closest(t);
        let mut is_weighted = false;
        for _ in 0..self.max_directions() {
            if piece < MIN_STEP {
                break;
            }

            // Certify the direction to the closest point up to where it is expected to be near.
            let certified = if from.point.length_squared() > near * near {
                let expected = self.time_until_near(polygon, &from);
                let until = fast_min(hi, t + fast_min(piece, fast_max(expected, MIN_STEP)));
                let to = hint(polygon, until, is_weighted);
                let direction = TurningDirection { start: from.point, end: to.point };
                let clear = polygon.clear_until(direction, t, until, self.separation);
                clear.map(|clear| (clear, until, to))
            } else {
                None
            };

            // A point that is near, or whose direction does not hold, may be one of noise.
            let Some((clear, until, to)) = certified else {
                let weighted = polygon.weighted(from, t);
                if is_weighted || weighted.hint == from.point {
                    return Some((t, weighted.closest));
                }
                (from, is_weighted) = (weighted.into_hint(), true);
                continue;
            };
            if clear >= hi {
                return None;
            }

            // Lengthen the next piece where the direction held, else shorten it.
            let is_slow = clear - t < SLOW * (until - t);
            piece = (until - t) * if is_slow { SLOW } else { 2.0 };
            from = if clear < until { hint(polygon, clear, is_weighted) } else { to };
            t = clear;
        }
        Some((t, polygon.weighted(from, t).closest))
    }

    fn max_directions(&self) -> u32 {
        let max = if self.is_decided_exactly() { MAX_DIRECTIONS_BEFORE_EXACT } else { u32::MAX };
        self.params.max_directions.min(max)
    }

    /// Estimates how long the closest point takes to come within the separation at its present
    /// velocity; infinite if it recedes.
    fn time_until_near(&self, polygon: &MovingPolygon<'_, N>, closest: &ClosestToOrigin<N>) -> f64 {
        let squared = closest.point.length_squared();
        let approach = -closest.point.dot(polygon.velocity(closest.weights));
        let time = (squared - self.separation * squared.sqrt()) / approach;
        if time > 0.0 { time } else { f64::INFINITY }
    }
}

/// Finds a point whose direction is to be certified at time `t`: the closest one or, `is_weighted`,
/// one that certainly is of the polygon.
#[inline]
fn hint<const N: usize>(
    polygon: &MovingPolygon<'_, N>,
    t: f64,
    is_weighted: bool,
) -> ClosestToOrigin<N>
where
    PolygonShape<N>: Corners<N>,
{
    if is_weighted { polygon.weighted_closest(t).into_hint() } else { polygon.closest(t) }
}
