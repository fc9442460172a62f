//! Roots of polynomials as isolating intervals, and signs at them.
//!
//! Times are integers over `2^120`. A root is either such a time or alone in an
//! open interval between two of them, told by the sign changes of Bernstein
//! coefficients (Descartes' rule: none means no root, one means one root).

use num_bigint::{BigInt, Sign};

use super::polynomial::Polynomial;

/// Times are multiples of `2^-RESOLUTION`.
const RESOLUTION: u32 = 120;
const ONE: u128 = 1 << RESOLUTION;

/// Width to which the root of a contact is narrowed: an ulp of times above
/// 1/256.
const NARROW: u128 = 1 << (RESOLUTION - 60);

/// Two roots, or a root and a time, are closer than times are resolved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Undecidable;

/// A root of a polynomial in an interval of time.
#[derive(Clone, Debug)]
pub(crate) struct Root {
    /// The polynomial, with each root once; none for a time that is given.
    polynomial: Option<Polynomial>,
    interval: Interval,
}

/// Ends of an interval, and Bernstein coefficients of a polynomial on it.
#[derive(Clone, Debug)]
struct Interval {
    lo: u128,
    /// The interval is open, but closed if it is one time.
    hi: u128,
    bernstein: Vec<BigInt>,
}

impl Root {
    /// A given time.
    pub(crate) fn at(time: u128) -> Self {
        let interval = Interval { lo: time, hi: time, bernstein: Vec::new() };
        Self { polynomial: None, interval }
    }

    pub(crate) fn start(&self) -> u128 {
        self.interval.lo
    }

    pub(crate) fn end(&self) -> u128 {
        self.interval.hi
    }

    pub(crate) fn is_start(&self) -> bool {
        self.interval.hi == 0
    }

    /// The interval in floating point, rounded outward.
    pub(crate) fn bounds(&self) -> (f64, f64) {
        (round_down(self.interval.lo), -round_down_negated(self.interval.hi))
    }

    /// Narrows the interval to about an ulp.
    pub(crate) fn narrow(&mut self) {
        self.narrow_to(NARROW);
    }

    /// Narrows the interval to a width: to the part in which a straight line
    /// between the ends is zero, twice as many digits shorter each time that
    /// the root is there, and by halves when it is not.
    ///
    /// Source: J. Abbott, "Quadratic interval refinement for real roots", ACM
    /// Communications in Computer Algebra 48, 2014.
    fn narrow_to(&mut self, width: u128) {
        let mut digits = 2;
        while self.interval.width() > width {
            let most = (self.interval.width() / width).ilog2().min(MOST_DIGITS_AT_ONCE);
            if self.jump(most.min(digits)) {
                digits *= 2;
            } else {
                self.interval.halve();
                digits = (digits / 2).max(1);
            }
        }
    }

    /// Moves to the part that is `2^digits` times shorter and holds the zero of
    /// the line between the ends, if the root is there.
    fn jump(&mut self, digits: u32) -> bool {
        let Some(polynomial) = &self.polynomial else { return false };
        let Interval { lo, hi, bernstein } = &self.interval;
        let part = (hi - lo) >> digits;
        let from = lo + part * zero_of_line(bernstein, digits);
        let to = from + part;
        let shorter = Interval::of(polynomial, from, to);
        if from > *lo && shorter.starts_at_root() {
            self.interval = Interval::time(from);
        } else if shorter.sign_changes() % 2 == 1 {
            self.interval = shorter;
        } else {
            return false;
        }
        true
    }
}

/// Digits by which an interval is narrowed at once, so that a part of it is
/// found in floating point.
const MOST_DIGITS_AT_ONCE: u32 = 40;

/// Which of `2^digits` parts holds the zero of the line between the first and
/// the last value, which differ in sign or are zero.
fn zero_of_line(values: &[BigInt], digits: u32) -> u128 {
    let (first, last) = (&values[0], &values[values.len() - 1]);
    let spare = first.bits().max(last.bits()).saturating_sub(LEADING_DIGITS);
    let leading = |x: &BigInt| i64::try_from(x >> spare).unwrap_or(0).unsigned_abs();
    let (first, last) = (u128::from(leading(first)), u128::from(leading(last)));
    let parts = 1 << digits;
    ((first * parts) / (first + last).max(1)).min(parts - 1)
}

/// Digits of values that are compared: with as many digits of the parts, their
/// product fits.
const LEADING_DIGITS: u64 = 60;

impl Interval {
    fn of(polynomial: &Polynomial, lo: u128, hi: u128) -> Self {
        Self { lo, hi, bernstein: polynomial.bernstein(lo, hi, RESOLUTION) }
    }

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

    /// Sign changes of the coefficients, zeros left out.
    fn sign_changes(&self) -> usize {
        let mut signs = self.bernstein.iter().map(BigInt::sign).filter(|&s| s != Sign::NoSign);
        let mut last = signs.next();
        signs.filter(|&sign| last.replace(sign) != Some(sign)).count()
    }

    fn is_time(&self) -> bool {
        self.lo == self.hi
    }

    fn middle(&self) -> u128 {
        self.lo + (self.hi - self.lo) / 2
    }

    /// Both halves, by de Casteljau's scheme; needs an even width.
    fn halves(&self) -> (Self, Self) {
        let mut row = self.bernstein.clone();
        let degree = row.len() - 1;
        let (mut left, mut right) = (Vec::new(), Vec::new());
        for k in 0..=degree {
            left.push(&row[0] << (degree - k));
            right.push(&row[degree - k] << (degree - k));
            for i in 0..degree - k {
                row[i] = &row[i] + &row[i + 1];
            }
        }
        right.reverse();
        let middle = self.middle();
        (
            Self { lo: self.lo, hi: middle, bernstein: left },
            Self { lo: middle, hi: self.hi, bernstein: right },
        )
    }

    /// Moves one end of the interval of a single root to the middle, or both.
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

/// Roots of a polynomial that is not zero, in `lo..=hi`, ascending.
pub(crate) fn isolate(
    polynomial: &Polynomial,
    lo: u128,
    hi: u128,
) -> Result<Vec<Root>, Undecidable> {
    let (lo, hi) = with_even_halves(lo, hi);
    let mut polynomial = polynomial.clone();
    let mut whole = Interval::of(&polynomial, lo, hi);
    if whole.sign_changes() > 1 {
        polynomial = polynomial.square_free();
        whole = Interval::of(&polynomial, lo, hi);
    }
    let mut roots = Vec::new();
    let mut push = |interval| {
        roots.push(Root { polynomial: Some(polynomial.clone()), interval });
    };
    if whole.starts_at_root() {
        push(Interval::time(lo));
    }
    let ends_at_root = whole.ends_at_root();
    let mut open = vec![whole];
    while let Some(interval) = open.pop() {
        if interval.is_time() {
            push(interval);
            continue;
        }
        match interval.sign_changes() {
            0 => {}
            1 => push(interval),
            _ if interval.width() < 2 => return Err(Undecidable),
            _ => {
                let (left, right) = interval.halves();
                let middle = right.starts_at_root().then(|| Interval::time(right.lo));
                open.push(right);
                open.extend(middle);
                open.push(left);
            }
        }
    }
    if ends_at_root && lo < hi {
        push(Interval::time(hi));
    }
    Ok(roots)
}

/// Widens an interval to a width that is a power of two, so that it can be
/// halved down to the resolution, and keeps it in `0..=1`.
fn with_even_halves(lo: u128, hi: u128) -> (u128, u128) {
    if lo == hi {
        return (lo, hi);
    }
    let width = (hi - lo).next_power_of_two();
    let lo = lo.min(ONE - width);
    (lo, lo + width)
}

/// Sign of a polynomial at a root of another one. The root's interval is
/// narrowed as far as that needs.
pub(crate) fn sign_at(polynomial: &Polynomial, root: &mut Root) -> Result<Sign, Undecidable> {
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
        if interval.is_time() || may_be_shared && root.is_shared_with(polynomial) {
            return Ok(Sign::NoSign);
        }
        may_be_shared = false;
        let width = root.interval.width();
        if width < 2 {
            return Err(Undecidable);
        }
        root.narrow_to((width >> DIGITS_BETWEEN_LOOKS).max(1));
    }
}

/// Binary digits by which a root is narrowed between two looks at a sign.
const DIGITS_BETWEEN_LOOKS: u32 = 12;

/// The sign that all values have, if they have one.
fn common_sign(values: &[BigInt]) -> Option<Sign> {
    let first = values[0].sign();
    (first != Sign::NoSign && values.iter().all(|v| v.sign() == first)).then_some(first)
}

impl Root {
    /// Whether the root is one of `other` too: then it is one of the common
    /// divisor, which has no other root in the interval and none twice.
    fn is_shared_with(&self, other: &Polynomial) -> bool {
        let Some(polynomial) = &self.polynomial else { return false };
        let common = polynomial.common_divisor(other);
        if common.is_constant() {
            return false;
        }
        Interval::of(&common, self.interval.lo, self.interval.hi).sign_changes() % 2 == 1
    }
}

/// `time` in fractions of the resolution, rounded down.
pub(crate) fn floor(time: f64) -> u128 {
    scaled(time)
}

/// `time` in fractions of the resolution, rounded up.
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

#[expect(clippy::cast_precision_loss, reason = "compared with what was rounded")]
fn round_down(time: u128) -> f64 {
    let near = time as f64 / TWO_TO_RESOLUTION;
    if scaled(near) > time { near.next_down() } else { near }
}

#[expect(clippy::cast_precision_loss, reason = "compared with what was rounded")]
fn round_down_negated(time: u128) -> f64 {
    let near = time as f64 / TWO_TO_RESOLUTION;
    if scaled(near) < time { -near.next_up() } else { -near }
}
