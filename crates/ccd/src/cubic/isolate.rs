//! Isolation of the roots of a cubic whose coefficients carry an error.
//!
//! Intervals are split at critical points until each is free of roots, within
//! the error of zero, or monotone. A monotone one holds a crossing, which a
//! bracketed Newton iteration finds in plain arithmetic; what it finds is a
//! hint. Around it an interval is widened until the *values at its ends* are
//! far enough from zero, and those are evaluated from the given coefficients
//! with a bound.
//!
//! Where computed coefficients of a sub-interval rise, the exact ones fall by
//! at most `2 E` from one to the next, so the exact cubic falls by at most
//! `6 E` within the sub-interval (`E` is the evaluation error). A computed
//! value of `-(margin + 8 E)` is then enough for the exact cubic to have been
//! below `-margin` since the sub-interval's start.

use super::{Cubic, RootInterval, RootKind, beyond};
use crate::polygon::{larger, smaller};

/// Splits from the whole interval down to a part. A cubic has two critical
/// points, so two splits make all parts monotone but for rounding; more are
/// needed where a critical point is too close to an end to split there, and
/// below `2^-DEPTH` of the step nothing would be gained.
const DEPTH: u32 = 24;

/// Values that vouch for a monotone interval are this many errors from zero.
const MONOTONE_SLACK: f64 = 8.0;

/// Parts of an interval at either end in which no split is made: a critical
/// point there would leave a part so short that the next split repeats it.
const LEAST_PART: f64 = 1.0 / 64.0;

/// What `look` finds first in the intervals of [`Cubic::isolate`], in their
/// order. Where an interval lies is not worked out before those ahead of it
/// were looked at.
#[inline]
pub(super) fn find_interval<R>(
    cubic: &Cubic,
    margin: f64,
    look: impl FnMut(&RootInterval) -> Option<R>,
) -> Option<R> {
    let whole = Part { lo: 0.0, hi: 1.0, b: cubic.bernstein };
    let mut isolation = Isolation { cubic, margin, open: None, look };
    if whole.within(cubic.evaluation_error + margin) {
        let everything = RootInterval { lo: 0.0, hi: 1.0, kind: RootKind::Vanishing };
        return (isolation.look)(&everything);
    }
    isolation.narrow(&whole, DEPTH).or_else(|| isolation.close())
}

struct Isolation<'a, F> {
    cubic: &'a Cubic,
    margin: f64,
    /// The last interval, as long as it touches the part that comes next.
    open: Option<RootInterval>,
    look: F,
}

/// A sub-interval and its Bernstein coefficients.
#[derive(Clone, Copy)]
struct Part {
    lo: f64,
    hi: f64,
    b: [f64; 4],
}

impl Part {
    fn within(&self, bound: f64) -> bool {
        self.b.iter().all(|b| b.abs() <= bound)
    }

    /// 1 where coefficients rise, -1 where they fall, 0 where they do neither.
    #[inline]
    fn direction(&self) -> f64 {
        let [b0, b1, b2, b3] = self.b;
        let side = 1.0_f64.copysign(b3 - b0);
        let [d0, d1, d2] = [side * (b1 - b0), side * (b2 - b1), side * (b3 - b2)];
        if smaller(smaller(d0, d1), d2) >= 0.0 { side } else { 0.0 }
    }

    /// A critical point well inside, otherwise the middle, in `0..1` of the part.
    fn split(&self) -> f64 {
        let [b0, b1, b2, b3] = self.b;
        let (d0, d1, d2) = (b1 - b0, b2 - b1, b3 - b2);
        quadratic_roots(d0, 2.0 * (d1 - d0), d0 - 2.0 * d1 + d2)
            .into_iter()
            .find(|t| (LEAST_PART..=1.0 - LEAST_PART).contains(t))
            .unwrap_or(0.5)
    }
}

/// Roots of `c + b t + a t^2`, ascending; NaN or infinite where there is none.
pub(super) fn quadratic_roots(c: f64, b: f64, a: f64) -> [f64; 2] {
    let q = -0.5 * (b + (b * b - 4.0 * a * c).sqrt().copysign(b));
    let (x, y) = (q / a, c / q);
    if x < y { [x, y] } else { [y, x] }
}

impl<R, F: FnMut(&RootInterval) -> Option<R>> Isolation<'_, F> {
    fn visit(&mut self, part: &Part, depth: u32) -> Option<R> {
        let bound = self.cubic.evaluation_error + self.margin;
        if beyond(&part.b, bound) {
            None
        } else if part.within(bound) {
            self.keep(part)
        } else {
            self.narrow(part, depth)
        }
    }

    /// Visits what may be near zero in a part that is not so as a whole.
    #[inline]
    fn narrow(&mut self, part: &Part, depth: u32) -> Option<R> {
        let direction = part.direction();
        if direction != 0.0 { self.bracket(part, direction) } else { self.split(part, depth) }
    }

    /// Keeps all of a part that nothing more can be said about.
    fn keep(&mut self, part: &Part) -> Option<R> {
        self.push(part, RootInterval { lo: part.lo, hi: part.hi, kind: RootKind::Grazing })
    }

    #[inline(never)]
    fn split(&mut self, part: &Part, depth: u32) -> Option<R> {
        let middle = part.lo + part.split() * (part.hi - part.lo);
        if depth == 0 || !(part.lo < middle && middle < part.hi) {
            return self.keep(part);
        }
        [(part.lo, middle), (middle, part.hi)]
            .into_iter()
            .find_map(|(lo, hi)| self.visit(&Part { lo, hi, b: self.cubic.on(lo, hi) }, depth - 1))
    }

    /// Looks at an interval of a part, joined with the last one where they
    /// touch, unless one in the next part may touch it.
    #[inline]
    fn push(&mut self, part: &Part, mut interval: RootInterval) -> Option<R> {
        let mut found = None;
        if let Some(last) = self.open {
            if last.hi >= interval.lo {
                interval = RootInterval { lo: last.lo, kind: RootKind::Grazing, ..interval };
            } else {
                found = (self.look)(&last);
            }
        }
        self.open = Some(interval);
        if found.is_some() || interval.hi >= part.hi { found } else { self.close() }
    }

    /// Looks at the interval that is open.
    #[inline]
    fn close(&mut self) -> Option<R> {
        self.open.take().and_then(|last| (self.look)(&last))
    }

    /// Narrows a monotone part to where it may be within the margin of zero.
    #[inline]
    fn bracket(&mut self, part: &Part, direction: f64) -> Option<R> {
        let far = self.margin + MONOTONE_SLACK * self.cubic.evaluation_error;
        let rising = part.b.map(|b| direction * b);
        let from_below = rising[0] < -far;
        let to_above = rising[3] > far;
        let (before, after) = self.hints(rising, far);
        let lo = if from_below { self.widen(part, before, -far, direction) } else { None };
        let hi = if to_above { self.widen(part, after, far, direction) } else { None };
        let kind = match (lo, hi) {
            (Some(_), Some(_)) if direction > 0.0 => RootKind::Rising,
            (Some(_), Some(_)) => RootKind::Falling,
            _ => RootKind::Grazing,
        };
        let (lo, hi) = (lo.unwrap_or(part.lo), hi.unwrap_or(part.hi));
        // Both ends hold by themselves; crossed ones leave nothing between.
        if lo <= hi { self.push(part, RootInterval { lo, hi, kind }) } else { None }
    }

    /// Where a rising cubic is supposed to be further than `far` from zero, on
    /// either side, if it gets there.
    #[inline]
    fn hints(&self, rising: [f64; 4], far: f64) -> (Hint, Hint) {
        let secant = |value: f64| (value - rising[0]) / (rising[3] - rising[0]);
        if rising[0] >= -far || rising[3] <= far {
            let at = |value: f64| Hint { t: solve(rising, value, secant(value)).t, share: 0.0 };
            return (at(-far), at(far));
        }
        let root = solve(rising, 0.0, secant(0.0));
        let share = far / root.slope;
        let share = if share <= 1.0 { share } else { 0.0 };
        if self.margin == 0.0 {
            let hint = Hint { t: root.t, share: 1.25 * share };
            return (hint, hint);
        }
        let from = |value: f64, start: f64| Hint {
            t: solve(rising, value, start.clamp(0.0, 1.0)).t,
            share: 0.0,
        };
        (from(-far, root.t - share), from(far, root.t + share))
    }

    /// The first point on the side of `target` of a hint at which the cubic is
    /// verified to be beyond it; `None` if there is none within the part.
    #[inline]
    fn widen(&self, part: &Part, hint: Hint, target: f64, direction: f64) -> Option<f64> {
        let length = part.hi - part.lo;
        let root = part.lo + hint.t * length;
        let mut step = (hint.share * length + 2.0 * f64::EPSILON * part.hi).copysign(target);
        for _ in 0..WIDENINGS {
            let t = root + step;
            if !(part.lo < t && t < part.hi) {
                return None;
            }
            let value = direction * self.cubic.value(t);
            if if target < 0.0 { value <= target } else { value >= target } {
                return Some(t);
            }
            step *= 4.0;
        }
        None
    }
}

/// Widenings by a factor of 4 that take a step from the smallest to the whole.
const WIDENINGS: u32 = 32;

/// Where a cubic is supposed to be beyond a value: a part's time `t`, and the
/// share of the part further.
#[derive(Clone, Copy)]
struct Hint {
    t: f64,
    share: f64,
}

/// Where a rising cubic reaches a value, and its slope there.
struct Solution {
    t: f64,
    slope: f64,
}

/// Steps at most; bisection takes over where they leave the bracket, and 60 of
/// those reach the last bit.
const MOST_STEPS: u32 = 60;

/// A step this short leaves an error of its cube, which is below rounding.
const LAST_STEP: f64 = 2e-5;

/// Where a cubic with rising Bernstein coefficients reaches `value`, which
/// lies between its first and its last: Halley's iteration from `start`,
/// within a bracket.
#[inline]
fn solve([b0, b1, b2, b3]: [f64; 4], value: f64, start: f64) -> Solution {
    let (c0, c1) = (b0 - value, 3.0 * (b1 - b0));
    let (c2, c3) = (3.0 * (b2 - 2.0 * b1 + b0), b3 - b0 - 3.0 * (b2 - b1));
    let (mut lo, mut hi) = (0.0, 1.0);
    let mut t = start;
    let mut slope = 0.0;
    for _ in 0..MOST_STEPS {
        let f = ((c3 * t + c2) * t + c1) * t + c0;
        slope = (3.0 * c3 * t + 2.0 * c2) * t + c1;
        let half_curvature = 3.0 * c3 * t + c2;
        if f <= 0.0 {
            lo = larger(lo, t);
        } else {
            hi = smaller(hi, t);
        }
        let halley = t - f * slope / (slope * slope - f * half_curvature);
        let next = if lo <= halley && halley <= hi { halley } else { 0.5 * (lo + hi) };
        let step = (next - t).abs();
        t = next;
        if step <= LAST_STEP {
            break;
        }
    }
    Solution { t, slope }
}
