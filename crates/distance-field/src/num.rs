//! The few conversions between counts and coordinates, each named once.

/// A node number as a coordinate; exact below 2^53.
#[inline]
#[expect(
    clippy::cast_possible_wrap,
    clippy::cast_precision_loss,
    reason = "grids have far fewer than 2^53 nodes"
)]
pub(crate) fn coordinate(index: usize) -> f64 {
    // Processors convert numbers with a sign in one step, those without in several.
    index as i64 as f64
}

/// The largest node number at or below `x`; 0 for what is negative or not a
/// number, and at most 2^31 − 1, more than an axis may have.
#[inline]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates, which is the clamp that callers want"
)]
pub(crate) fn floor_index(x: f64) -> usize {
    x.max(0.0) as i32 as usize
}

/// The largest whole number at or below `x`, for `0 <= x < 2^51`.
///
/// In four operations that work on many numbers at once, which rounding down has
/// no instruction for on every processor.
#[inline]
pub(crate) fn floor(x: f64) -> f64 {
    // At this magnitude neighbouring numbers are 1 apart.
    const WHOLE: f64 = 6_755_399_441_055_744.0; // 1.5 · 2^52
    let nearest = (x + WHOLE) - WHOLE;
    nearest - if nearest > x { 1.0 } else { 0.0 }
}

/// A whole number `0 <= x < 2^52` as an index.
#[inline]
pub(crate) fn whole_index(x: f64) -> usize {
    const TWO_TO_52: f64 = 4_503_599_627_370_496.0;
    // The digits of the sum are those of the number.
    ((x + TWO_TO_52).to_bits() & ((1 << 52) - 1)) as usize
}

/// Nearest single-precision value.
#[expect(clippy::cast_possible_truncation, reason = "rounding to storage precision is the purpose")]
pub(crate) fn single(x: f64) -> f32 {
    x as f32
}

/// Nearest whole number, saturating.
#[expect(clippy::cast_possible_truncation, reason = "the cast saturates")]
pub(crate) fn nearest(x: f64) -> i64 {
    x.round() as i64
}

/// A number of bytes, saturating.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
pub(crate) fn floor_count(x: f64) -> usize {
    x as usize
}

/// Nodes of `0..count` within `lo..=hi`.
#[inline]
pub(crate) fn nodes_within(lo: f64, hi: f64, count: usize) -> std::ops::Range<usize> {
    let last = coordinate(count) - 1.0;
    let lo = if lo > 0.0 { lo } else { 0.0 };
    let hi = if hi < last { hi } else { last };
    // Also where either was not a number.
    if lo <= hi { whole_index(-floor(-lo))..whole_index(floor(hi)) + 1 } else { 0..0 }
}
