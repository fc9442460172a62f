//! Boxes along the axes.

use glam::DVec3;

/// A box, by its lower and its upper corner; empty if one is above the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) low: DVec3,
    pub(crate) high: DVec3,
}

impl Bounds {
    pub(crate) const EMPTY: Self = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };

    pub(crate) fn of(points: &[DVec3]) -> Self {
        points.iter().fold(Self::EMPTY, |b, &p| Self { low: b.low.min(p), high: b.high.max(p) })
    }

    pub(crate) fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// What both hold.
    pub(crate) fn intersection(self, other: Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high) }
    }

    pub(crate) fn is_empty(self) -> bool {
        !self.low.cmple(self.high).all()
    }

    pub(crate) fn overlaps(self, other: Self) -> bool {
        !self.intersection(other).is_empty()
    }

    /// Lengths of the sides.
    pub(crate) fn sides(self) -> DVec3 {
        self.high - self.low
    }

    pub(crate) fn holds(self, p: DVec3) -> bool {
        self.low.cmple(p).all() && p.cmple(self.high).all()
    }
}
