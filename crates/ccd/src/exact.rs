//! Exact integer arithmetic for contacts that rounding leaves open.
//!
//! Coordinates are binary fractions, so a power of two makes them integers. Everything that a
//! contact depends on is the sign of a polynomial with integer coefficients at a root of another
//! one. The roots of the cubic are isolated, and at each the origin is tested against the polygon:
//! all edge functions on the side of the area vector or, where the polygon has collapsed, on one of
//! its edges. If the cubic is zero throughout, contact can only begin where the origin crosses an
//! edge, or enters one along its line, and those times are roots of further polynomials.
//!
//! Work is bounded: coordinates that span too many binary digits, and roots closer together than
//! 2^-120 of the step, are not decided.

mod polynomial;
mod root;

use glam::DVec3;
use num_bigint::BigInt;

use crate::contact::{CcdContact, Certainty};
use crate::shape::{Corners, PolygonShape};
use polynomial::{Polynomial, Sign};
use root::{Root, Undecidable, isolate, sign_at};

/// Maximum number of binary digits that coordinates may span.
///
/// The polynomials that are compared have about ten times as many, and at this limit take about
/// 0.1 ms. Lengths may then differ by 2^200 and still be decided.
const MAX_DIGITS: i32 = 256;

/// Decides a possible contact: returns it with certain times, or `None` where there is none.
///
/// A contact whose decision would exceed the bound of the work is returned unchanged.
pub(crate) fn decide<const N: usize>(
    x0: &[DVec3; 4],
    x1: &[DVec3; 4],
    possible: CcdContact,
) -> Option<CcdContact>
where
    PolygonShape<N>: Corners<N>,
{
    let Some(points) = integers(x0, x1) else { return Some(possible) };
    let polygon = ExactPolygon::<N>::new(points);
    match polygon.first_contact(root::floor(possible.lo), root::ceil(possible.hi)) {
        Err(Undecidable) => Some(possible),
        Ok(None) => None,
        Ok(Some(root)) => {
            let (lo, hi) = root.bounds();
            let (at_start, certainty) = (root.is_start(), Certainty::Certain);
            Some(CcdContact { lo, hi, at_start, certainty, ..possible })
        }
    }
}

type Vector<T> = [T; 3];

/// Multiplies all coordinates by a common power of two that makes them integers: at the start, then
/// at the end; `None` if they span too many digits.
fn integers(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> Option<[[Vector<BigInt>; 4]; 2]> {
    let parts = [x0, x1].map(|x| x.map(|x| x.to_array().map(BinaryFraction::new)));

    // Digits in use, from the lowest to the highest of any coordinate.
    let nonzero = parts.iter().flatten().flatten().filter(|part| part.mantissa != 0);
    let (mut min, mut max) = (i32::MAX, i32::MIN);
    for part in nonzero {
        min = min.min(part.exponent);
        max = max.max(part.exponent + 53);
    }
    if max.saturating_sub(min) > MAX_DIGITS {
        return None;
    }

    Some(parts.map(|points| points.map(|point| point.map(|part| part.shifted(min)))))
}

/// A number as an odd integer (or 0) times a power of two.
struct BinaryFraction {
    mantissa: i64,
    exponent: i32,
}

impl BinaryFraction {
    fn new(x: f64) -> Self {
        // Subnormal numbers have no implicit digit, and the exponent of the smallest normal one.
        let bits = x.to_bits();
        let biased = i32::try_from(bits >> 52 & 0x7ff).unwrap_or(0);
        let fraction = i64::try_from(bits & ((1 << 52) - 1)).unwrap_or(0);
        let whole = if biased == 0 { fraction } else { fraction | 1 << 52 };
        if whole == 0 {
            return Self { mantissa: 0, exponent: 0 };
        }

        let zeros = whole.trailing_zeros();
        let odd = whole >> zeros;
        let exponent = biased.max(1) - 1075 + zeros.cast_signed();
        Self { mantissa: if x < 0.0 { -odd } else { odd }, exponent }
    }

    /// Returns the number times `2^-exponent`.
    fn shifted(self, exponent: i32) -> BigInt {
        BigInt::from(self.mantissa) << self.exponent.saturating_sub(exponent).clamp(0, MAX_DIGITS)
    }
}

/// Moving polygon with coordinates that are polynomials in time.
struct ExactPolygon<const N: usize> {
    corners: [Vector<Polynomial>; N],
    area: Vector<Polynomial>,
}

impl<const N: usize> ExactPolygon<N>
where
    PolygonShape<N>: Corners<N>,
{
    fn new([start, end]: [[Vector<BigInt>; 4]; 2]) -> Self {
        let corners = PolygonShape::<N>::PAIRS.map(|(to, from)| {
            std::array::from_fn(|k| {
                let (at_0, at_1) = (&start[to][k] - &start[from][k], &end[to][k] - &end[from][k]);
                Polynomial::linear(at_0, &at_1)
            })
        });
        let first = minus(&corners[1], &corners[0]);
        let last = minus(&corners[N - 1], &corners[0]);
        let area = cross(&first, &last);
        Self { corners, area }
    }

    /// Finds the first time at which the polygon contains the origin.
    fn first_contact(&self, lo: u128, hi: u128) -> Result<Option<Root>, Undecidable> {
        let volume = dot(&self.corners[0], &self.area);
        if !volume.is_zero() {
            return self.first_among(&volume, lo, hi);
        }

        // The plane contains the origin throughout: contact at the start, or across an edge.
        if self.contains_origin(&mut Root::at(lo))? {
            return Ok(Some(Root::at(lo)));
        }

        // Of each edge, only times before the first contact so far matter.
        let mut first: Option<Root> = None;
        for polynomial in self.boundary_polynomials() {
            let until = first.as_ref().map_or(hi, Root::end);
            if let Some(root) = self.first_among(&polynomial, lo, until)?
                && first.as_ref().is_none_or(|first| root.start() < first.start())
            {
                first = Some(root);
            }
        }
        Ok(first)
    }

    /// Finds the first root of a polynomial at which the origin is in the polygon.
    fn first_among(
        &self,
        polynomial: &Polynomial,
        lo: u128,
        hi: u128,
    ) -> Result<Option<Root>, Undecidable> {
        for mut root in isolate(polynomial, lo, hi)? {
            if self.contains_origin(&mut root)? {
                root.narrow();
                return Ok(Some(root));
            }
        }
        Ok(None)
    }

    /// Returns a polynomial per edge, among whose roots is every time at which the origin comes onto
    /// the edge, for a polygon whose plane always contains the origin.
    ///
    /// At such a time the ends of the edge and the origin are in line, so one component of their
    /// cross product is enough. Where all are zero, the origin enters the edge along its line.
    fn boundary_polynomials(&self) -> impl Iterator<Item = Polynomial> {
        (0..N).filter_map(|i| {
            let (a, b) = self.edge(i);
            let components = (0..3).map(|k| cross_component(a, b, k));
            components.chain(std::iter::once_with(|| dot(a, b))).find(|p| !p.is_zero())
        })
    }

    /// Returns the ends of edge `i`.
    fn edge(&self, i: usize) -> (&Vector<Polynomial>, &Vector<Polynomial>) {
        (&self.corners[i], &self.corners[(i + 1) % N])
    }

    /// Returns true if the origin is in the polygon at a root of its volume.
    fn contains_origin(&self, root: &mut Root) -> Result<bool, Undecidable> {
        // Project along an axis in which the area is not zero.
        for k in 0..3 {
            let side = sign_at(&self.area[k], root)?;
            if side != Sign::NoSign {
                return self.inside_all_edges(root, k, side);
            }
        }
        self.on_an_edge(root)
    }

    /// Returns true if all edge functions, projected along axis `k`, are zero or have `side`.
    fn inside_all_edges(&self, root: &mut Root, k: usize, side: Sign) -> Result<bool, Undecidable> {
        for i in 0..N {
            let (a, b) = self.edge(i);
            let sign = sign_at(&cross_component(a, b, k), root)?;
            if sign != Sign::NoSign && sign != side {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Returns true if the origin is on an edge of a polygon without area.
    fn on_an_edge(&self, root: &mut Root) -> Result<bool, Undecidable> {
        for i in 0..N {
            let (a, b) = self.edge(i);
            let mut on_line = true;
            for k in 0..3 {
                on_line = on_line && sign_at(&cross_component(a, b, k), root)? == Sign::NoSign;
            }
            // On its line, the origin is between the ends of the edge unless both are on one side.
            if on_line && sign_at(&dot(a, b), root)? != Sign::Plus {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

fn minus(a: &Vector<Polynomial>, b: &Vector<Polynomial>) -> Vector<Polynomial> {
    std::array::from_fn(|k| &a[k] - &b[k])
}

fn cross(a: &Vector<Polynomial>, b: &Vector<Polynomial>) -> Vector<Polynomial> {
    std::array::from_fn(|k| cross_component(a, b, k))
}

fn cross_component(a: &Vector<Polynomial>, b: &Vector<Polynomial>, k: usize) -> Polynomial {
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    &(&a[i] * &b[j]) - &(&a[j] * &b[i])
}

fn dot(a: &Vector<Polynomial>, b: &Vector<Polynomial>) -> Polynomial {
    &(&(&a[0] * &b[0]) + &(&a[1] * &b[1])) + &(&a[2] * &b[2])
}
