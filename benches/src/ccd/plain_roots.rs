//! Roots of a cubic in plain arithmetic, without certificates.

/// Roots found by [`roots`], ascending.
#[derive(Clone, Copy, Debug)]
pub struct PlainRoots {
    times: [f64; 3],
    count: usize,
}

impl std::ops::Deref for PlainRoots {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.times[..self.count]
    }
}

/// Solves a cubic given by its Bernstein coefficients on `0..=1`: sign changes between its critical
/// points, each narrowed by Newton steps within a bracket.
///
/// Nothing is certified. A double root, a root at an end and one of a polynomial that rounding has
/// flattened may be missed, and a time may be on either side of the exact one.
///
/// Source: C. Yuksel, "High-performance polynomial root finding for graphics", Proc. ACM CGIT 5(3),
/// 2022.
#[must_use]
pub fn roots([b0, b1, b2, b3]: [f64; 4]) -> PlainRoots {
    let powers = [b0, 3.0 * (b1 - b0), 3.0 * (b2 - 2.0 * b1 + b0), b3 - b0 - 3.0 * (b2 - b1)];
    let mut found = PlainRoots { times: [0.0; 3], count: 0 };
    let mut lo = 0.0;
    let critical = quadratic_roots(powers[1], 2.0 * powers[2], 3.0 * powers[3]);
    for hi in critical.into_iter().filter(|t| 0.0 < *t && *t < 1.0).chain([1.0]) {
        if let Some(t) = crossing(powers, lo, hi) {
            found.times[found.count] = t;
            found.count += 1;
        }
        lo = hi;
    }
    found
}

/// Solves `c + b t + a t^2 = 0`; the roots are ascending, and NaN or infinite where there is none.
fn quadratic_roots(c: f64, b: f64, a: f64) -> [f64; 2] {
    let q = -0.5 * (b + (b * b - 4.0 * a * c).sqrt().copysign(b));
    let (x, y) = (q / a, c / q);
    if x < y { [x, y] } else { [y, x] }
}

/// Finds the crossing of a cubic that is monotone on `lo..=hi`, if its ends differ in sign.
fn crossing([c0, c1, c2, c3]: [f64; 4], mut lo: f64, mut hi: f64) -> Option<f64> {
    let value = |t: f64| ((c3 * t + c2) * t + c1) * t + c0;
    let (at_lo, at_hi) = (value(lo), value(hi));
    if at_lo * at_hi > 0.0 || at_lo.abs() + at_hi.abs() <= 0.0 {
        return None;
    }

    // Newton steps from the zero of the secant, bisections where they leave the bracket.
    let mut t = lo + (hi - lo) * (at_lo / (at_lo - at_hi));
    for _ in 0..60 {
        let f = value(t);
        if (f < 0.0) == (at_lo < 0.0) {
            lo = t;
        } else {
            hi = t;
        }
        let newton = t - f / ((3.0 * c3 * t + 2.0 * c2) * t + c1);
        let next = if lo <= newton && newton <= hi { newton } else { 0.5 * (lo + hi) };
        let step = (next - t).abs();
        t = next;
        if step <= f64::EPSILON {
            break;
        }
    }
    Some(t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_roots_are_found() {
        // 8 (t - 1/4) (t - 1/2) (t - 3/4)
        let found = roots([-0.75, 13.0 / 12.0, -13.0 / 12.0, 0.75]);
        assert_eq!(found.len(), 3);
        for (t, root) in found.iter().zip([0.25, 0.5, 0.75]) {
            assert!((t - root).abs() < 1e-15, "{t} instead of {root}");
        }
    }
}
