//! Constants of the rounding bounds, each a line of `docs/ccd-error-analysis.md`.
//!
//! All are relative to sums of absolute products (permanents) of coordinate *differences*, so that
//! neither units nor an offset of the scene matters. The tests compare each with exact
//! arithmetic. A constant smaller than the proof allows would lose contacts; a larger one makes more
//! contacts merely possible, and more times early.

/// Unit roundoff `u` of `f64`, 2^-53.
pub(crate) const UNIT: f64 = f64::EPSILON / 2.0;

/// Error of a direction test, per unit of `sum |m_k| Q_k` (lemma 1: 7 u).
pub(crate) const DIRECTION: f64 = 8.0 * UNIT;

/// Error of a projection onto a turning direction, per unit of the sum of `Q_k` times the larger
/// `|m_k|` (lemma 1: 8 u).
pub(crate) const TURNING: f64 = 10.0 * UNIT;

/// Error of the height of a corner over an area vector, per unit of `sum B_k (Q_k + X_k + Y_k)`
/// (lemma 2: 11 u).
pub(crate) const AREA_DIRECTION: f64 = 14.0 * UNIT;

/// Error of a Bernstein coefficient of the coplanarity cubic, per unit of its permanent (lemma 3:
/// 12 u).
pub(crate) const COPLANARITY: f64 = 13.0 * UNIT;

/// Error of a computed area vector of the polygon, per unit of its permanent (lemma 3: 5 u).
pub(crate) const NORMAL: f64 = 6.0 * UNIT;

/// Error of the sub-interval coefficients or of a value of *given* Bernstein coefficients, per unit
/// of the largest (lemma 4: 9 u).
pub(crate) const SUBDIVISION: f64 = 10.0 * UNIT;

/// Error of an edge function at a time, per unit of `sum |n_k| Q_i Q_j` (lemma 5: 210 u).
pub(crate) const EDGE_FUNCTION: f64 = 256.0 * UNIT;

/// Change of an edge function from the middle of an interval to its ends, per unit of its length and
/// of `sum |n_k| Q_i Q_j` (lemma 5: 6).
pub(crate) const EDGE_FUNCTION_RATE: f64 = 8.0;

/// Factor that makes the product of a separation and a computed length an upper bound (lemma 1, with
/// a separation: 6 u).
pub(crate) const LENGTH_UP: f64 = 1.0 + 8.0 * UNIT;

/// Allowance of every bound for underflow: 2^-960.
///
/// Coordinates are scaled into `2^-64..2^64` first, where all underflow together stays below
/// 2^-1000 (lemma 6). Nothing of size 1 is that close.
pub(crate) const UNDERFLOW: f64 = power_of_two(-960);

/// Allowance of computed lengths for the underflow of their squares: 2^-536.
///
/// Three squares that underflow are off by less than 3 · 2^-1075 together, and the root of that is
/// below this.
pub(crate) const LENGTH_UNDERFLOW: f64 = power_of_two(-536);

/// Largest coordinate difference below which a query is scaled up.
pub(crate) const SMALL: f64 = power_of_two(-64);

/// Largest coordinate difference above which a query is scaled down.
pub(crate) const LARGE: f64 = power_of_two(64);

/// Returns `2^exponent`, for a normal result.
pub(crate) const fn power_of_two(exponent: i32) -> f64 {
    assert!(-1022 <= exponent && exponent <= 1023, "the power is a normal number");
    f64::from_bits(biased(exponent) << 52)
}

#[expect(clippy::cast_sign_loss, reason = "the biased exponent of a normal number is positive")]
const fn biased(exponent: i32) -> u64 {
    (exponent + 1023) as u64
}

/// Returns the exponent `e` of a positive finite number in `2^e <= x < 2^(e + 1)`; subnormal numbers
/// count as the smallest normal one.
pub(crate) fn exponent(x: f64) -> i32 {
    let biased = u16::try_from((x.to_bits() >> 52) & 0x7ff).unwrap_or(0);
    i32::from(biased.max(1)) - 1023
}

#[cfg(test)]
mod tests;
