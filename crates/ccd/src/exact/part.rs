//! Parts of the step, in which motion is linear again and times are resolved anew.

use num_bigint::BigInt;

use super::Vector;
use super::root::{ONE, RESOLUTION, Root, TimeBounds};

/// Part of the step between two times, which are fractions of `2^digits`.
#[derive(Clone, Debug)]
pub(super) struct Part {
    ends: [BigInt; 2],
    digits: u32,
}

impl Part {
    /// Returns the part between two times.
    pub(super) fn new(lo: u128, hi: u128) -> Self {
        Self { ends: [lo, hi].map(BigInt::from), digits: RESOLUTION }
    }

    /// Splits the part before and after the interval from its own time `at` to the next one, in which
    /// it was resolved no further; parts without length are left out.
    pub(super) fn around(&self, at: u128) -> Vec<Self> {
        let mut parts = Vec::new();
        for [lo, hi] in [[0, at], [at, at + 1], [at + 1, ONE]] {
            if lo < hi {
                let ends = [self.absolute(lo), self.absolute(hi)];
                parts.push(Self { ends, digits: self.digits + RESOLUTION });
            }
        }
        parts
    }

    /// Returns points in motion at both ends of the part, all multiplied by `2^digits`.
    pub(super) fn points(
        &self,
        [start, end]: &[[Vector<BigInt>; 4]; 2],
    ) -> [[Vector<BigInt>; 4]; 2] {
        let whole = BigInt::from(1) << self.digits;
        let mut at_ends = [start.clone(), end.clone()];
        for (points, time) in at_ends.iter_mut().zip(&self.ends) {
            let rest = &whole - time;
            for i in 0..4 {
                for k in 0..3 {
                    points[i][k] = &start[i][k] * &rest + &end[i][k] * time;
                }
            }
        }
        at_ends
    }

    /// Returns the interval of a root of this part in times of the step, rounded outward.
    pub(super) fn bounds(&self, root: &Root) -> TimeBounds {
        let TimeBounds { lo, hi } = root.bounds();
        let almost_one: BigInt = (BigInt::from(1) << self.digits) - 1;
        let lo = self.absolute(lo) >> self.digits;
        let hi = (self.absolute(hi) + almost_one) >> self.digits;
        TimeBounds { lo: u128::try_from(lo).unwrap_or(0), hi: u128::try_from(hi).unwrap_or(ONE) }
    }

    /// Converts a time of this part to one of the step, as a fraction of `2^(digits + RESOLUTION)`.
    fn absolute(&self, time: u128) -> BigInt {
        let [lo, hi] = &self.ends;
        lo * (ONE - time) + hi * time
    }
}
