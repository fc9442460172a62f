//! First root of a cubic by one change of sign of its Bernstein coefficients.
//!
//! Coefficients that change sign once have one root, and on a part that ends before it all exact
//! coefficients have the sign of the first (variation diminishing). So computed coefficients on that
//! part certify that no root is before, without a split at critical points. A cubic with more
//! changes of sign is cut at its first extremum of the other sign, before which its first root is.
//!
//! The root itself is a hint. Roots that are not certified this way are left to the isolation by
//! parts. Most contacts of simulations are found here.
//!
//! Source: J. M. Lane and R. F. Riesenfeld, "Bounds on a polynomial", BIT 21, 1981 (roots and
//! changes of sign of Bernstein coefficients).

use wide::f64x2;

use super::{BernsteinCubic, RootInterval, RootKind};
use crate::scalar::mix;

/// Distance of both ends of an interval from the root, in distances at which the tangent exceeds the
/// evaluation error. A smaller one is seldom certified, a larger one makes contacts earlier.
const ROOT_SLACK: f64 = 1.25;

/// Maximum distance of both ends of an interval from the root. A tangent that is longer within the
/// error is that of a cubic which splits narrow better.
const MAX_REACH: f64 = 1e-9;

/// Last step of the iteration: its error is the cube of the step, which is below rounding.
const LAST_STEP: f64 = 2e-5;

/// Maximum number of iterations: roots that take more are left to bracketed iteration.
const MAX_ITERATIONS: u32 = 5;

/// Interval of a root; empty, with `lo > hi`, where none is certified.
///
/// Two numbers are returned in registers. As an option they would pass through memory, in pieces
/// that are not those in which they are read.
#[derive(Clone, Copy)]
struct Bracket {
    lo: f64,
    hi: f64,
}

impl Bracket {
    const NONE: Self = Self { lo: 1.0, hi: 0.0 };
}

impl BernsteinCubic {
    /// Returns an interval in which the exact cubic changes sign, and before which it certainly is
    /// not zero; `None` where the first root has no such interval, or is not found this way.
    #[inline]
    pub(crate) fn single_root(&self) -> Option<RootInterval> {
        let [b0, b1, b2, b3] = self.bernstein;
        let side = -1.0_f64.copysign(b0);
        let Bracket { lo, hi } =
            first_rise(side * b0, side * b1, side * b2, side * b3, self.evaluation_error);

        let kind = if side > 0.0 { RootKind::Rising } else { RootKind::Falling };
        (lo <= hi).then_some(RootInterval { lo, hi, kind })
    }
}

/// Returns an interval of the first root of the cubic with these Bernstein coefficients, the first
/// of which is not positive; `error` is the evaluation error.
#[inline(never)]
fn first_rise(b0: f64, b1: f64, b2: f64, b3: f64, error: f64) -> Bracket {
    // All of the step, or what is before the peak, must hold one root.
    let whole = [b0, b1, b2, b3];
    let (mut end, mut part) = (1.0, whole);
    if !rises_once(part, error) {
        end = peak(whole);
        if !(0.0 < end && end < 1.0) {
            return Bracket::NONE;
        }
        part = coefficients_until(whole, end);
        if !rises_once(part, error) {
            return Bracket::NONE;
        }
    }

    // The slope at the root leads to both sides of it.
    let Root { t, slope } = find_root(part);
    let (root, reach) = (t * end, ROOT_SLACK * end * error / slope + 2.0 * f64::EPSILON);
    let bracket = Bracket { lo: root - reach, hi: root + reach };

    // Both ends are certified from the coefficients on the whole step.
    let is_within = 0.0 < bracket.lo && bracket.hi < end && reach < MAX_REACH;
    if is_within && rises_between(whole, bracket, error) { bracket } else { Bracket::NONE }
}

/// Returns true if coefficients are negative at the start and positive at the end, both by more than
/// `error`, and change sign once between them.
#[inline]
fn rises_once([b0, b1, b2, b3]: [f64; 4], error: f64) -> bool {
    b0 < -error && b3 > error && !(b1 > 0.0 && b2 <= 0.0)
}

/// Returns the time of the local maximum of a cubic; any value where it has none.
#[inline]
fn peak([b0, b1, b2, b3]: [f64; 4]) -> f64 {
    // The root of the derivative at which that falls, without cancellation.
    let (d0, d1, d2) = (b1 - b0, b2 - b1, b3 - b2);
    let (b, a) = (d1 - d0, d0 - 2.0 * d1 + d2);
    let root = (b * b - a * d0).sqrt();
    if b > 0.0 { -(b + root) / a } else { d0 / (root - b) }
}

/// Returns true if the exact cubic is certainly negative up to `lo`, and positive at `hi`.
///
/// The first coefficient is negative by more than `error`; the others on `0..=lo`, and the value at
/// `hi`, are blossoms, computed in two lanes.
#[inline]
fn rises_between(b: [f64; 4], Bracket { lo, hi }: Bracket, error: f64) -> bool {
    let [b0, b1, b2, b3] = b.map(f64x2::splat);
    let t = f64x2::new([lo, hi]);
    let s = f64x2::splat(1.0) - t;
    let (l0, l1, l2) = (s * b0 + t * b1, s * b1 + t * b2, s * b2 + t * b3);
    let (m0, m1) = (s * l0 + t * l1, s * l1 + t * l2);
    let values = s * m0 + t * m1;

    let [largest_before, _] = l0.fast_max(m0).fast_max(values).to_array();
    let [_, after] = values.to_array();
    largest_before < -error && after > error
}

/// Computes the Bernstein coefficients on `0..=t`, each up to the evaluation error.
#[inline]
fn coefficients_until([b0, b1, b2, b3]: [f64; 4], t: f64) -> [f64; 4] {
    let (l0, l1, l2) = (mix(b0, b1, t), mix(b1, b2, t), mix(b2, b3, t));
    let (m0, m1) = (mix(l0, l1, t), mix(l1, l2, t));
    [b0, l0, m0, mix(m0, m1, t)]
}

/// Estimate of a root, and the slope beside it.
struct Root {
    t: f64,
    slope: f64,
}

/// Estimates the root of coefficients that rise once, by Halley's iteration.
#[inline]
fn find_root(b: [f64; 4]) -> Root {
    let [b0, b1, b2, b3] = b;
    let (c1, c2, c3) = (3.0 * (b1 - b0), 3.0 * (b2 - 2.0 * b1 + b0), b3 - b0 - 3.0 * (b2 - b1));
    let mut root = Root { t: polygon_root(b), slope: 0.0 };
    for _ in 0..MAX_ITERATIONS {
        // In pairs of terms, which wait for each other less than in Horner's order.
        let (t, squared, c3t) = (root.t, root.t * root.t, c3 * root.t);
        let f = (b0 + c1 * t) + squared * (c2 + c3t);
        let slope = (c1 + (c2 + c2) * t) + 3.0 * c3 * squared;
        let half_curvature = c2 + 3.0 * c3t;

        let step = f * slope / (slope * slope - f * half_curvature);
        root = Root { t: t - step, slope };
        if step.abs() < LAST_STEP {
            break;
        }
    }
    root
}

/// Returns where the control polygon of coefficients that rise once crosses zero.
#[inline]
fn polygon_root([b0, b1, b2, b3]: [f64; 4]) -> f64 {
    let (leg, from, to) = if b1 > 0.0 {
        (0.0, b0, b1)
    } else if b2 > 0.0 {
        (1.0, b1, b2)
    } else {
        (2.0, b2, b3)
    };
    (leg + from / (from - to)) * (1.0 / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_within_the_error_of_zero_are_not_certified() {
        // A line through zero in the middle, with slope 2.
        let line = [-1.0, -1.0 / 3.0, 1.0 / 3.0, 1.0];
        let certified = |before, after| {
            rises_between(line, Bracket { lo: 0.5 - before, hi: 0.5 + after }, 1e-3)
        };
        assert!(certified(6e-4, 6e-4));
        assert!(!certified(4e-4, 6e-4) && !certified(6e-4, 4e-4));
    }

    #[test]
    fn roots_before_the_start_of_an_interval_are_noticed() {
        // Positive at 0.2, negative at 0.5, positive at the end.
        let humped = [-1.0, 5.0, -8.0, 4.0];
        assert!(!rises_between(humped, Bracket { lo: 0.5, hi: 0.999 }, 1e-12));
        assert!(!rises_once(humped, 1e-12) && (0.1..0.4).contains(&peak(humped)));
    }
}
