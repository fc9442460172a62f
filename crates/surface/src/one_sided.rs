//! How far one set of points is from another, at most.

/// A one-sided Hausdorff distance, in the caller's length unit: the largest of the
/// distances of one set's points from another set, bracketed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OneSidedDistance {
    /// The largest distance met with, `>= 0`.
    pub seen: f64,
    /// No distance is larger, up to rounding. How near this is to `seen` is for
    /// whoever measures to say.
    pub at_most: f64,
}
