//! What rounding leaves open, decided in integers.
//!
//! Coordinates are binary fractions, so a power of two makes integers of them,
//! and everything a contact depends on is the sign of a polynomial with integer
//! coefficients at a root of another one. The cubic's roots are isolated, and
//! at each the origin is tested against the polygon: all edge functions on the
//! side of the area vector; or, where the polygon has collapsed, on one of its
//! edges. If the cubic vanishes altogether, contact can only begin where the
//! origin crosses an edge, or enters one along its line, and those times are
//! roots of further polynomials.
//!
//! Work is bounded: coordinates that span too many binary digits, and roots
//! closer together than 2^-120 of the step, are not decided.

mod polynomial;
mod root;

use glam::DVec3;
use num_bigint::BigInt;

use crate::polygon::{Corners, Shape};
use polynomial::{Polynomial, Sign};
use root::{Root, Undecidable, isolate, sign_at};

/// What exact arithmetic finds in an interval of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Decision {
    /// No contact.
    Free,
    /// The first contact is between these times.
    Contact {
        lo: f64,
        hi: f64,
        /// Whether it is at time 0.
        at_start: bool,
    },
    /// More work than is allowed.
    Open,
}

/// Binary digits that coordinates may span. The polynomials that are compared
/// have about ten times as many, and at this limit take about 0.1 ms; lengths
/// may then differ by 2^200 and still be decided.
const MOST_DIGITS: i32 = 256;

/// Decides whether the polygon of a query holds the origin during `lo..=hi`.
pub(crate) fn decide<const N: usize>(x0: &[DVec3; 4], x1: &[DVec3; 4], lo: f64, hi: f64) -> Decision
where
    Shape<N>: Corners<N>,
{
    let Some(points) = integers(x0, x1) else { return Decision::Open };
    let polygon = Polygon::<N>::new(points);
    match polygon.first_contact(root::floor(lo), root::ceil(hi)) {
        Err(Undecidable) => Decision::Open,
        Ok(None) => Decision::Free,
        Ok(Some(root)) => {
            let (lo, hi) = root.bounds();
            Decision::Contact { lo, hi, at_start: root.is_start() }
        }
    }
}

type Vector<T> = [T; 3];

/// Coordinates times a common power of two, by point: start, then end.
fn integers(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> Option<[[Vector<BigInt>; 4]; 2]> {
    let parts = [x0, x1].map(|x| x.map(|x| x.to_array().map(mantissa_and_exponent)));
    let used = || parts.iter().flatten().flatten().filter(|(mantissa, _)| *mantissa != 0);
    let least = used().map(|part| part.1).min().unwrap_or(0);
    let most = used().map(|part| part.1 + 53).max().unwrap_or(0);
    if most - least > MOST_DIGITS {
        return None;
    }
    let integer = |(mantissa, exponent): (i64, i32)| {
        BigInt::from(mantissa) << (exponent - least).clamp(0, MOST_DIGITS)
    };
    Some(parts.map(|points| points.map(|point| point.map(integer))))
}

/// `x` as an odd integer (or 0) times a power of two.
fn mantissa_and_exponent(x: f64) -> (i64, i32) {
    let bits = x.to_bits();
    let biased = i32::try_from(bits >> 52 & 0x7ff).unwrap_or(0);
    let fraction = i64::try_from(bits & ((1 << 52) - 1)).unwrap_or(0);
    let whole = if biased == 0 { fraction } else { fraction | 1 << 52 };
    if whole == 0 {
        return (0, 0);
    }
    let zeros = whole.trailing_zeros();
    let odd = whole >> zeros;
    (if x < 0.0 { -odd } else { odd }, biased.max(1) - 1075 + zeros.cast_signed())
}

/// The moving polygon with coordinates that are polynomials in time.
struct Polygon<const N: usize> {
    corners: [Vector<Polynomial>; N],
    area: Vector<Polynomial>,
}

impl<const N: usize> Polygon<N>
where
    Shape<N>: Corners<N>,
{
    fn new([start, end]: [[Vector<BigInt>; 4]; 2]) -> Self {
        let corners = Shape::<N>::PAIRS.map(|(to, from)| {
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

    fn first_contact(&self, lo: u128, hi: u128) -> Result<Option<Root>, Undecidable> {
        let volume = dot(&self.corners[0], &self.area);
        if !volume.is_zero() {
            return self.first_among(&volume, lo, hi);
        }
        if self.holds_origin(&mut Root::at(lo))? {
            return Ok(Some(Root::at(lo)));
        }
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

    /// The first root of a polynomial at which the origin is in the polygon.
    fn first_among(
        &self,
        polynomial: &Polynomial,
        lo: u128,
        hi: u128,
    ) -> Result<Option<Root>, Undecidable> {
        for mut root in isolate(polynomial, lo, hi)? {
            if self.holds_origin(&mut root)? {
                root.narrow();
                return Ok(Some(root));
            }
        }
        Ok(None)
    }

    /// For a polygon whose plane always holds the origin: a polynomial for each
    /// edge, among whose roots is every time at which the origin comes onto it.
    ///
    /// Then the edge's ends and the origin are in line, so that one component
    /// of their cross product will do; where all vanish, the origin enters the
    /// edge along its line.
    fn boundary_polynomials(&self) -> impl Iterator<Item = Polynomial> {
        (0..N).filter_map(|i| {
            let (a, b) = (&self.corners[i], &self.corners[(i + 1) % N]);
            let components = (0..3).map(|k| cross_component(a, b, k));
            components.chain(std::iter::once_with(|| dot(a, b))).find(|p| !p.is_zero())
        })
    }

    /// Whether the origin is in the polygon at a root of its volume.
    fn holds_origin(&self, root: &mut Root) -> Result<bool, Undecidable> {
        for k in 0..3 {
            let side = sign_at(&self.area[k], root)?;
            if side != Sign::NoSign {
                return self.inside_all_edges(root, k, side);
            }
        }
        self.on_an_edge(root)
    }

    /// Whether all edge functions, seen along axis `k`, are zero or have `side`.
    fn inside_all_edges(&self, root: &mut Root, k: usize, side: Sign) -> Result<bool, Undecidable> {
        for i in 0..N {
            let edge_function = cross_component(&self.corners[i], &self.corners[(i + 1) % N], k);
            let sign = sign_at(&edge_function, root)?;
            if sign != Sign::NoSign && sign != side {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Whether the origin is on an edge of a polygon without area.
    fn on_an_edge(&self, root: &mut Root) -> Result<bool, Undecidable> {
        for i in 0..N {
            let (a, b) = (&self.corners[i], &self.corners[(i + 1) % N]);
            let mut on_line = true;
            for k in 0..3 {
                on_line = on_line && sign_at(&cross_component(a, b, k), root)? == Sign::NoSign;
            }
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
