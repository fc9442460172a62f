//! Sums of products of differences, exactly, as floating-point expansions.
//!
//! Source: J. R. Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric
//! Predicates", Discrete & Computational Geometry 18, 1997, section 2.

use glam::DVec3;

use crate::predicates::Sign;

/// Returns the sign of `(q − p) × (s − r)` in a coordinate plane.
///
/// Exact where no partial product overflows or vanishes: coordinates that are zero or between
/// 1e-90 and 1e90 in size.
pub(crate) fn sign_of_difference_cross([p, q]: [[f64; 2]; 2], [r, s]: [[f64; 2]; 2]) -> Sign {
    // 2 × 4 products of 2 terms each.
    let mut sum = Expansion::<16>::ZERO;
    sum.add_product_of_differences([q[0], p[0]], [s[1], r[1]], 1.0);
    sum.add_product_of_differences([q[1], p[1]], [s[0], r[0]], -1.0);
    sum.sign()
}

/// Computes `((b − a) × (c − a)) · (p − a)` to the last digit or two, however much of it cancels.
///
/// Exact sums are of the coordinates that [`sign_of_difference_cross`] takes.
pub(crate) fn exact_height([a, b, c]: [DVec3; 3], p: DVec3) -> f64 {
    // 6 × 8 products of 4 terms each.
    let mut sum = Expansion::<192>::ZERO;
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let height = two_sum(p[i], -a[i]);
        sum.add_product_of_three(two_sum(b[j], -a[j]), two_sum(c[k], -a[k]), height, 1.0);
        sum.add_product_of_three(two_sum(b[k], -a[k]), two_sum(c[j], -a[j]), height, -1.0);
    }
    sum.value()
}

/// A number as the exact sum of nonoverlapping doubles, in ascending order of size.
struct Expansion<const N: usize> {
    /// Room for as many as are added.
    terms: [f64; N],
    count: usize,
}

impl<const N: usize> Expansion<N> {
    const ZERO: Self = Self { terms: [0.0; N], count: 0 };

    /// Adds `sign a b c`, each the sum of two numbers.
    fn add_product_of_three(&mut self, a: [f64; 2], b: [f64; 2], c: [f64; 2], sign: f64) {
        for x in a {
            for y in b {
                for part in two_product(sign * x, y) {
                    for z in c {
                        let [high, low] = two_product(part, z);
                        self.add(low);
                        self.add(high);
                    }
                }
            }
        }
    }

    /// Adds `sign (a₁ − a₀) (b₁ − b₀)`, for `[a₁, a₀]` and `[b₁, b₀]`.
    fn add_product_of_differences(&mut self, a: [f64; 2], b: [f64; 2], sign: f64) {
        let a = two_sum(a[0], -a[1]);
        let b = two_sum(b[0], -b[1]);

        for x in a {
            for y in b {
                let [high, low] = two_product(sign * x, y);
                self.add(low);
                self.add(high);
            }
        }
    }

    /// Adds one number: Shewchuk's GROW-EXPANSION with the elimination of zeros.
    fn add(&mut self, number: f64) {
        // Add to the smallest term first; what rounding leaves of each sum is a term.
        let mut carry = number;
        let mut kept = 0;
        for i in 0..self.count {
            let [high, low] = two_sum(carry, self.terms[i]);
            carry = high;
            if low != 0.0 {
                self.terms[kept] = low;
                kept += 1;
            }
        }
        if carry != 0.0 {
            self.terms[kept] = carry;
            kept += 1;
        }
        self.count = kept;
    }

    /// Returns the sum, rounded: terms beyond the largest two hardly count.
    fn value(&self) -> f64 {
        self.terms[..self.count].iter().sum()
    }

    /// Returns the sign of the largest term, which is that of the sum.
    fn sign(&self) -> Sign {
        let largest = self.terms[..self.count].last().map_or(0.0, |term| *term);
        i32::from(largest > 0.0) - i32::from(largest < 0.0)
    }
}

/// Returns the rounded sum of two numbers and what rounding took from it.
fn two_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let b_part = sum - a;
    let a_part = sum - b_part;
    [sum, (a - a_part) + (b - b_part)]
}

/// Returns the rounded product of two numbers and what rounding took from it.
fn two_product(a: f64, b: f64) -> [f64; 2] {
    let product = a * b;
    let ([a_high, a_low], [b_high, b_low]) = (split(a), split(b));
    let rest = ((product - a_high * b_high) - a_low * b_high) - a_high * b_low;
    [product, a_low * b_low - rest]
}

/// Splits a number into two of half as many digits each (Dekker and Veltkamp).
fn split(a: f64) -> [f64; 2] {
    const SPLITTER: f64 = 134_217_729.0; // 2²⁷ + 1: half of the 53 digits, rounded up

    let scaled = SPLITTER * a;
    let high = scaled - (scaled - a);
    [high, a - high]
}

#[cfg(test)]
mod tests {
    use num_rational::BigRational;
    use num_traits::{Signed, Zero};

    use super::*;

    /// Random coordinates with ties planted by repetition, against rational arithmetic.
    #[test]
    fn the_sign_is_that_of_rational_arithmetic() {
        fixtures::generate::cases(21, 1000, |u| {
            let mut coordinate = || {
                let whole = f64::from(u.int_in_range(-3..=3_i32)?);
                let ulps = f64::from(u.int_in_range(-2..=2_i32)?) * f64::EPSILON;
                Ok(whole + ulps + f64::from(u.int_in_range(0..=1_i32)?) * 1e-17)
            };
            let mut point = || Ok([coordinate()?, coordinate()?]);
            let [p, q, r, s] = [point()?, point()?, point()?, point()?];
            let exact = |x: f64| BigRational::from_float(x).unwrap();
            let difference = |a: [f64; 2], b: [f64; 2], k: usize| exact(a[k]) - exact(b[k]);
            let cross = difference(q, p, 0) * difference(s, r, 1)
                - difference(q, p, 1) * difference(s, r, 0);
            let zero = BigRational::zero();
            let expected = i32::from(cross > zero) - i32::from(cross < zero);
            assert_eq!(
                sign_of_difference_cross([p, q], [r, s]),
                expected,
                "{p:?} {q:?} {r:?} {s:?}"
            );
            Ok(())
        });
    }

    /// Heights of points within ulps of a plane, and over slivers, against rational arithmetic.
    #[test]
    fn heights_keep_their_digits_where_they_cancel() {
        fixtures::generate::cases(23, 1000, |u| {
            let mut coordinate = || Ok(f64::from(u.arbitrary::<i32>()?) / 2.0_f64.powi(31));
            let mut point = || Ok(DVec3::new(coordinate()?, coordinate()?, coordinate()?));
            let ([a, b, off], p) = ([point()?, point()?, point()?], point()?);
            let c = a.lerp(b, coordinate()?) + off * 2.0_f64.powi(u.int_in_range(-60..=0)?);
            let p = a.lerp(b, 0.3).lerp(c, 0.4) + p * 2.0_f64.powi(u.int_in_range(-60..=0)?);

            let exact = |x: DVec3| x.to_array().map(|x| BigRational::from_float(x).unwrap());
            let from_a = |x: DVec3| {
                let (x, a) = (exact(x), exact(a));
                [0, 1, 2].map(|k| &x[k] - &a[k])
            };
            let [v, w, h] = [b, c, p].map(from_a);
            let mut height = BigRational::zero();
            for (i, h) in h.iter().enumerate() {
                let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                height += (&v[j] * &w[k] - &v[k] * &w[j]) * h;
            }
            let found = BigRational::from_float(exact_height([a, b, c], p)).unwrap();
            let ulps = BigRational::from_float(2.0 * f64::EPSILON).unwrap();
            let error = (&found - &height).abs();
            assert!(error <= ulps * height.abs(), "{found} for {height}");
            Ok(())
        });
    }
}
