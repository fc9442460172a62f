//! Polynomials with integer coefficients, their greatest common divisors and Bernstein form.

use std::ops::{Add, Mul, Sub};

use num_bigint::BigInt;
pub(crate) use num_bigint::Sign;

/// Polynomial: coefficients from the constant one up, without leading zeros.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Polynomial(Vec<BigInt>);

impl Polynomial {
    fn new(mut coefficients: Vec<BigInt>) -> Self {
        while coefficients.last().is_some_and(|c| c.sign() == Sign::NoSign) {
            coefficients.pop();
        }
        Self(coefficients)
    }

    /// Creates the polynomial of degree 1 with these values at 0 and 1.
    pub(crate) fn linear(at_0: BigInt, at_1: &BigInt) -> Self {
        let slope = at_1 - &at_0;
        Self::new(vec![at_0, slope])
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.0.is_empty()
    }

    pub(crate) fn is_constant(&self) -> bool {
        self.0.len() < 2
    }

    pub(crate) fn derivative(&self) -> Self {
        Self(self.0.iter().enumerate().skip(1).map(|(i, c)| c * i).collect())
    }

    /// Computes the Bernstein coefficients on `lo..=hi`, fractions of `2^shift`, up to a positive
    /// factor.
    ///
    /// The degree must be 3 or less.
    pub(crate) fn bernstein(&self, lo: u128, hi: u128, shift: u32) -> Vec<BigInt> {
        // Ends that are short fractions keep the numbers short.
        let spare = (lo | hi).trailing_zeros().min(shift);
        let (lo, hi, shift) = (lo >> spare, hi >> spare, shift - spare);

        // q(s) = p((lo + s (hi - lo)) / 2^shift) 2^(shift degree): the argument is shifted by
        // synthetic division, then each coefficient takes a power of the width.
        let mut c = self.0.clone();
        let degree = c.len().saturating_sub(1);
        for (i, c) in c.iter_mut().enumerate() {
            *c <<= shift as usize * (degree - i);
        }
        for i in 0..degree {
            for j in (i..degree).rev() {
                let carried = &c[j + 1] * lo;
                c[j] += carried;
            }
        }
        let mut power = BigInt::from(1);
        for c in &mut c {
            *c *= &power;
            power *= hi - lo;
        }
        without_common_twos(bernstein_of_powers(&c))
    }

    /// Returns the square-free part, which has each root once.
    pub(crate) fn square_free(&self) -> Self {
        let repeated = self.common_divisor(&self.derivative());
        if repeated.is_constant() { self.clone() } else { self.divided_by(&repeated) }
    }

    /// Computes the greatest common divisor by Euclid's algorithm, up to a factor.
    pub(crate) fn common_divisor(&self, other: &Self) -> Self {
        let (mut a, mut b) = (self.clone(), other.clone());
        if a.0.len() < b.0.len() {
            std::mem::swap(&mut a, &mut b);
        }

        // A common divisor of both is one of the remainder, which has a lower degree.
        while !b.is_zero() {
            let remainder = a.remainder(&b);
            a = b;
            b = remainder.shortened();
        }
        a
    }

    /// Computes `self` modulo `divisor`, up to a factor.
    fn remainder(&self, divisor: &Self) -> Self {
        let mut rest = self.clone();
        while rest.0.len() >= divisor.0.len() {
            rest.cancel_leading(divisor);
        }
        rest
    }

    /// Divides by a divisor of the polynomial, up to a factor.
    fn divided_by(&self, divisor: &Self) -> Self {
        let mut rest = self.clone();
        let mut quotient = vec![BigInt::ZERO; self.0.len() + 1 - divisor.0.len()];
        while rest.0.len() >= divisor.0.len() {
            let degree = rest.0.len() - divisor.0.len();
            let leading = rest.0[rest.0.len() - 1].clone();
            // The rest is scaled as its leading term is cancelled, so the quotient is, too.
            for q in &mut quotient {
                *q *= &divisor.0[divisor.0.len() - 1];
            }
            quotient[degree] += leading;
            rest.cancel_leading(divisor);
        }
        Self::new(quotient).shortened()
    }

    /// Multiplies by the leading coefficient of `divisor` and subtracts the multiple of it that
    /// cancels the leading term.
    fn cancel_leading(&mut self, divisor: &Self) {
        let degree = self.0.len() - divisor.0.len();
        let Some(leading) = self.0.pop() else { return };
        let factor = &divisor.0[divisor.0.len() - 1];
        for c in &mut self.0 {
            *c *= factor;
        }
        for (c, d) in self.0[degree..].iter_mut().zip(&divisor.0) {
            *c -= &leading * d;
        }
        *self = Self::new(std::mem::take(&mut self.0));
    }

    /// Divides all coefficients by their largest common power of two.
    ///
    /// Their greatest common divisor would cost more than the digits it saves.
    fn shortened(self) -> Self {
        Self(without_common_twos(self.0))
    }
}

/// Converts powers to Bernstein coefficients on `0..=1`, times 1, 1, 2 or 3.
fn bernstein_of_powers(c: &[BigInt]) -> Vec<BigInt> {
    match c {
        [c0, c1] => vec![c0.clone(), c0 + c1],
        [c0, c1, c2] => vec![c0 * 2, c0 * 2 + c1, (c0 + c1 + c2) * 2],
        [c0, c1, c2, c3] => {
            vec![c0 * 3, c0 * 3 + c1, c0 * 3 + c1 * 2 + c2, (c0 + c1 + c2 + c3) * 3]
        }
        constant => constant.to_vec(),
    }
}

/// Divides all values by their largest common power of two.
fn without_common_twos(mut values: Vec<BigInt>) -> Vec<BigInt> {
    let twos = values.iter().filter_map(BigInt::trailing_zeros).min().unwrap_or(0);
    for value in &mut values {
        *value >>= twos;
    }
    values
}

impl Add for &Polynomial {
    type Output = Polynomial;

    fn add(self, other: Self) -> Polynomial {
        let (long, short) =
            if self.0.len() < other.0.len() { (other, self) } else { (self, other) };
        let mut sum = long.0.clone();
        for (sum, c) in sum.iter_mut().zip(&short.0) {
            *sum += c;
        }
        Polynomial::new(sum)
    }
}

impl Sub for &Polynomial {
    type Output = Polynomial;

    fn sub(self, other: Self) -> Polynomial {
        let mut difference = self.0.clone();
        difference.resize(self.0.len().max(other.0.len()), BigInt::ZERO);
        for (difference, c) in difference.iter_mut().zip(&other.0) {
            *difference -= c;
        }
        Polynomial::new(difference)
    }
}

impl Mul for &Polynomial {
    type Output = Polynomial;

    fn mul(self, other: Self) -> Polynomial {
        if self.is_zero() || other.is_zero() {
            return Polynomial(Vec::new());
        }
        let mut product = vec![BigInt::ZERO; self.0.len() + other.0.len() - 1];
        for (i, a) in self.0.iter().enumerate() {
            for (j, b) in other.0.iter().enumerate() {
                product[i + j] += a * b;
            }
        }
        Polynomial(product)
    }
}
