//! Both queries as one: a moving convex polygon against the origin.
//!
//! A vertex meets a face when the face, seen from the vertex, holds the
//! origin. Two edges meet when the parallelogram of all differences of their
//! points holds it. Corners move on straight lines, so for a fixed direction
//! `m` the projections of all of them are linear in time: if they are positive
//! at both ends of an interval there is no contact within it, whatever `m` is
//! and however badly it was computed. That is the *direction certificate*.

use glam::DVec3;

use crate::error::{CcdError, StepEnd};
use crate::rounding::{
    DIRECTION, LARGE, LENGTH_UP, SMALL, TURNING, UNDERFLOW, exponent, power_of_two,
};

/// What the filters need of a moving polygon: one corner, the two edges that
/// meet there, and the extent. All are differences of the input, not of each
/// other, so that each is rounded once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    /// Corner 0 at times 0 and 1.
    pub(crate) corner: [DVec3; 2],
    /// The edge from corner 0 to corner 1.
    pub(crate) first_edge: [DVec3; 2],
    /// The edge from corner 0 to corner `N - 1`.
    pub(crate) last_edge: [DVec3; 2],
    /// Smallest coordinates over all corners and both times.
    low: DVec3,
    /// Largest coordinates.
    high: DVec3,
    /// Powers of two that everything was multiplied with.
    pub(crate) scaling: Scaling,
}

/// Powers of two that points and their differences are multiplied with.
///
/// Points only by a quarter, and only where differences would overflow: the
/// digits that this costs are beyond 2^-1000 of the largest difference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scaling {
    points: f64,
    /// Two factors, since one alone may not be a normal number.
    differences: [f64; 2],
}

impl Scaling {
    const NONE: Self = Self { points: 1.0, differences: [1.0, 1.0] };

    /// Brings differences of size `size` to about 1.
    fn of_size(size: f64, points: f64) -> Self {
        let shift = -exponent(size);
        let differences = [shift / 2, shift - shift / 2].map(power_of_two);
        Self { points, differences }
    }

    /// All factors together, for lengths.
    #[inline]
    pub(crate) fn length(self, x: f64) -> f64 {
        x * self.points * self.differences[0] * self.differences[1]
    }

    fn point(self, x: DVec3) -> DVec3 {
        x * self.points
    }

    fn difference(self, x: DVec3) -> DVec3 {
        x * self.differences[0] * self.differences[1]
    }
}

/// A convex polygon with `N` corners (3 or 4) that move on straight lines.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MovingPolygon<'a, const N: usize> {
    pub(crate) outline: &'a Outline,
    /// Corners at time 0.
    pub(crate) start: [DVec3; N],
    /// Corners at time 1.
    pub(crate) end: [DVec3; N],
}

/// Stands for the shape of a query: `N` corners, 3 for a vertex and a face, 4
/// for two edges.
pub(crate) struct Shape<const N: usize>;

/// Corner 0 and its two edges, smallest and largest coordinates, at one time.
type Differences = [DVec3; 5];

/// Numbers of corners that have a meaning, with what depends on them.
pub(crate) trait Corners<const N: usize>: Sized {
    /// For each corner, the points whose difference it is: the first less the second.
    const PAIRS: [(usize, usize); N];

    /// The outline at one time.
    fn differences(x: &[DVec3; 4]) -> Differences;

    /// The least of `0`, `a` for corner 1, `b` for corner `N - 1`, and their
    /// sum for a corner between: what corners add to the height of corner 0.
    fn least_rise(a: f64, b: f64) -> f64;

    /// The edge functions, given those of the first and the last edge and what
    /// they all sum up to for a triangle, or opposite ones for a parallelogram.
    fn edge_functions(first: f64, last: f64, total: f64) -> [f64; N];

    /// The edges in order, given those of corner 0.
    fn edges(first: DVec3, last: DVec3) -> [DVec3; N];

    /// Weights of the query's points for given weights of the corners.
    fn stencil(corners: [f64; N]) -> [f64; 4];

    /// Weights of the corners for the origin, given its edge functions: the
    /// areas spanned with the edges from corner `i` to `i + 1`.
    fn corner_weights(edge_functions: [f64; N]) -> [f64; N];
}

impl Corners<3> for Shape<3> {
    const PAIRS: [(usize, usize); 3] = [(1, 0), (2, 0), (3, 0)];

    #[inline]
    fn differences(&[p, a, b, c]: &[DVec3; 4]) -> Differences {
        [a - p, b - a, c - a, least(least(a, b), c) - p, most(most(a, b), c) - p]
    }

    #[inline]
    fn least_rise(a: f64, b: f64) -> f64 {
        smaller(smaller(a, b), 0.0)
    }

    #[inline]
    fn edge_functions(first: f64, last: f64, total: f64) -> [f64; 3] {
        [first, total - first - last, last]
    }

    #[inline]
    fn edges(first: DVec3, last: DVec3) -> [DVec3; 3] {
        [first, last - first, -last]
    }

    #[inline]
    fn stencil([a, b, c]: [f64; 3]) -> [f64; 4] {
        [-1.0, a, b, c]
    }

    #[inline]
    fn corner_weights([ab, bc, ca]: [f64; 3]) -> [f64; 3] {
        let share = 1.0 / (ab + bc + ca);
        [bc * share, ca * share, ab * share]
    }
}

impl Corners<4> for Shape<4> {
    const PAIRS: [(usize, usize); 4] = [(2, 0), (3, 0), (3, 1), (2, 1)];

    #[inline]
    fn differences(&[a0, a1, b0, b1]: &[DVec3; 4]) -> Differences {
        let (low, high) = (least(b0, b1) - most(a0, a1), most(b0, b1) - least(a0, a1));
        [b0 - a0, b1 - b0, a0 - a1, low, high]
    }

    #[inline]
    fn least_rise(a: f64, b: f64) -> f64 {
        smaller(a, 0.0) + smaller(b, 0.0)
    }

    #[inline]
    fn edge_functions(first: f64, last: f64, total: f64) -> [f64; 4] {
        [first, total - last, total - first, last]
    }

    #[inline]
    fn edges(first: DVec3, last: DVec3) -> [DVec3; 4] {
        [first, last, -first, -last]
    }

    #[inline]
    fn stencil([b0a0, b1a0, b1a1, b0a1]: [f64; 4]) -> [f64; 4] {
        [-(b0a0 + b1a0), -(b1a1 + b0a1), b0a0 + b0a1, b1a0 + b1a1]
    }

    #[inline]
    fn corner_weights([at_a0, at_b1, at_a1, at_b0]: [f64; 4]) -> [f64; 4] {
        let (a, b) = (at_a0 / (at_a0 + at_a1), at_b0 / (at_b0 + at_b1));
        [(1.0 - a) * (1.0 - b), (1.0 - a) * b, a * b, a * (1.0 - b)]
    }
}

impl Outline {
    /// The outline of a query, scaled by a power of two where its size could
    /// underflow or overflow.
    #[inline]
    pub(crate) fn new<const N: usize>(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> Result<Self, CcdError>
    where
        Shape<N>: Corners<N>,
    {
        let (mut outline, finite) = Self::unscaled::<N>(x0, x1);
        if !(finite && (SMALL..=LARGE).contains(&outline.size())) {
            outline = Self::rescaled::<N>(x0, x1)?;
        }
        Ok(outline)
    }

    /// The outline as it is, and whether no coordinate is infinite or NaN.
    #[inline]
    fn unscaled<const N: usize>(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> (Self, bool)
    where
        Shape<N>: Corners<N>,
    {
        let [c0, e0, f0, low_0, high_0] = Shape::<N>::differences(x0);
        let [c1, e1, f1, low_1, high_1] = Shape::<N>::differences(x1);
        // An infinity or a NaN in any point survives the sum.
        let sum = (c0 + e0 + f0) + (c1 + e1 + f1);
        let outline = Self {
            corner: [c0, c1],
            first_edge: [e0, e1],
            last_edge: [f0, f1],
            low: least(low_0, low_1),
            high: most(high_0, high_1),
            scaling: Scaling::NONE,
        };
        (outline, (sum.x + sum.y + sum.z).is_finite())
    }

    /// The rare sizes: refuses what is not finite, scales the rest to about 1.
    #[cold]
    #[inline(never)]
    fn rescaled<const N: usize>(x0: &[DVec3; 4], x1: &[DVec3; 4]) -> Result<Self, CcdError>
    where
        Shape<N>: Corners<N>,
    {
        check_finite(x0, StepEnd::Start)?;
        check_finite(x1, StepEnd::Finish)?;
        let overflows = !Self::unscaled::<N>(x0, x1).1;
        let quarter = Scaling { points: if overflows { 0.25 } else { 1.0 }, ..Scaling::NONE };
        let [x0, x1] = [x0, x1].map(|x| x.map(|x| quarter.point(x)));
        let (outline, _) = Self::unscaled::<N>(&x0, &x1);
        let size = outline.size();
        if size > 0.0 {
            Ok(outline.scaled_by(Scaling::of_size(size, quarter.points)))
        } else {
            Ok(outline)
        }
    }

    fn scaled_by(self, scaling: Scaling) -> Self {
        let by = |x: DVec3| scaling.difference(x);
        Self {
            corner: self.corner.map(by),
            first_edge: self.first_edge.map(by),
            last_edge: self.last_edge.map(by),
            low: by(self.low),
            high: by(self.high),
            scaling,
        }
    }

    /// `Q`: largest coordinates in absolute value, over all corners and both times.
    #[inline]
    pub(crate) fn reach(&self) -> DVec3 {
        most(-self.low, self.high)
    }

    #[inline]
    fn size(&self) -> f64 {
        let reach = self.reach();
        larger(larger(reach.x, reach.y), reach.z)
    }

    /// Whether an axis alone keeps the polygon further than `separation` from
    /// the origin during the whole step. Differences have the right sign, so
    /// without a separation this needs no bound.
    #[inline]
    pub(crate) fn axis_separates(&self, separation: f64) -> bool {
        let d = separation * LENGTH_UP;
        let (low, high) = (self.low, self.high);
        low.x > d || low.y > d || low.z > d || high.x < -d || high.y < -d || high.z < -d
    }

    /// The edges of corner 0 at time `t`.
    #[inline]
    pub(crate) fn edges(&self, t: f64) -> [DVec3; 2] {
        [self.first_edge, self.last_edge].map(|[at_0, at_1]| mix_points(at_0, at_1, t))
    }

    /// Area vector at time `t`: twice the area for a triangle, the area for a
    /// parallelogram, along the normal of the corners' order.
    #[inline]
    pub(crate) fn area_vector(&self, t: f64) -> DVec3 {
        let [first, last] = self.edges(t);
        first.cross(last)
    }
}

impl<'a, const N: usize> MovingPolygon<'a, N>
where
    Shape<N>: Corners<N>,
{
    /// The polygon with an outline, of the same points.
    #[inline]
    pub(crate) fn new(outline: &'a Outline, [x0, x1]: [&[DVec3; 4]; 2]) -> Self {
        if outline.scaling != Scaling::NONE {
            return Self::scaled(outline, [x0, x1]);
        }
        Self { outline, start: corners(x0), end: corners(x1) }
    }

    #[cold]
    fn scaled(outline: &'a Outline, points: [&[DVec3; 4]; 2]) -> Self {
        let scaling = outline.scaling;
        let [start, end] = points
            .map(|x| corners::<N>(&x.map(|x| scaling.point(x))).map(|q| scaling.difference(q)));
        Self { outline, start, end }
    }
}

/// Corners of the polygon of four points.
#[inline]
fn corners<const N: usize>(x: &[DVec3; 4]) -> [DVec3; N]
where
    Shape<N>: Corners<N>,
{
    std::array::from_fn(|i| x[Shape::<N>::PAIRS[i].0] - x[Shape::<N>::PAIRS[i].1])
}

impl<const N: usize> MovingPolygon<'_, N> {
    /// `E(m)`: what the projections onto `m` must exceed for the direction
    /// certificate to hold with the given separation.
    #[inline]
    pub(crate) fn direction_bound(&self, m: DVec3, separation: f64) -> f64 {
        DIRECTION * m.abs().dot(self.outline.reach()) + UNDERFLOW + separation_bound(m, separation)
    }

    /// Direction certificate: whether `m` or `-m` keeps all corners further
    /// than `separation` from the origin during `lo..=hi`.
    #[inline]
    pub(crate) fn direction_separates(&self, m: DVec3, lo: f64, hi: f64, separation: f64) -> bool {
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..N {
            let (s0, s1) = (m.dot(self.start[i]), m.dot(self.end[i]));
            let (a, b) = (mix(s0, s1, lo), mix(s0, s1, hi));
            least = smaller(least, smaller(a, b));
            most = larger(most, larger(a, b));
        }
        let bound = self.direction_bound(m, separation);
        least > bound || most < -bound
    }

    /// The last time up to which a direction that goes straight from `m[0]` at
    /// `lo` to `m[1]` at `hi` keeps all corners on its positive side, further
    /// than `separation` from the origin; `None` if it does not even at `lo`.
    ///
    /// Projections are quadratic in time. An edge that is perpendicular to the
    /// direction at both ends strays from that by the square of the time in
    /// between, where a fixed direction would lose one of its corners at once.
    pub(crate) fn clear_until(
        &self,
        m: [DVec3; 2],
        [lo, hi]: [f64; 2],
        separation: f64,
    ) -> Option<f64> {
        let share = self.clear_share(m, [lo, hi], separation);
        if share >= 1.0 {
            return Some(hi);
        }
        if share <= 0.0 {
            return None;
        }
        // The share is a hint: rounded down, then checked.
        let shares = [share * (1.0 - 1e-9), share * 0.99].into_iter();
        let mut parts = shares.map(|share| (lo + share * (hi - lo), mix_points(m[0], m[1], share)));
        let clear = parts
            .find(|&(t, m_t)| t > lo && self.clear_share([m[0], m_t], [lo, t], separation) >= 1.0);
        Some(clear.map_or(lo, |(t, _)| t))
    }

    /// Direction certificate that turns: a share of at least 1 says that the
    /// direction separates during all of `lo..=hi`. A smaller one is where it
    /// seems to cease to.
    fn clear_share(&self, m: [DVec3; 2], [lo, hi]: [f64; 2], separation: f64) -> f64 {
        let [bound_lo, bound_hi] = self.turning_bounds(m, separation);
        let middle = 0.5 * (bound_lo + bound_hi);
        let mut share = 1.0;
        for i in 0..N {
            let q = [lo, hi].map(|t| mix_points(self.start[i], self.end[i], t));
            let [at_lo, between, at_hi] = projections(m, q);
            let above = [at_lo - bound_lo, between - middle, at_hi - bound_hi];
            if smaller(above[0], smaller(above[1], above[2])) <= 0.0 {
                share = smaller(share, first_zero(above));
            }
        }
        share
    }

    /// What the first and the last coefficient of projections onto a turning
    /// direction must exceed, and those between a mean of the two.
    pub(crate) fn turning_bounds(&self, m: [DVec3; 2], separation: f64) -> [f64; 2] {
        let rounding = TURNING * most(m[0].abs(), m[1].abs()).dot(self.outline.reach()) + UNDERFLOW;
        m.map(|m| rounding + separation_bound(m, separation))
    }

    /// Velocity of the point with the given weights of the corners.
    pub(crate) fn velocity(&self, weights: [f64; N]) -> DVec3 {
        (0..N).map(|i| (self.end[i] - self.start[i]) * weights[i]).sum()
    }

    /// Corners at time `t`.
    #[inline]
    pub(crate) fn corners(&self, t: f64) -> [DVec3; N] {
        std::array::from_fn(|i| mix_points(self.start[i], self.end[i], t))
    }
}

/// Bernstein coefficients of the projection of a point that moves from `q[0]`
/// to `q[1]` onto a direction that turns from `m[0]` to `m[1]`.
#[inline]
pub(crate) fn projections(m: [DVec3; 2], q: [DVec3; 2]) -> [f64; 3] {
    [m[0].dot(q[0]), 0.5 * (m[0].dot(q[1]) + m[1].dot(q[0])), m[1].dot(q[1])]
}

/// Where a quadratic with these Bernstein coefficients, one of which is not
/// positive, seems to be zero first in `0..=1`; just below 1 if nowhere.
fn first_zero([at_0, between, at_1]: [f64; 3]) -> f64 {
    if at_0 <= 0.0 {
        return 0.0;
    }
    let (slope, curvature) = (2.0 * (between - at_0), at_0 - 2.0 * between + at_1);
    let root = (slope * slope - 4.0 * at_0 * curvature).sqrt();
    let zero = 2.0 * at_0 / (root - slope);
    if (0.0..1.0).contains(&zero) { zero } else { 1.0 - f64::EPSILON }
}

/// What a separation adds to a bound on projections onto `m`: infinity where
/// the length of `m` would underflow.
#[inline]
pub(crate) fn separation_bound(m: DVec3, separation: f64) -> f64 {
    if separation > 0.0 {
        let squared = m.length_squared();
        let length = if squared > UNDERFLOW { squared.sqrt() } else { f64::INFINITY };
        separation * length * LENGTH_UP
    } else {
        0.0
    }
}

/// Linear interpolation that is right at both ends.
#[inline]
pub(crate) fn mix(a: f64, b: f64, t: f64) -> f64 {
    (1.0 - t) * a + t * b
}

/// [`mix`] for points.
#[inline]
pub(crate) fn mix_points(a: DVec3, b: DVec3, t: f64) -> DVec3 {
    a * (1.0 - t) + b * t
}

/// The smaller of two numbers; unlike `f64::min` one instruction, since it
/// promises nothing for NaN.
#[inline]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The larger of two numbers, likewise.
#[inline]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of each coordinate.
#[inline]
fn least(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(smaller(a.x, b.x), smaller(a.y, b.y), smaller(a.z, b.z))
}

/// The larger of each coordinate.
#[inline]
pub(crate) fn most(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z))
}

/// Refuses points that are not finite.
pub(crate) fn check_finite(points: &[DVec3], end: StepEnd) -> Result<(), CcdError> {
    let bad = points.iter().enumerate().find(|(_, x)| !x.is_finite());
    bad.map_or(Ok(()), |(point, x)| {
        let value = x.to_array().into_iter().find(|c| !c.is_finite()).unwrap_or(f64::NAN);
        Err(CcdError::NotFinite { point, end, value })
    })
}
