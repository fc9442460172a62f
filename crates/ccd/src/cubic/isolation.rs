//! Root isolation of a cubic whose coefficients have an error.
//!
//! Most cubics have one root before their first extremum, which signs of coefficients certify by
//! themselves (`single_root`). The others, and what follows such a root, are searched by parts.
//!
//! Intervals are split at critical points until each is free of roots, within the error of zero, or
//! monotone. A monotone interval holds a crossing, which a bracketed iteration finds in plain
//! arithmetic. That crossing is a hint: an interval around it is widened until the *values at its
//! ends* are far enough from zero, and those are evaluated from the given coefficients with a
//! bound.
//!
//! Where computed coefficients of a sub-interval rise, the exact ones fall by at most `2 E` from one
//! to the next, so the exact cubic falls by at most `6 E` within the sub-interval (`E` is the
//! evaluation error). A computed value of `-(margin + 8 E)` is then enough for the exact cubic to
//! have been below `-margin` since the start of the sub-interval.

use super::{BernsteinCubic, RootInterval, RootKind, all_beyond};
use crate::scalar::{fast_max, fast_min};

/// Maximum number of splits from the whole interval down to a part.
///
/// A cubic has two critical points, so two splits make all parts monotone but for rounding. More are
/// needed where a critical point is too close to an end to split there; below `2^-24` of the step
/// nothing would be gained.
const MAX_SPLITS: u32 = 24;

/// Distance from zero of values that certify a monotone interval, in evaluation errors.
const MONOTONE_SLACK: f64 = 8.0;

/// Share of an interval at either end in which it is not split: a critical point there would leave
/// a part so short that the next split repeats it.
const MIN_PART: f64 = 1.0 / 64.0;

/// Maximum number of widenings by a factor of 4: they take a step from the smallest to the whole.
const MAX_WIDENINGS: u32 = 32;

/// Maximum number of iterations; bisection takes over where they leave the bracket, and 60
/// bisections reach the last bit.
const MAX_ITERATIONS: u32 = 60;

/// Last step of the iteration: its error is the cube of the step, which is below rounding.
const LAST_STEP: f64 = 2e-5;

/// See [`BernsteinCubic::find_in_root_intervals`].
#[inline]
pub(super) fn find_in_root_intervals<R>(
    cubic: &BernsteinCubic,
    margin: f64,
    examine: impl FnMut(&RootInterval) -> Option<R>,
) -> Option<R> {
    let mut isolation = Isolation { cubic, margin, open: None, examine };
    if margin == 0.0
        && let Some(first) = cubic.single_root()
    {
        return (isolation.examine)(&first).or_else(|| isolation.after(first.hi));
    }
    isolation.all()
}

/// State of an isolation.
struct Isolation<'a, F> {
    cubic: &'a BernsteinCubic,
    margin: f64,
    /// The last interval, as long as it touches the part that comes next.
    open: Option<RootInterval>,
    examine: F,
}

/// Sub-interval and its Bernstein coefficients.
#[derive(Clone, Copy)]
struct Part {
    lo: f64,
    hi: f64,
    b: [f64; 4],
}

impl Part {
    /// Returns true if all coefficients are within `bound` of zero.
    fn is_within(&self, bound: f64) -> bool {
        self.b.iter().all(|b| b.abs() <= bound)
    }

    /// Returns 1 if coefficients rise, -1 if they fall, 0 otherwise.
    #[inline]
    fn direction(&self) -> f64 {
        let [b0, b1, b2, b3] = self.b;
        let side = 1.0_f64.copysign(b3 - b0);
        let [d0, d1, d2] = [side * (b1 - b0), side * (b2 - b1), side * (b3 - b2)];
        if fast_min(fast_min(d0, d1), d2) >= 0.0 { side } else { 0.0 }
    }

    /// Finds a critical point well inside, otherwise the middle, in `0..1` of the part.
    fn split(&self) -> f64 {
        let [b0, b1, b2, b3] = self.b;
        let (d0, d1, d2) = (b1 - b0, b2 - b1, b3 - b2);
        quadratic_roots(d0, 2.0 * (d1 - d0), d0 - 2.0 * d1 + d2)
            .into_iter()
            .find(|t| (MIN_PART..=1.0 - MIN_PART).contains(t))
            .unwrap_or(0.5)
    }
}

/// Solves `c + b t + a t^2 = 0`; the roots are ascending, and NaN or infinite where there is none.
fn quadratic_roots(c: f64, b: f64, a: f64) -> [f64; 2] {
    let q = -0.5 * (b + (b * b - 4.0 * a * c).sqrt().copysign(b));
    let (x, y) = (q / a, c / q);
    if x < y { [x, y] } else { [y, x] }
}

impl<R, F: FnMut(&RootInterval) -> Option<R>> Isolation<'_, F> {
    /// Visits the whole step.
    #[inline(never)]
    fn all(mut self) -> Option<R> {
        let whole = Part { lo: 0.0, hi: 1.0, b: self.cubic.bernstein };
        if whole.is_within(self.cubic.evaluation_error + self.margin) {
            let everything = RootInterval { lo: 0.0, hi: 1.0, kind: RootKind::Vanishing };
            return (self.examine)(&everything);
        }
        self.narrow(&whole, MAX_SPLITS).or_else(|| self.close())
    }

    /// Visits what follows a root that was found by itself.
    #[inline(never)]
    fn after(mut self, lo: f64) -> Option<R> {
        let rest = Part { lo, hi: 1.0, b: self.cubic.on(lo, 1.0) };
        self.visit(&rest, MAX_SPLITS).or_else(|| self.close())
    }

    fn visit(&mut self, part: &Part, splits: u32) -> Option<R> {
        let bound = self.cubic.evaluation_error + self.margin;
        if all_beyond(&part.b, bound) {
            None
        } else if part.is_within(bound) {
            self.keep(part)
        } else {
            self.narrow(part, splits)
        }
    }

    /// Visits the sub-intervals of a part that may be near zero.
    #[inline]
    fn narrow(&mut self, part: &Part, splits: u32) -> Option<R> {
        let direction = part.direction();
        if direction != 0.0 { self.bracket(part, direction) } else { self.split(part, splits) }
    }

    /// Keeps a whole part, which cannot be narrowed.
    fn keep(&mut self, part: &Part) -> Option<R> {
        self.push(part, RootInterval { lo: part.lo, hi: part.hi, kind: RootKind::Grazing })
    }

    #[inline(never)]
    fn split(&mut self, part: &Part, splits: u32) -> Option<R> {
        let middle = part.lo + part.split() * (part.hi - part.lo);
        if splits == 0 || !(part.lo < middle && middle < part.hi) {
            return self.keep(part);
        }
        let lower = Part { lo: part.lo, hi: middle, b: self.cubic.on(part.lo, middle) };
        self.visit(&lower, splits - 1).or_else(|| {
            let upper = Part { lo: middle, hi: part.hi, b: self.cubic.on(middle, part.hi) };
            self.visit(&upper, splits - 1)
        })
    }

    /// Examines an interval of a part, joined with the last one where they touch, unless one in the
    /// next part may touch it.
    #[inline]
    fn push(&mut self, part: &Part, mut interval: RootInterval) -> Option<R> {
        // An interval that touches the open one extends it.
        let mut found = None;
        if let Some(last) = self.open {
            if last.hi >= interval.lo {
                interval = RootInterval { lo: last.lo, kind: RootKind::Grazing, ..interval };
            } else {
                found = (self.examine)(&last);
            }
        }
        self.open = Some(interval);

        // At the end of the part, the interval stays open for the next part.
        if found.is_some() || interval.hi >= part.hi { found } else { self.close() }
    }

    /// Examines the interval that is open.
    #[inline]
    fn close(&mut self) -> Option<R> {
        self.open.take().and_then(|last| (self.examine)(&last))
    }

    /// Narrows a monotone part to where it may be within the margin of zero.
    #[inline]
    fn bracket(&mut self, part: &Part, direction: f64) -> Option<R> {
        let far = self.margin + MONOTONE_SLACK * self.cubic.evaluation_error;
        let rising = part.b.map(|b| direction * b);

        // Certify values far enough from zero before and after the root.
        let from_below = rising[0] < -far;
        let to_above = rising[3] > far;
        let (before, after) = self.hints(rising, far);
        let lo = if from_below { self.widen(part, before, -far, direction) } else { None };
        let hi = if to_above { self.widen(part, after, far, direction) } else { None };

        // Values of opposite signs at both ends prove a root between them.
        let kind = match (lo, hi) {
            (Some(_), Some(_)) if direction > 0.0 => RootKind::Rising,
            (Some(_), Some(_)) => RootKind::Falling,
            _ => RootKind::Grazing,
        };
        let (lo, hi) = (lo.unwrap_or(part.lo), hi.unwrap_or(part.hi));

        // Each end is certified by itself; crossed ends leave nothing between them.
        if lo <= hi { self.push(part, RootInterval { lo, hi, kind }) } else { None }
    }

    /// Estimates where a rising cubic is farther than `far` from zero, below and above it.
    #[inline]
    fn hints(&self, rising: [f64; 4], far: f64) -> (Hint, Hint) {
        let secant = |value: f64| (value - rising[0]) / (rising[3] - rising[0]);
        if rising[0] >= -far || rising[3] <= far {
            let at = |value: f64| Hint { t: solve(rising, value, secant(value)).t, fraction: 0.0 };
            return (at(-far), at(far));
        }

        // The slope at the root leads to both sides of it.
        let root = solve(rising, 0.0, secant(0.0));
        let fraction = far / root.slope;
        let fraction = if fraction <= 1.0 { fraction } else { 0.0 };
        if self.margin == 0.0 {
            let hint = Hint { t: root.t, fraction: 1.25 * fraction };
            return (hint, hint);
        }
        let from = |value: f64, start: f64| Hint {
            t: solve(rising, value, start.clamp(0.0, 1.0)).t,
            fraction: 0.0,
        };
        (from(-far, root.t - fraction), from(far, root.t + fraction))
    }

    /// Finds the first point on the side of `target` of a hint at which the cubic is verified to be
    /// beyond `target`; `None` if there is none within the part.
    #[inline]
    fn widen(&self, part: &Part, hint: Hint, target: f64, direction: f64) -> Option<f64> {
        // From the hint outward, in steps that grow.
        let length = part.hi - part.lo;
        let root = part.lo + hint.t * length;
        let mut step = (hint.fraction * length + 2.0 * f64::EPSILON * part.hi).copysign(target);
        for _ in 0..MAX_WIDENINGS {
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

/// Estimate of where a cubic is beyond a value: a time `t` of the part, and a fraction of the part
/// beyond it.
#[derive(Clone, Copy)]
struct Hint {
    t: f64,
    fraction: f64,
}

/// Time at which a rising cubic has a value, and its slope there.
struct Solution {
    t: f64,
    slope: f64,
}

/// Solves for the time at which a cubic with rising Bernstein coefficients has a value between its
/// first and its last, by Halley's iteration from `start` within a bracket.
#[inline]
fn solve([b0, b1, b2, b3]: [f64; 4], value: f64, start: f64) -> Solution {
    let (c0, c1) = (b0 - value, 3.0 * (b1 - b0));
    let (c2, c3) = (3.0 * (b2 - 2.0 * b1 + b0), b3 - b0 - 3.0 * (b2 - b1));
    let (mut lo, mut hi) = (0.0, 1.0);
    let mut t = start;
    let mut slope = 0.0;
    for _ in 0..MAX_ITERATIONS {
        let f = ((c3 * t + c2) * t + c1) * t + c0;
        slope = (3.0 * c3 * t + 2.0 * c2) * t + c1;
        let half_curvature = 3.0 * c3 * t + c2;

        // The cubic rises, so the sign of the value narrows the bracket.
        if f <= 0.0 {
            lo = fast_max(lo, t);
        } else {
            hi = fast_min(hi, t);
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
