//! Isolating intervals of the roots of polynomials, and signs of polynomials at them.
//!
//! Times are integers over `2^120`. A root is either such a time or the only one in an open interval
//! between two of them, by the sign changes of Bernstein coefficients (Descartes' rule of signs: no
//! change means no root, one change means one root).

use num_bigint::{BigInt, Sign};

use super::polynomial::Polynomial;

/// Times are multiples of `2^-RESOLUTION`.
pub(super) const RESOLUTION: u32 = 120;
pub(super) const ONE: u128 = 1 << RESOLUTION;

/// Width to which the root of a contact is narrowed: an ulp of times above 1/256.
const NARROW: u128 = 1 << (RESOLUTION - 60);

/// Maximum number of digits by which an interval is narrowed at once, so that a part of it can be
/// found in floating point.
const MAX_DIGITS_AT_ONCE: u32 = 40;

/// Digits of values that are compared: with as many digits of the parts, their product fits.
const LEADING_DIGITS: u64 = 60;

/// Binary digits by which a root is narrowed before a sign is evaluated again.
const DIGITS_PER_SIGN: u32 = 12;

/// Error: two roots, or a root and a time, are closer than times are resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unresolved {
    /// The roots are between this time and the next one.
    pub(crate) at: u128,
}

/// Closed interval of times that holds a root.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct TimeBounds {
    pub(crate) lo: u128,
    pub(crate) hi: u128,
}

/// Root of a polynomial in an interval of time.
#[derive(Clone, Debug)]
pub(crate) struct Root {
    /// The square-free polynomial; none for a given time.
    polynomial: Option<Polynomial>,
    interval: Interval,
}

/// Open interval, or a single time, with the Bernstein coefficients of a polynomial on it.
#[derive(Clone, Debug)]
struct Interval {
    lo: u128,
    hi: u128,
    bernstein: Vec<BigInt>,
}

impl Root {
    /// Returns a given time as a root.
    pub(crate) fn at(time: u128) -> Self {
        Self { polynomial: None, interval: Interval::time(time) }
    }

    pub(crate) fn start(&self) -> u128 {
        self.interval.lo
    }

    pub(crate) fn end(&self) -> u128 {
        self.interval.hi
    }

    /// Returns the interval with its ends.
    pub(crate) fn bounds(&self) -> TimeBounds {
        TimeBounds { lo: self.interval.lo, hi: self.interval.hi }
    }

    /// Narrows the interval to about an ulp.
    pub(crate) fn narrow(&mut self) {
        self.narrow_to(NARROW);
    }

    /// Narrows the interval to a width by quadratic interval refinement.
    ///
    /// It moves to the part in which a straight line between the ends is zero. That part is twice as
    /// many digits shorter each time that the root is in it; otherwise the interval is halved.
    ///
    /// Source: J. Abbott, "Quadratic interval refinement for real roots", ACM
    /// Communications in Computer Algebra 48, 2014.
    fn narrow_to(&mut self, width: u128) {
        let mut digits = 2;
        while self.interval.width() > width {
            let max = (self.interval.width() / width).ilog2().min(MAX_DIGITS_AT_ONCE);
            if self.jump(max.min(digits)) {
                digits *= 2;
            } else {
                self.interval.halve();
                digits = (digits / 2).max(1);
            }
        }
    }

    /// Moves to the part that is `2^digits` times shorter and contains the zero of the line between
    /// the ends, and returns true, if the root is there.
    fn jump(&mut self, digits: u32) -> bool {
        let Some(polynomial) = &self.polynomial else { return false };

        let Interval { lo, hi, bernstein } = &self.interval;
        let part = (hi - lo) >> digits;
        let from = lo + part * zero_of_line(bernstein, digits);
        let to = from + part;

        // An odd number of sign changes proves that the only root is in the part.
        let shorter = Interval::new(polynomial, from, to);
        if from > *lo && shorter.starts_at_root() {
            self.interval = Interval::time(from);
        } else if shorter.sign_changes() % 2 == 1 {
            self.interval = shorter;
        } else {
            return false;
        }
        true
    }

    /// Returns true if the root is one of `other` too.
    ///
    /// Then it is one of the common divisor, which has no other root in the interval and no double
    /// root.
    fn is_shared_with(&self, other: &Polynomial) -> bool {
        let Some(polynomial) = &self.polynomial else { return false };
        let common = polynomial.common_divisor(other);
        if common.is_constant() {
            return false;
        }
        Interval::new(&common, self.interval.lo, self.interval.hi).sign_changes() % 2 == 1
    }
}

impl TimeBounds {
    /// Returns true if the root is at time 0.
    pub(crate) fn is_start(self) -> bool {
        self.hi == 0
    }

    /// Returns the ends in floating point, rounded outward.
    pub(crate) fn rounded(self) -> (f64, f64) {
        (round_down(self.lo), round_up(self.hi))
    }
}

/// Finds which of `2^digits` parts contains the zero of the line between the first and the last
/// value, which differ in sign or are zero.
fn zero_of_line(values: &[BigInt], digits: u32) -> u128 {
    let (first, last) = (&values[0], &values[values.len() - 1]);
    // The leading digits are enough for a hint.
    let spare = first.bits().max(last.bits()).saturating_sub(LEADING_DIGITS);
    let leading = |x: &BigInt| i64::try_from(x >> spare).unwrap_or(0).unsigned_abs();
    let (first, last) = (u128::from(leading(first)), u128::from(leading(last)));
    let parts = 1 << digits;
    ((first * parts) / (first + last).max(1)).min(parts - 1)
}

impl Interval {
    fn new(polynomial: &Polynomial, lo: u128, hi: u128) -> Self {
        Self { lo, hi, bernstein: polynomial.bernstein(lo, hi, RESOLUTION) }
    }

    /// Returns a single time.
    fn time(at: u128) -> Self {
        Self { lo: at, hi: at, bernstein: Vec::new() }
    }

    fn width(&self) -> u128 {
        self.hi - self.lo
    }

    fn starts_at_root(&self) -> bool {
        self.bernstein.first().is_some_and(|b| b.sign() == Sign::NoSign)
    }

    fn ends_at_root(&self) -> bool {
        self.bernstein.last().is_some_and(|b| b.sign() == Sign::NoSign)
    }

    /// Counts the sign changes of the coefficients, without zeros.
    fn sign_changes(&self) -> usize {
        let mut changes = 0;
        let mut last = Sign::NoSign;
        for sign in self.bernstein.iter().map(BigInt::sign).filter(|&s| s != Sign::NoSign) {
            changes += usize::from(last != Sign::NoSign && sign != last);
            last = sign;
        }
        changes
    }

    fn is_time(&self) -> bool {
        self.lo == self.hi
    }

    /// Splits the interval in the middle by de Casteljau's scheme; its width must be even.
    fn halves(&self) -> (Self, Self) {
        let mut row = self.bernstein.clone();
        let degree = row.len() - 1;
        let (mut left, mut right) = (Vec::new(), Vec::new());

        // Sums stand for means, so each row is scaled by another power of two.
        for k in 0..=degree {
            left.push(&row[0] << (degree - k));
            right.push(&row[degree - k] << (degree - k));
            for i in 0..degree - k {
                row[i] = &row[i] + &row[i + 1];
            }
        }
        right.reverse();

        let middle = self.lo + self.width() / 2;
        let left = Self { lo: self.lo, hi: middle, bernstein: left };
        (left, Self { lo: middle, hi: self.hi, bernstein: right })
    }

    /// Moves one end of the interval of a single root to the middle, or both if the root is there.
    fn halve(&mut self) {
        if self.is_time() {
            return;
        }
        let (left, right) = self.halves();
        *self = if right.starts_at_root() {
            Self::time(right.lo)
        } else if left.sign_changes() % 2 == 1 {
            left
        } else {
            right
        };
    }
}

/// Isolates the roots in `lo..=hi` of a polynomial that is not zero, in ascending order.
pub(crate) fn isolate(
    polynomial: &Polynomial,
    lo: u128,
    hi: u128,
) -> Result<Vec<Root>, Unresolved> {
    let (lo, hi) = with_even_halves(lo, hi);

    // Intervals around a multiple root would be halved without end.
    let mut polynomial = polynomial.clone();
    let mut whole = Interval::new(&polynomial, lo, hi);
    if whole.sign_changes() > 1 {
        polynomial = polynomial.square_free();
        whole = Interval::new(&polynomial, lo, hi);
    }

    let mut isolated = Vec::new();
    if whole.starts_at_root() {
        isolated.push(Interval::time(lo));
    }
    let ends_at_root = whole.ends_at_root();
    isolate_inside(whole, &mut isolated)?;
    if ends_at_root && lo < hi {
        isolated.push(Interval::time(hi));
    }

    let root = |interval| Root { polynomial: Some(polynomial.clone()), interval };
    Ok(isolated.into_iter().map(root).collect())
}

/// Halves an open interval until each part has at most one root, and appends those with one.
fn isolate_inside(whole: Interval, isolated: &mut Vec<Interval>) -> Result<(), Unresolved> {
    // The earliest part is on top of the stack.
    let mut open = vec![whole];
    while let Some(interval) = open.pop() {
        if interval.is_time() {
            isolated.push(interval);
            continue;
        }
        match interval.sign_changes() {
            0 => {}
            1 => isolated.push(interval),
            _ if interval.width() < 2 => return Err(Unresolved { at: interval.lo }),
            _ => {
                let (left, right) = interval.halves();
                let middle = right.starts_at_root().then(|| Interval::time(right.lo));
                open.push(right);
                open.extend(middle);
                open.push(left);
            }
        }
    }
    Ok(())
}

/// Widens an interval to a width that is a power of two, so that it can be halved down to the
/// resolution, and keeps it in `0..=1`.
fn with_even_halves(lo: u128, hi: u128) -> (u128, u128) {
    if lo == hi {
        return (lo, hi);
    }
    let width = (hi - lo).next_power_of_two();
    let lo = lo.min(ONE - width);
    (lo, lo + width)
}

/// Evaluates the sign of a polynomial at a root of another one, and narrows the interval of the root
/// as far as necessary.
pub(crate) fn sign_at(polynomial: &Polynomial, root: &mut Root) -> Result<Sign, Unresolved> {
    if polynomial.is_zero() {
        return Ok(Sign::NoSign);
    }
    let mut may_be_shared = true;
    loop {
        let interval = &root.interval;
        let values = polynomial.bernstein(interval.lo, interval.hi, RESOLUTION);
        if let Some(sign) = common_sign(&values) {
            return Ok(sign);
        }

        // Without a common sign the root is one of both polynomials, or its interval is too wide.
        if interval.is_time() || may_be_shared && root.is_shared_with(polynomial) {
            return Ok(Sign::NoSign);
        }
        may_be_shared = false;

        let width = root.interval.width();
        if width < 2 {
            return Err(Unresolved { at: root.interval.lo });
        }
        root.narrow_to((width >> DIGITS_PER_SIGN).max(1));
    }
}

/// Returns the sign that all values have, if they have one.
fn common_sign(values: &[BigInt]) -> Option<Sign> {
    let first = values[0].sign();
    (first != Sign::NoSign && values.iter().all(|v| v.sign() == first)).then_some(first)
}

/// Converts a time to fractions of the resolution, rounded down.
pub(crate) fn floor(time: f64) -> u128 {
    scaled(time)
}

/// Converts a time to fractions of the resolution, rounded up.
pub(crate) fn ceil(time: f64) -> u128 {
    (scaled(time) + 1).min(ONE)
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a time in 0..=1 has at most 121 digits, and the cast rounds down"
)]
fn scaled(time: f64) -> u128 {
    (time.clamp(0.0, 1.0) * TWO_TO_RESOLUTION) as u128
}

const TWO_TO_RESOLUTION: f64 = crate::rounding::power_of_two(120);

/// Converts fractions of the resolution to a time, rounded down.
fn round_down(time: u128) -> f64 {
    let near = rounded(time);
    if scaled(near) > time { near.next_down() } else { near }
}

/// Converts fractions of the resolution to a time, rounded up.
fn round_up(time: u128) -> f64 {
    let near = rounded(time);
    if scaled(near) < time { near.next_up() } else { near }
}

#[expect(clippy::cast_precision_loss, reason = "the caller compares the result with the time")]
fn rounded(time: u128) -> f64 {
    time as f64 / TWO_TO_RESOLUTION
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times of more digits than a float holds are between two floats, next to each other.
    #[test]
    fn ends_are_rounded_outward() {
        let (mut odd, mut rounded) = (1_u128, 0);
        for _ in 0..10_000 {
            odd = odd.wrapping_mul(0x2360_ED05_1FC6_5DA4_4385_DF64_9FCC_F645).wrapping_add(1);
            for time in [odd >> 8, odd >> (8 + odd % 100), ONE - (odd >> 60)] {
                let bounds = TimeBounds { lo: time, hi: time };
                let (lo, hi) = bounds.rounded();
                assert!(scaled(lo) <= time && time <= scaled(hi), "{time}: {lo}, {hi}");
                assert!(lo <= hi && hi <= lo.next_up(), "{time}: {lo}, {hi}");
                rounded += u32::from(hi > lo);
            }
        }
        assert!(rounded > 15_000, "{rounded}");
        assert_eq!(TimeBounds { lo: 0, hi: ONE }.rounded(), (0.0, 1.0));
    }
}
