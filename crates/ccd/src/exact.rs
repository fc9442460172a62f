//! Exact integer arithmetic for contacts that rounding leaves open.
//!
//! Coordinates are binary fractions, so a power of two makes them integers. Everything that a
//! contact depends on is the sign of a polynomial with integer coefficients at a root of another
//! one. The roots of the cubic are isolated, and at each the origin is tested against the polygon:
//! all edge functions on the side of the area vector or, where the polygon has collapsed, on one of
//! its edges. If the cubic is zero throughout, contact can only begin where the origin crosses an
//! edge, or enters one along its line, and those times are roots of further polynomials.
//!
//! Times are resolved to 2^-120 of the step. Where two different roots are closer, as on a lattice
//! whose points are an ulp off, the step is restricted to that interval, in which motion is linear
//! again, and times are resolved anew. Different roots of polynomials with integer coefficients
//! have a distance of which the digits of the coefficients bound the logarithm, so this ends: every
//! query is decided.

mod part;
mod polynomial;
mod root;

use glam::DVec3;
use num_bigint::BigInt;

use crate::shape::{Corners, PolygonShape};
use part::Part;
use polynomial::{Polynomial, Sign};
use root::{Root, TimeBounds, Unresolved, isolate, sign_at};

/// Decides a contact that is possible between two times: returns bounds on its first time, or `None`
/// where there is none.
///
/// It takes tens of microseconds where the exponents of the coordinates are similar, and up to some
/// milliseconds where they are as different as those of any two numbers.
pub(crate) fn decide<const N: usize>(
    x0: &[DVec3; 4],
    x1: &[DVec3; 4],
    [lo, hi]: [f64; 2],
) -> Option<TimeBounds>
where
    PolygonShape<N>: Corners<N>,
{
    let points = integers(x0, x1);
    let [from, to] = [root::floor(lo), root::ceil(hi)];
    match ExactPolygon::<N>::new(&points).first_contact(from, to) {
        Ok(first) => first.map(|root| root.bounds()),
        Err(Unresolved { .. }) => first_in_part::<N>(&points, &Part::new(from, to)),
    }
}

/// Finds the first contact in a part of the step; where roots are too close to be resolved, in the
/// parts before, at and after them.
fn first_in_part<const N: usize>(
    points: &[[Vector<BigInt>; 4]; 2],
    part: &Part,
) -> Option<TimeBounds>
where
    PolygonShape<N>: Corners<N>,
{
    let polygon = ExactPolygon::<N>::new(&part.points(points));
    let at = match polygon.first_contact(0, root::ONE) {
        Ok(first) => return first.map(|root| part.bounds(&root)),
        Err(Unresolved { at }) => at,
    };

    for part in part.around(at) {
        let first = first_in_part::<N>(points, &part);
        if first.is_some() {
            return first;
        }
    }
    None
}

type Vector<T> = [T; 3];

/// Multiplies all coordinates by a common power of two that makes them integers: at the start, then
/// at the end.
fn integers(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> [[Vector<BigInt>; 4]; 2] {
    let parts = [x0, x1].map(|x| x.map(|x| x.to_array().map(BinaryFraction::new)));

    // The lowest digit in use of any coordinate becomes that of the units.
    let nonzero = parts.iter().flatten().flatten().filter(|part| part.mantissa != 0);
    let min = nonzero.map(|part| part.exponent).min().unwrap_or(0);
    parts.map(|points| points.map(|point| point.map(|part| part.shifted(min))))
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

    /// Returns the number times `2^-exponent`, for an exponent that is not above its own.
    fn shifted(self, exponent: i32) -> BigInt {
        let digits = if self.mantissa == 0 { 0 } else { self.exponent - exponent };
        BigInt::from(self.mantissa) << digits
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
    fn new([start, end]: &[[Vector<BigInt>; 4]; 2]) -> Self {
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
    fn first_contact(&self, lo: u128, hi: u128) -> Result<Option<Root>, Unresolved> {
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
    ) -> Result<Option<Root>, Unresolved> {
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
    fn contains_origin(&self, root: &mut Root) -> Result<bool, Unresolved> {
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
    fn inside_all_edges(&self, root: &mut Root, k: usize, side: Sign) -> Result<bool, Unresolved> {
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
    fn on_an_edge(&self, root: &mut Root) -> Result<bool, Unresolved> {
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
