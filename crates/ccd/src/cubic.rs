//! Cubics with rounding bounds, and intervals in which they may be zero.
//!
//! The graph of a cubic lies in the convex hull of its Bernstein coefficients, so coefficients of
//! one sign beyond their error exclude a root: the *cubic certificate*. Root isolation applies it to
//! sub-intervals. Outside the intervals found, the exact polynomial is certainly not zero. Inside
//! them it changes sign ([`Rising`](RootKind::Rising), [`Falling`](RootKind::Falling)), or comes too
//! close to zero to decide ([`Grazing`](RootKind::Grazing), [`Vanishing`](RootKind::Vanishing)).
//!
//! Sources: M. Tang, D. Manocha and R. Tong, "Fast continuous collision detection using deforming
//! non-penetration filters", I3D 2010 (signs of Bernstein coefficients as a filter; here with a
//! rounding bound, and on sub-intervals); C. Yuksel, "High-performance polynomial root finding for
//! graphics", Proc. ACM CGIT 5(3), 2022 (bracketed Newton steps between critical points).

mod isolation;
mod single_root;

use crate::rounding::{SUBDIVISION, UNDERFLOW};
use crate::scalar::{fast_max, fast_min, mix};

/// Polynomial of degree 3 or less on `0..=1` in Bernstein form, with its rounding bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct BernsteinCubic {
    /// Bernstein coefficients.
    pub(crate) bernstein: [f64; 4],
    /// Bound on the error of each coefficient.
    pub(crate) error: f64,
    /// Bound on the error of a value or of coefficients on a sub-interval: that of the
    /// coefficients, the rounding of de Casteljau's scheme, and 2^-960 for underflow.
    pub(crate) evaluation_error: f64,
}

/// Interval in which a cubic may be zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RootInterval {
    /// Start of the interval, in `0..=1`.
    pub(crate) lo: f64,
    /// Its end, not before the start.
    pub(crate) hi: f64,
    pub(crate) kind: RootKind,
}

/// Behavior of a cubic within an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RootKind {
    /// It is certainly negative at the start and positive at the end.
    Rising,
    /// It is certainly positive at the start and negative at the end.
    Falling,
    /// It comes closer to zero than its error: a double root, a near miss, or a root at one end of
    /// `0..=1`.
    Grazing,
    /// All coefficients are within the error of zero, and the interval is `0..=1`.
    Vanishing,
}

impl RootInterval {
    /// Returns the middle of the interval.
    #[inline]
    pub(crate) fn middle(&self) -> f64 {
        0.5 * (self.lo + self.hi)
    }
}

impl BernsteinCubic {
    /// Creates the cubic with these Bernstein coefficients, each up to `error` (absolute, `>= 0`).
    #[inline]
    pub(crate) fn new(bernstein: [f64; 4], error: f64) -> Self {
        let [b0, b1, b2, b3] = bernstein.map(f64::abs);
        let largest = fast_max(fast_max(b0, b1), fast_max(b2, b3));
        let evaluation_error = error + SUBDIVISION * largest + UNDERFLOW;
        Self { bernstein, error, evaluation_error }
    }

    /// Evaluates the cubic at `t` in `0..=1`, up to the evaluation error.
    #[inline]
    pub(crate) fn value(&self, t: f64) -> f64 {
        let [b0, b1, b2, b3] = self.bernstein;
        let s = 1.0 - t;
        ((s * b0 + 3.0 * t * b1) * s + 3.0 * (t * t) * b2) * s + t * t * t * b3
    }

    /// Computes the Bernstein coefficients on `lo..=hi` by blossoming, each up to the evaluation
    /// error, however short the interval.
    #[inline]
    pub(crate) fn on(&self, lo: f64, hi: f64) -> [f64; 4] {
        let [b0, b1, b2, b3] = self.bernstein;
        let (l0, l1, l2) = (mix(b0, b1, lo), mix(b1, b2, lo), mix(b2, b3, lo));
        let (h0, h1, h2) = (mix(b0, b1, hi), mix(b1, b2, hi), mix(b2, b3, hi));
        let (ll0, ll1) = (mix(l0, l1, lo), mix(l1, l2, lo));
        let (hh0, hh1) = (mix(h0, h1, hi), mix(h1, h2, hi));
        [mix(ll0, ll1, lo), mix(ll0, ll1, hi), mix(hh0, hh1, lo), mix(hh0, hh1, hi)]
    }

    /// Returns true if the exact cubic is certainly farther than `margin` from zero on `0..=1`.
    #[inline]
    pub(crate) fn excludes_zero(&self, margin: f64) -> bool {
        all_beyond(&self.bernstein, self.error + margin)
    }

    /// Examines the intervals in which the exact cubic may be within `margin` (`>= 0`) of zero, in
    /// ascending order, and returns the first result.
    ///
    /// The cubic must not exclude zero by [`BernsteinCubic::excludes_zero`]. No interval is isolated
    /// before those ahead of it were examined.
    #[inline]
    pub(crate) fn find_in_root_intervals<R>(
        &self,
        margin: f64,
        examine: impl FnMut(&RootInterval) -> Option<R>,
    ) -> Option<R> {
        isolation::find_in_root_intervals(self, margin, examine)
    }
}

/// Returns true if all coefficients are on one side of zero, farther than `bound`.
#[inline]
fn all_beyond(&[b0, b1, b2, b3]: &[f64; 4], bound: f64) -> bool {
    fast_min(fast_min(b0, b1), fast_min(b2, b3)) > bound
        || fast_max(fast_max(b0, b1), fast_max(b2, b3)) < -bound
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The cubic `c0 + c1 t + c2 t^2 + c3 t^3`, with the rounding of the conversion as its error.
    fn from_powers([c0, c1, c2, c3]: [f64; 4]) -> BernsteinCubic {
        let bernstein = [c0, c0 + c1 / 3.0, c0 + (2.0 * c1 + c2) / 3.0, c0 + c1 + c2 + c3];
        let sum = c0.abs() + c1.abs() + c2.abs() + c3.abs();
        BernsteinCubic::new(bernstein, SUBDIVISION * sum)
    }

    fn root_intervals(cubic: &BernsteinCubic) -> Vec<RootInterval> {
        let mut found = Vec::new();
        if !cubic.excludes_zero(0.0) {
            cubic.find_in_root_intervals(0.0, |interval| {
                found.push(*interval);
                None::<()>
            });
        }
        found
    }

    #[test]
    fn three_roots_have_three_short_intervals() {
        let cubic = |t: f64| (t - 0.2) * (t - 0.5) * (t - 0.8);
        let found = root_intervals(&from_powers([-0.08, 0.66, -1.5, 1.0]));
        assert_eq!(found.len(), 3, "{found:?}");
        for (interval, root) in found.iter().zip([0.2, 0.5, 0.8]) {
            assert!(interval.lo <= root && root <= interval.hi, "{interval:?} without {root}");
            assert!(interval.hi - interval.lo < 1e-12, "{interval:?} is long");
            assert!(cubic(interval.lo) * cubic(interval.hi) < 0.0, "{interval:?}: no sign change");
        }
    }

    #[test]
    fn first_roots_before_a_peak_are_single() {
        for (powers, root, kind) in [
            ([-0.08, 0.66, -1.5, 1.0], 0.2, RootKind::Rising),
            ([0.08, -0.66, 1.5, -1.0], 0.2, RootKind::Falling),
            ([-0.1, 0.0, 0.0, 0.8], 0.5, RootKind::Rising),
            ([-0.2, 1.0, -0.8, 0.0], 0.25, RootKind::Rising),
        ] {
            let cubic = from_powers(powers);
            let first = cubic.single_root().unwrap_or_else(|| panic!("{powers:?} has a root"));
            assert!(first.kind == kind && first.lo < root + 1e-14, "{powers:?}: {first:?}");
            assert!(root - 1e-14 < first.hi && first.hi - first.lo < 1e-13, "{first:?} is long");
            assert_eq!(root_intervals(&cubic)[0], first, "{powers:?}: another first root");
        }
        assert_eq!(from_powers([-0.25, 1.0, -1.0, 0.0]).single_root(), None, "a double root");
        assert_eq!(from_powers([0.0, 1.0, 0.0, 0.0]).single_root(), None, "a root at the start");
    }

    #[test]
    fn double_roots_graze_and_zero_vanishes() {
        let graze = root_intervals(&from_powers([0.25, -1.0, 1.0, 0.0]));
        assert!(graze.iter().any(|r| r.kind == RootKind::Grazing && r.lo <= 0.5 && 0.5 <= r.hi));

        let zero = root_intervals(&BernsteinCubic::new([0.0; 4], 1e-20));
        assert_eq!(zero, [RootInterval { lo: 0.0, hi: 1.0, kind: RootKind::Vanishing }]);
        assert!(root_intervals(&from_powers([0.26, -1.0, 1.0, 0.0])).is_empty());
    }
}
