//! Conversions between node numbers and coordinates.

use std::ops::Range;

/// Converts a node number to a coordinate; exact below 2^53.
#[inline]
#[expect(
    clippy::cast_possible_wrap,
    clippy::cast_precision_loss,
    reason = "grids have far fewer than 2^53 nodes"
)]
pub(crate) fn coordinate(index: usize) -> f64 {
    // Signed numbers convert in one instruction, unsigned ones in several.
    index as i64 as f64
}

/// Returns the largest node number at or below `x`: 0 for negative numbers and NaN, at most
/// 2^31 − 1, more than an axis may have.
#[inline]
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the cast saturates, which is the clamp that callers want"
)]
pub(crate) fn floor_index(x: f64) -> usize {
    x.max(0.0) as i32 as usize
}

/// Rounds down, for `0 <= x < 2^51`.
///
/// Four operations that vectorize; not every processor has an instruction for this.
#[inline]
pub(crate) fn floor(x: f64) -> f64 {
    // At this magnitude neighboring numbers are 1 apart.
    const WHOLE: f64 = 6_755_399_441_055_744.0; // 1.5 · 2^52
    let nearest = (x + WHOLE) - WHOLE;
    nearest - if nearest > x { 1.0 } else { 0.0 }
}

/// Converts a whole number `0 <= x < 2^52` to an index.
#[inline]
pub(crate) fn whole_index(x: f64) -> usize {
    const TWO_TO_52: f64 = 4_503_599_627_370_496.0;
    // The mantissa of the sum is the number.
    ((x + TWO_TO_52).to_bits() & ((1 << 52) - 1)) as usize
}

/// Rounds to single precision.
#[expect(clippy::cast_possible_truncation, reason = "rounding to storage precision is the purpose")]
pub(crate) fn single(x: f64) -> f32 {
    x as f32
}

/// Rounds to the nearest whole number, saturating.
#[expect(clippy::cast_possible_truncation, reason = "the cast saturates")]
pub(crate) fn nearest(x: f64) -> i64 {
    x.round() as i64
}

/// Rounds a number of bytes down, saturating.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "the cast saturates")]
pub(crate) fn floor_count(x: f64) -> usize {
    x as usize
}

/// Returns the nodes of `0..count` whose coordinates are within `lower..=upper`; none where
/// either is NaN.
#[inline]
pub(crate) fn nodes_within(lower: f64, upper: f64, count: usize) -> Range<usize> {
    let last = coordinate(count) - 1.0;
    let lower = if lower > 0.0 { lower } else { 0.0 };
    let upper = if upper < last { upper } else { last };
    if lower <= upper { whole_index(-floor(-lower))..whole_index(floor(upper)) + 1 } else { 0..0 }
}
