//! Search for the first time at which no direction separates.
//!
//! Where the cubic is zero for long (coplanar motion, parallel edges), grazes,
//! or stands for a separation, time is crossed in pieces. From each time the
//! direction to the closest point is kept for as long as it separates
//! (directional conservative advancement). Where that is short because the
//! direction turns, a longer piece is tried with the direction of its middle,
//! quartered until it holds, and so is the plane by itself: bisection, with
//! both certificates.
//!
//! Source for the advancement: B. Mirtich, "Impulse-based dynamic simulation of
//! rigid body systems", doctoral thesis, 1996, section 2.3.2. Here the step is the
//! closed form for linear motion along one direction, rounded down and checked.

use crate::coplanarity::margin_during;
use crate::polygon::{Corners, MovingPolygon, Shape};
use crate::search::Search;

/// A step this short is no step: times in `0..=1` are no finer than half of it.
const LEAST_STEP: f64 = 4.0e-16;

/// A direction that holds for less than this share of the piece that was last
/// possible is taken to be turning.
const SLOW: f64 = 0.25;

/// A direction that holds for this share of the time until the closest point
/// would be at the separation is good enough; below it, corners turn faster
/// than that point moves, and the direction at that time is tried as well.
const FULL: f64 = 0.9;

/// How far beyond the separation is near enough, relative to it, where it is
/// not known whether the separation is reached: a contact may be reported that
/// is this much too far away.
const OPEN_SLACK: f64 = 1e-10;

/// The same where it is known: the time of contact may be early by what it
/// takes to cover this much of the separation. The last digits would cost as
/// much as all before.
const CERTAIN_SLACK: f64 = 1e-6;

/// Directions in a row that may turn before a longer piece is tried: a
/// contact at a separation is approached in fewer, each closer by a power.
const PATIENCE: u32 = 4;

/// The time to search: what is left of an interval, and of the work allowed.
struct Remaining {
    t: f64,
    hi: f64,
    /// Length of the piece to try next.
    piece: f64,
    directions: u32,
}

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
        let directions = self.params.max_directions;
        let mut time = Remaining { t: lo, hi, piece: hi - lo, directions };
        let mut turning = 0;
        while time.directions > 0 {
            time.directions -= 1;
            let from = time.t;
            let Some(until) = self.clear_along_closest(polygon, [from, hi], near) else {
                return Some(from);
            };
            time.t = until;
            turning += u32::from(until - from < SLOW * time.piece);
            if turning > PATIENCE || until - from < LEAST_STEP {
                self.leap(polygon, &mut time);
            }
            if time.t >= hi {
                return None;
            }
            if time.t - from < LEAST_STEP {
                return Some(time.t);
            }
        }
        Some(time.t)
    }

    /// The time up to which a direction holds from `t` on: that to the closest
    /// point, now or when it is expected to be at the separation. `None` where
    /// that is now, within the distance `near`, and where none holds even at `t`.
    fn clear_along_closest(
        &self,
        polygon: &MovingPolygon<'_, N>,
        [t, hi]: [f64; 2],
        near: f64,
    ) -> Option<f64> {
        let closest = polygon.closest(t);
        let squared = closest.point.length_squared();
        if squared <= near * near {
            return None;
        }
        let now = polygon.clear_until(closest.point, t, hi, self.separation)?;
        // Distance over speed, of the closest point as it is.
        let approach = -closest.point.dot(polygon.velocity(closest.weights));
        let meeting = t + (squared - self.separation * squared.sqrt()) / approach;
        let falls_short = now < hi && now < t + FULL * (meeting - t);
        if !falls_short {
            return Some(now);
        }
        let ahead = polygon.closest(meeting.min(hi)).point;
        let then = polygon.clear_until(ahead, t, hi, self.separation).unwrap_or(t);
        Some(now.max(then))
    }

    /// Crosses pieces with the direction of their middles, or by the cubic, for
    /// as long as that goes.
    fn leap(&self, polygon: &MovingPolygon<'_, N>, time: &mut Remaining) {
        while time.directions > 0 && time.t < time.hi && time.piece >= LEAST_STEP {
            time.directions -= 1;
            let until = time.hi.min(time.t + time.piece);
            let direction = polygon.closest(0.5 * (time.t + until)).point;
            if !(self.plane_separates(time.t, until)
                || polygon.direction_separates(direction, time.t, until, self.separation))
            {
                time.piece *= 0.25;
                return;
            }
            time.t = until;
            time.piece *= 2.0;
        }
    }

    /// Cubic certificate on a piece: whether the polygon's plane keeps away, which
    /// follows a face as it turns.
    fn plane_separates(&self, lo: f64, hi: f64) -> bool {
        let margin = match self.separation {
            d if d > 0.0 => margin_during(self.outline, lo, hi, d),
            _ => 0.0,
        };
        self.cubic.excludes_zero_on(lo, hi, margin)
    }
}
