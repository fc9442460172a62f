//! Cubics with rounding bounds, and where they may be zero.
//!
//! A [`Cubic`] is a polynomial of degree 3 or less on `0..=1` in Bernstein
//! form, whose coefficients are known up to an error. Its graph lies in the
//! hull of its coefficients, so coefficients of one sign beyond the error say
//! that there is no root: the *coplanarity certificate* of this crate.
//! [`Cubic::isolate`] turns that into intervals: outside them the exact
//! polynomial is certainly not zero, inside them it crosses zero
//! ([`Rising`](RootKind::Rising), [`Falling`](RootKind::Falling)), or comes too
//! close to tell ([`Grazing`](RootKind::Grazing),
//! [`Vanishing`](RootKind::Vanishing)).
//!
//! [`roots`] solves the same polynomial plainly, without certificates.
//!
//! Sources: M. Tang, D. Manocha and R. Tong, "Fast continuous collision
//! detection using deforming non-penetration filters", I3D 2010 (signs of
//! Bernstein coefficients as a filter; here with a rounding bound, and on
//! sub-intervals); C. Yuksel, "High-performance polynomial root finding for
//! graphics", Proc. ACM CGIT 5(3), 2022 (bracketed Newton steps between
//! critical points).
//!
//! # Example
//!
//! ```
//! use ccd::cubic::{Cubic, RootKind};
//!
//! // (t - 0.5) (t - 2) (t + 1), known to 1e-15 in each coefficient.
//! let cubic = Cubic::from_powers([1.0, -1.5, -1.5, 1.0], 1e-15);
//! let found = cubic.isolate(0.0);
//! assert_eq!(found.len(), 1);
//! assert_eq!(found[0].kind, RootKind::Falling);
//! assert!(found[0].lo < 0.5 && 0.5 < found[0].hi && found[0].hi - found[0].lo < 1e-13);
//! ```

mod isolate;
mod plain;

pub use plain::{PlainRoots, roots};

use crate::polygon::{larger, mix, smaller};
use crate::rounding::{SUBDIVISION, UNDERFLOW};

/// A polynomial of degree 3 on `0..=1` in Bernstein form, with its rounding bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic {
    bernstein: [f64; 4],
    error: f64,
    evaluation_error: f64,
}

/// An interval in which a cubic may be zero.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RootInterval {
    /// Start of the interval, in `0..=1`.
    pub lo: f64,
    /// Its end, not before the start.
    pub hi: f64,
    /// What is known in between.
    pub kind: RootKind,
}

/// What is known of a cubic within an interval.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum RootKind {
    /// It is certainly negative at the start and positive at the end.
    Rising,
    /// It is certainly positive at the start and negative at the end.
    Falling,
    /// It comes closer to zero than its error: a double root, a near miss, or a
    /// root at one end of `0..=1`.
    Grazing,
    /// All coefficients are within the error of zero: the interval is `0..=1`,
    /// and nothing is known.
    Vanishing,
}

/// The intervals found by [`Cubic::isolate`], ascending and disjoint.
#[derive(Clone, Copy, Debug)]
pub struct Roots {
    intervals: [RootInterval; Self::MOST],
    count: usize,
}

impl Cubic {
    /// The cubic with these Bernstein coefficients, each known up to `error`
    /// (absolute, `>= 0`).
    #[inline]
    #[must_use]
    pub fn new(bernstein: [f64; 4], error: f64) -> Self {
        let [b0, b1, b2, b3] = bernstein.map(f64::abs);
        let largest = larger(larger(b0, b1), larger(b2, b3));
        let evaluation_error = error + SUBDIVISION * largest + UNDERFLOW;
        Self { bernstein, error, evaluation_error }
    }

    /// The cubic `c0 + c1 t + c2 t^2 + c3 t^3`, each coefficient known up to
    /// `error`; the rounding of the conversion is added to it.
    #[must_use]
    pub fn from_powers([c0, c1, c2, c3]: [f64; 4], error: f64) -> Self {
        let bernstein = [c0, c0 + c1 / 3.0, c0 + (2.0 * c1 + c2) / 3.0, c0 + c1 + c2 + c3];
        // At most four roundings of sums no larger than that of all |c|.
        let sum = c0.abs() + c1.abs() + c2.abs() + c3.abs();
        Self::new(bernstein, 4.0 * error + SUBDIVISION * sum)
    }

    /// Bernstein coefficients on `0..=1`.
    #[must_use]
    pub fn bernstein(&self) -> [f64; 4] {
        self.bernstein
    }

    /// Bound on the error of each coefficient.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Bound on the error of a value or of coefficients on a sub-interval:
    /// that of the coefficients, the rounding of de Casteljau's scheme, and
    /// 2^-960 for underflow.
    #[inline]
    #[must_use]
    pub fn evaluation_error(&self) -> f64 {
        self.evaluation_error
    }

    /// Value at `t`, in `0..=1`, up to [`Cubic::evaluation_error`].
    #[inline]
    #[must_use]
    pub fn value(&self, t: f64) -> f64 {
        let [b0, b1, b2, b3] = self.bernstein;
        let s = 1.0 - t;
        ((s * b0 + 3.0 * t * b1) * s + 3.0 * (t * t) * b2) * s + t * t * t * b3
    }

    /// Bernstein coefficients on `lo..=hi`, by blossoming: each up to
    /// [`Cubic::evaluation_error`], however short the interval.
    #[inline]
    #[must_use]
    pub fn on(&self, lo: f64, hi: f64) -> [f64; 4] {
        let [b0, b1, b2, b3] = self.bernstein;
        let (l0, l1, l2) = (mix(b0, b1, lo), mix(b1, b2, lo), mix(b2, b3, lo));
        let (h0, h1, h2) = (mix(b0, b1, hi), mix(b1, b2, hi), mix(b2, b3, hi));
        let (ll0, ll1) = (mix(l0, l1, lo), mix(l1, l2, lo));
        let (hh0, hh1) = (mix(h0, h1, hi), mix(h1, h2, hi));
        [mix(ll0, ll1, lo), mix(ll0, ll1, hi), mix(hh0, hh1, lo), mix(hh0, hh1, hi)]
    }

    /// Whether the exact cubic is certainly further than `margin` from zero on
    /// all of `0..=1`.
    #[inline]
    #[must_use]
    pub fn excludes_zero(&self, margin: f64) -> bool {
        beyond(&self.bernstein, self.error + margin)
    }

    /// Intervals outside which the exact cubic is certainly further than
    /// `margin` (`>= 0`) from zero.
    #[inline]
    #[must_use]
    pub fn isolate(&self, margin: f64) -> Roots {
        let mut roots = Roots::none();
        if !self.excludes_zero(margin) {
            self.find_interval(margin, |interval| {
                roots.push(*interval);
                None::<()>
            });
        }
        roots
    }

    /// What `look` finds first in the intervals of [`Cubic::isolate`], for a
    /// cubic that does not exclude zero by [`Cubic::excludes_zero`].
    #[inline]
    pub(crate) fn find_interval<R>(
        &self,
        margin: f64,
        look: impl FnMut(&RootInterval) -> Option<R>,
    ) -> Option<R> {
        isolate::find_interval(self, margin, look)
    }
}

/// Whether all coefficients are on one side, further than `bound` from zero.
#[inline]
fn beyond(&[b0, b1, b2, b3]: &[f64; 4], bound: f64) -> bool {
    smaller(smaller(b0, b1), smaller(b2, b3)) > bound
        || larger(larger(b0, b1), larger(b2, b3)) < -bound
}

impl Roots {
    /// Intervals there can be: three crossings, and what grazes between them.
    const MOST: usize = 7;

    #[inline]
    const fn none() -> Self {
        let empty = RootInterval { lo: 0.0, hi: 0.0, kind: RootKind::Grazing };
        Self { intervals: [empty; Self::MOST], count: 0 }
    }

    /// Appends an interval; where there is no room it is joined with the last.
    fn push(&mut self, interval: RootInterval) {
        if self.count < Self::MOST {
            self.intervals[self.count] = interval;
            self.count += 1;
        } else if let Some(last) = self.intervals.last_mut() {
            last.hi = interval.hi;
            last.kind = RootKind::Grazing;
        }
    }
}

impl std::ops::Deref for Roots {
    type Target = [RootInterval];

    fn deref(&self) -> &[RootInterval] {
        &self.intervals[..self.count]
    }
}
