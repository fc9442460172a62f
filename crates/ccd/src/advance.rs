//! Search for the first time at which no direction separates.
//!
//! Where the cubic is zero for long (coplanar motion, parallel edges), grazes,
//! or stands for a separation, time is crossed in pieces. From each time to
//! that at which the closest point is expected to be at the separation, the
//! direction to the closest point is followed as it turns, for as long as it
//! separates (directional conservative advancement). What a direction loses
//! that goes straight between two that are right falls with the square of the
//! piece: a contact is approached as by Newton's method, and few pieces pass
//! where a separation is nearly reached.
//!
//! Source for the advancement: B. Mirtich, "Impulse-based dynamic simulation of
//! rigid body systems", doctoral thesis, 1996, section 2.3.2. Here directions
//! turn, and the step is the closed form for linear motion along one, rounded
//! down and checked.

use crate::closest::Closest;
use crate::polygon::{Corners, MovingPolygon, Shape, larger, smaller};
use crate::search::Search;

/// A step this short is no step: times in `0..=1` are no finer than half of it.
const LEAST_STEP: f64 = 4.0e-16;

/// A direction that ceases to separate before this share of a piece turns
/// otherwise than straight: the next piece is shortened by it.
const SLOW: f64 = 0.25;

/// How far beyond the separation is near enough, relative to it, where it is
/// not known whether the separation is reached: a contact may be reported that
/// is this much too far away.
const OPEN_SLACK: f64 = 1e-10;

/// The same where it is known: the time of contact may be early by what it
/// takes to cover this much of the separation. The last digits would cost as
/// much as all before.
const CERTAIN_SLACK: f64 = 1e-6;

/// Directions in an interval that exact arithmetic decides if they do not: it
/// takes about as long as a few hundred.
#[cfg(feature = "exact")]
const MOST_BEFORE_EXACT: u32 = 64;

impl<const N: usize> Search<'_, N>
where
    Shape<N>: Corners<N>,
{
    /// The first time from `lo` on at which contact cannot be excluded, or at
    /// which the work allowed is used up; `None` if it can be up to `hi`.
    ///
    /// `is_certain` says whether there is known to be a contact.
    pub(crate) fn advance(
        &self,
        polygon: &MovingPolygon<'_, N>,
        [lo, hi]: [f64; 2],
        is_certain: bool,
    ) -> Option<f64> {
        let slack = if is_certain { CERTAIN_SLACK } else { OPEN_SLACK };
        let near = self.separation * (1.0 + slack);
        let (mut t, mut piece) = (lo, hi - lo);
        let mut from = polygon.closest(t);
        for _ in 0..self.most_directions() {
            if from.point.length_squared() <= near * near || piece < LEAST_STEP {
                return Some(t);
            }
            let expected = self.time_until_near(polygon, &from);
            let until = smaller(hi, t + smaller(piece, larger(expected, LEAST_STEP)));
            let to = polygon.closest(until);
            let directions = [from.point, to.point];
            let Some(clear) = polygon.clear_until(directions, [t, until], self.separation) else {
                return Some(t);
            };
            if clear >= hi {
                return None;
            }
            let is_slow = clear - t < SLOW * (until - t);
            piece = (until - t) * if is_slow { SLOW } else { 2.0 };
            from = if clear < until { polygon.closest(clear) } else { to };
            t = clear;
        }
        Some(t)
    }

    #[cfg(not(feature = "exact"))]
    fn most_directions(&self) -> u32 {
        self.params.max_directions
    }

    #[cfg(feature = "exact")]
    fn most_directions(&self) -> u32 {
        let most = if self.is_decided_exactly() { MOST_BEFORE_EXACT } else { u32::MAX };
        self.params.max_directions.min(most)
    }

    /// How long the closest point takes to come within the separation if it
    /// goes on as it does; infinite if it recedes.
    fn time_until_near(&self, polygon: &MovingPolygon<'_, N>, closest: &Closest<N>) -> f64 {
        let squared = closest.point.length_squared();
        let approach = -closest.point.dot(polygon.velocity(closest.weights));
        let time = (squared - self.separation * squared.sqrt()) / approach;
        if time > 0.0 { time } else { f64::INFINITY }
    }
}
