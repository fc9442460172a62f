//! Rational arithmetic and generators that the property tests share.

use arbitrary::{Result, Unstructured};
use num_rational::BigRational;
use num_traits::{One, Signed, ToPrimitive, Zero};
use surface::glam::DVec3;

pub(crate) mod anatomy;

/// A vector of exact rational components.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Exact(pub(crate) [BigRational; 3]);

impl Exact {
    pub(crate) fn new(v: DVec3) -> Self {
        Self(v.to_array().map(|x| BigRational::from_float(x).expect("finite")))
    }

    pub(crate) fn sub(&self, other: &Self) -> Self {
        Self(std::array::from_fn(|k| &self.0[k] - &other.0[k]))
    }

    /// `self + t (other − self)`
    pub(crate) fn lerp(&self, other: &Self, t: &BigRational) -> Self {
        Self(std::array::from_fn(|k| &self.0[k] + (&other.0[k] - &self.0[k]) * t))
    }

    pub(crate) fn dot(&self, other: &Self) -> BigRational {
        &self.0[0] * &other.0[0] + &self.0[1] * &other.0[1] + &self.0[2] * &other.0[2]
    }

    pub(crate) fn cross(&self, other: &Self) -> Self {
        let minor = |(i, j): (usize, usize)| &self.0[i] * &other.0[j] - &self.0[j] * &other.0[i];
        Self([(1, 2), (2, 0), (0, 1)].map(minor))
    }

    pub(crate) fn distance_squared(&self, other: &Self) -> BigRational {
        let difference = self.sub(other);
        difference.dot(&difference)
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.0.iter().all(Zero::is_zero)
    }
}

/// Root of a rational that is not negative, right to an ulp or two.
pub(crate) fn root(x: &BigRational) -> f64 {
    let scale = BigRational::from_float(2.0_f64.powi(600)).expect("finite");
    (x * scale).to_f64().expect("a number").sqrt() / 2.0_f64.powi(300)
}

/// `x` held within 0 and 1.
pub(crate) fn clamped(x: BigRational) -> BigRational {
    x.max(BigRational::zero()).min(BigRational::one())
}

/// Squared distance of a point from a segment.
pub(crate) fn to_segment(p: &Exact, [a, b]: [&Exact; 2]) -> BigRational {
    let ab = b.sub(a);
    let length_squared = ab.dot(&ab);
    if length_squared.is_zero() {
        return p.distance_squared(a);
    }
    let t = clamped(p.sub(a).dot(&ab) / length_squared);
    p.distance_squared(&a.lerp(b, &t))
}

/// Squared distance of a point from a triangle, which may be collapsed.
pub(crate) fn to_triangle(p: &Exact, [a, b, c]: [&Exact; 3]) -> BigRational {
    let edges = [[a, b], [b, c], [c, a]];
    let normal = b.sub(a).cross(&c.sub(a));
    let above =
        |[from, to]: [&Exact; 2]| !normal.dot(&to.sub(from).cross(&p.sub(from))).is_negative();
    if !normal.is_zero() && edges.into_iter().all(above) {
        let height = normal.dot(&p.sub(a));
        return &height * &height / normal.dot(&normal);
    }
    edges.into_iter().map(|edge| to_segment(p, edge)).min().expect("three edges")
}

/// Squared distance between two segments: of their lines where both feet are
/// on them, and else of the nearest end.
pub(crate) fn between_segments(a: [&Exact; 2], b: [&Exact; 2]) -> BigRational {
    let (u, v, r) = (a[1].sub(a[0]), b[1].sub(b[0]), b[0].sub(a[0]));
    let normal = u.cross(&v);
    let square = normal.dot(&normal);
    if !square.is_zero() {
        let s = r.cross(&v).dot(&normal) / &square;
        let t = r.cross(&u).dot(&normal) / &square;
        if s == clamped(s.clone()) && t == clamped(t.clone()) {
            return a[0].lerp(a[1], &s).distance_squared(&b[0].lerp(b[1], &t));
        }
    }
    let ends = [to_segment(a[0], b), to_segment(a[1], b), to_segment(b[0], a), to_segment(b[1], a)];
    ends.into_iter().min().expect("four ends")
}

/// A number from −1 to 1, often one of few.
pub(crate) fn coordinate(u: &mut Unstructured<'_>) -> Result<f64> {
    if u.ratio(1, 4)? {
        return Ok(f64::from(u.int_in_range(-2_i8..=2)?) / 2.0);
    }
    Ok(f64::from(u.arbitrary::<i32>()?) / 2.0_f64.powi(31))
}

/// A point of the cube from −1 to 1.
pub(crate) fn point(u: &mut Unstructured<'_>) -> Result<DVec3> {
    Ok(DVec3::new(coordinate(u)?, coordinate(u)?, coordinate(u)?))
}

/// `x` itself or a few ulps of it away, in each component.
pub(crate) fn nudged(u: &mut Unstructured<'_>, x: DVec3) -> Result<DVec3> {
    let mut component = |x: f64| -> Result<f64> {
        Ok(x * (1.0 + f64::from(u.int_in_range(-3_i8..=3)?) * f64::EPSILON))
    };
    Ok(DVec3::new(component(x.x)?, component(x.y)?, component(x.z)?))
}

/// A power of ten between `10^-exponent` and 1.
pub(crate) fn thinness(u: &mut Unstructured<'_>, exponent: i32) -> Result<f64> {
    Ok(10.0_f64.powi(-u.int_in_range(0..=exponent)?))
}

/// A triangle of size one: anything, a needle, a cap, or one that has
/// collapsed to a segment or a point.
pub(crate) fn triangle(u: &mut Unstructured<'_>) -> Result<[DVec3; 3]> {
    let [a, b, c] = [point(u)?, point(u)?, point(u)?];
    let mut corners = match u.int_in_range(0..=5)? {
        0 | 1 => [a, b, c],
        2 => [a, b, a + (c - a) * thinness(u, 17)?],
        3 => [a, b, a.lerp(b, coordinate(u)?.abs()) + c * thinness(u, 17)?],
        4 => [a, b, a.lerp(b, coordinate(u)?.abs())],
        _ => [a, a, if u.arbitrary()? { a } else { b }],
    };
    corners.rotate_left(u.int_in_range(0..=2)?);
    Ok(corners)
}

/// A point at some height over some point of a triangle's plane: often over an
/// edge or a corner, and often in the plane.
pub(crate) fn point_near(u: &mut Unstructured<'_>, [a, b, c]: [DVec3; 3]) -> Result<DVec3> {
    let (y, z) = (coordinate(u)?, coordinate(u)?);
    let foot = match u.int_in_range(0..=3)? {
        0 => a + (b - a) * y,
        1 => a + (b - a) * y.abs() + (c - a) * (1.0 - y.abs()) * z.abs(),
        _ => a + (b - a) * y + (c - a) * z,
    };
    if u.ratio(1, 4)? {
        return nudged(u, foot);
    }
    let away = point(u)? * thinness(u, 16)?;
    Ok(foot + away)
}
