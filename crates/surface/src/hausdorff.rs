//! Hausdorff distances, bracketed from below and above.

/// Certified bounds on a directed Hausdorff distance, in the caller's length unit.
///
/// The directed distance from one set to another is the largest distance of a point of
/// the first set from the second set.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DirectedHausdorff {
    /// Largest distance that was evaluated at a point, `>= 0`.
    pub lower: f64,
    /// Proved bound: no distance is larger, up to rounding. The gap to `lower` depends on
    /// the method that measured it.
    pub upper: f64,
}

/// Certified bounds on the two-sided Hausdorff distance between an original and its
/// approximation, in the caller's length unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HausdorffBounds {
    /// Distance of the original's points from the approximation.
    pub forward: DirectedHausdorff,
    /// Distance of the approximation's points from the original.
    pub backward: DirectedHausdorff,
}

impl HausdorffBounds {
    /// Returns the larger of the two lower bounds.
    #[must_use]
    pub const fn lower(&self) -> f64 {
        self.forward.lower.max(self.backward.lower)
    }

    /// Returns the larger of the two upper bounds: each point of either set is at most
    /// this far from the other set.
    #[must_use]
    pub const fn upper(&self) -> f64 {
        self.forward.upper.max(self.backward.upper)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_sided_bounds_are_the_larger_of_both_directions() {
        let bounds = HausdorffBounds {
            forward: DirectedHausdorff { lower: 1.0, upper: 4.0 },
            backward: DirectedHausdorff { lower: 2.0, upper: 3.0 },
        };
        assert_eq!((bounds.lower(), bounds.upper()), (2.0, 4.0));
    }
}
