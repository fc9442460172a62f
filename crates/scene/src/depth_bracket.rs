//! Certified bracket on a depth.

/// Certified bracket on the depth of an overlap.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DepthBracket {
    /// A depth that a point of one surface has.
    pub lower: f64,
    /// A depth that no point of either surface exceeds.
    pub upper: f64,
}
