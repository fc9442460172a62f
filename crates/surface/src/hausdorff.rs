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
