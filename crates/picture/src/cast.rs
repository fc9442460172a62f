//! Casts between counts, samples and coordinates.

/// Returns a count as a coordinate.
#[expect(clippy::cast_precision_loss, reason = "counts of pixels and bytes, far below 2^53")]
pub(crate) fn float(count: usize) -> f64 {
    count as f64
}

/// Returns the integer at or below `x`, 0 for a negative number.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a float saturates when it is cast"
)]
pub(crate) fn floor(x: f64) -> usize {
    x as usize
}

/// Rounds a coordinate to the precision of a layer.
#[expect(clippy::cast_possible_truncation, reason = "pictures need no more digits")]
pub(crate) fn single(x: f64) -> f32 {
    x as f32
}

/// Returns a channel in `0.0..=1.0` as a byte.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a float saturates when it is cast"
)]
pub(crate) fn byte(channel: f64) -> u8 {
    (channel * 255.0 + 0.5) as u8
}
