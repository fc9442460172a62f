//! Queries side by side: the filters of the search in SIMD lanes.
//!
//! A register holds a lane a query: two with SSE2 or NEON, four where the
//! compiler may use AVX. More lanes than a register holds would only spill (on
//! SSE2, four lanes took 41 ns a query, two take 15).
//!
//! The arithmetic is that of the single query, operation by operation, so that
//! a lane is dropped exactly where the single query would be dropped by the
//! same filters: axes, area vectors of both ends, signs of the cubic.

use glam::DVec3;
#[cfg(not(target_feature = "avx"))]
use wide::f64x2 as Wide;
#[cfg(target_feature = "avx")]
use wide::f64x4 as Wide;

use crate::rounding::{COPLANARITY, DIRECTION, LARGE, LENGTH_UP, NORMAL, SMALL, UNDERFLOW};

/// Queries that are filtered together.
pub(crate) const LANES: usize = size_of::<Wide>() / size_of::<f64>();

/// Which lanes a test holds in: all bits set where it does.
type Mask = Wide;

/// A vector a lane.
#[derive(Clone, Copy)]
pub(crate) struct Vectors {
    x: Wide,
    y: Wide,
    z: Wide,
}

/// Numbers of corners whose polygons can be built in lanes.
pub(crate) trait LaneCorners<const N: usize> {
    /// As [`Corners::differences`](crate::polygon::Corners::differences).
    fn differences(x: &[Vectors; 4]) -> ([Vectors; N], Vectors, Vectors);
}

/// Stands for polygons of `N` corners in lanes.
pub(crate) struct LanePolygon<const N: usize>;

impl LaneCorners<3> for LanePolygon<3> {
    #[inline]
    fn differences(&[p, a, b, c]: &[Vectors; 4]) -> ([Vectors; 3], Vectors, Vectors) {
        ([a.minus(p), b.minus(p), c.minus(p)], b.minus(a), c.minus(a))
    }
}

impl LaneCorners<4> for LanePolygon<4> {
    #[inline]
    fn differences(&[a0, a1, b0, b1]: &[Vectors; 4]) -> ([Vectors; 4], Vectors, Vectors) {
        ([b0.minus(a0), b1.minus(a0), b1.minus(a1), b0.minus(a1)], b1.minus(b0), a0.minus(a1))
    }
}

/// One bit for each query that the filters cannot drop.
#[inline]
pub(crate) fn left_over<const N: usize>(
    x0: &[Vectors; 4],
    x1: &[Vectors; 4],
    end: f64,
    separation: f64,
) -> u32
where
    LanePolygon<N>: LaneCorners<N>,
{
    let (start, e0, f0) = LanePolygon::<N>::differences(x0);
    let (finish, e1, f1) = LanePolygon::<N>::differences(x1);
    let extent = Extent::of(&start, &finish);
    let usual = extent.is_usual();
    let axis = extent.axis_separates(separation);
    if (axis & usual).all() {
        return 0;
    }
    let filter = Filter { start, finish, edges: [[e0, e1], [f0, f1]], end, separation };
    let dropped = usual & (axis | filter.separates(extent.reach()));
    !dropped.to_bitmask() & ((1 << LANES) - 1)
}

/// Smallest and largest coordinates of a polygon over a step.
struct Extent {
    low: Vectors,
    high: Vectors,
}

impl Extent {
    #[inline]
    fn of<const N: usize>(start: &[Vectors; N], finish: &[Vectors; N]) -> Self {
        let all = || start.iter().chain(finish).copied();
        let low = all().fold(start[0], Vectors::min);
        let high = all().fold(start[0], Vectors::max);
        Self { low, high }
    }

    #[inline]
    fn reach(&self) -> Vectors {
        let zero = Wide::splat(0.0);
        let negated = Vectors { x: zero - self.low.x, y: zero - self.low.y, z: zero - self.low.z };
        negated.max(self.high)
    }

    /// Whether a query needs no scaling.
    #[inline]
    fn is_usual(&self) -> Mask {
        let reach = self.reach();
        let size = reach.x.fast_max(reach.y).fast_max(reach.z);
        size.simd_ge(Wide::splat(SMALL)) & size.simd_le(Wide::splat(LARGE))
    }

    #[inline]
    fn axis_separates(&self, separation: f64) -> Mask {
        let (over, under) =
            (Wide::splat(separation * LENGTH_UP), Wide::splat(-separation * LENGTH_UP));
        let (low, high) = (self.low, self.high);
        (low.x.simd_gt(over) | low.y.simd_gt(over) | low.z.simd_gt(over))
            | (high.x.simd_lt(under) | high.y.simd_lt(under) | high.z.simd_lt(under))
    }
}

/// The filters beyond the axes: see [`Coplanarity`](crate::coplanarity::Coplanarity).
struct Filter<const N: usize> {
    start: [Vectors; N],
    finish: [Vectors; N],
    edges: [[Vectors; 2]; 2],
    end: f64,
    separation: f64,
}

impl<const N: usize> Filter<N> {
    #[inline]
    fn separates(&self, reach: Vectors) -> Mask {
        let [[e0, e1], [f0, f1]] = self.edges;
        let (x, y) = (e0.abs().max(e1.abs()), f0.abs().max(f1.abs()));
        let permanent = x.permanent(y);
        let areas = [e0.cross(f0), e1.cross(f1)];
        let (a0, a1) = (self.start[0], self.finish[0]);
        let heights = areas.map(|n| [n.dot(a0), n.dot(a1)]);
        let bound =
            Wide::splat(DIRECTION) * permanent.dot(reach.plus(x).plus(y)) + Wide::splat(UNDERFLOW);
        let away_0 = self.keeps_away(areas[0], heights[0], &self.finish, bound);
        let [first, together] = heights[1];
        let away_1 = self.comes_from_away(areas[1], together, first, bound);
        let mixed = e0.cross(f1).plus(e1.cross(f0));
        let third = Wide::splat(3.0);
        let b1 = (heights[0][1] + a0.dot(mixed)) / third;
        let b2 = (heights[1][0] + a1.dot(mixed)) / third;
        let error = Wide::splat(COPLANARITY) * a0.abs().max(a1.abs()).dot(permanent)
            + Wide::splat(UNDERFLOW);
        let limit = error + self.margin(areas, mixed, permanent);
        away_0 | away_1 | one_signed([heights[0][0], b1, b2, heights[1][1]], limit)
    }

    /// Whether heights that start together over `n` keep to one side.
    #[inline]
    fn keeps_away(
        &self,
        n: Vectors,
        [together, first]: [Wide; 2],
        others: &[Vectors; N],
        bound: Wide,
    ) -> Mask {
        let side = together.signum_like();
        let least =
            others[1..].iter().fold(side * first, |least, q| least.fast_min(side * n.dot(*q)));
        let bound = bound + self.allowance(n);
        (side * together).simd_gt(bound) & self.at_end(side * together, least).simd_gt(bound)
    }

    /// Whether heights that end together over `n` keep to one side.
    #[inline]
    fn comes_from_away(&self, n: Vectors, together: Wide, first: Wide, bound: Wide) -> Mask {
        let side = first.signum_like();
        let least =
            self.start[1..].iter().fold(side * first, |least, q| least.fast_min(side * n.dot(*q)));
        let bound = bound + self.allowance(n);
        least.simd_gt(bound) & self.at_end(least, side * together).simd_gt(bound)
    }

    #[inline]
    fn at_end(&self, a: Wide, b: Wide) -> Wide {
        Wide::splat(1.0 - self.end) * a + Wide::splat(self.end) * b
    }

    /// What the separation adds to a bound on projections onto `n`.
    #[inline]
    fn allowance(&self, n: Vectors) -> Wide {
        if self.separation > 0.0 {
            let squared = n.dot(n);
            let known = squared.simd_gt(Wide::splat(UNDERFLOW));
            let length = known.bitselect(squared.sqrt(), Wide::splat(f64::INFINITY));
            Wide::splat(self.separation) * length * Wide::splat(LENGTH_UP)
        } else {
            Wide::splat(0.0)
        }
    }

    /// What the separation adds to the bound of the cubic.
    #[inline]
    fn margin(&self, [n0, n1]: [Vectors; 2], mixed: Vectors, permanent: Vectors) -> Wide {
        if self.separation > 0.0 {
            let middle = Wide::splat(0.5) * mixed.dot(mixed).sqrt();
            let area = n0.dot(n0).sqrt().fast_max(n1.dot(n1).sqrt()).fast_max(middle);
            let rounding = Wide::splat(NORMAL) * (permanent.x + permanent.y + permanent.z)
                + Wide::splat(UNDERFLOW);
            Wide::splat(self.separation) * (area + rounding) * Wide::splat(LENGTH_UP)
        } else {
            Wide::splat(0.0)
        }
    }
}

#[inline]
fn one_signed([b0, b1, b2, b3]: [Wide; 4], limit: Wide) -> Mask {
    let least = b0.fast_min(b1).fast_min(b2.fast_min(b3));
    let most = b0.fast_max(b1).fast_max(b2.fast_max(b3));
    least.simd_gt(limit) | most.simd_lt(Wide::splat(0.0) - limit)
}

impl Vectors {
    /// The same point of neighbouring queries.
    #[inline]
    pub(crate) fn gather(points: [DVec3; LANES]) -> Self {
        Self {
            x: Wide::from(points.map(|p| p.x)),
            y: Wide::from(points.map(|p| p.y)),
            z: Wide::from(points.map(|p| p.z)),
        }
    }

    #[inline]
    fn each(self, other: Self, f: impl Fn(Wide, Wide) -> Wide) -> Self {
        Self { x: f(self.x, other.x), y: f(self.y, other.y), z: f(self.z, other.z) }
    }

    #[inline]
    fn plus(self, other: Self) -> Self {
        self.each(other, |a, b| a + b)
    }

    #[inline]
    fn minus(self, other: Self) -> Self {
        self.each(other, |a, b| a - b)
    }

    #[inline]
    fn min(self, other: Self) -> Self {
        self.each(other, Wide::fast_min)
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        self.each(other, Wide::fast_max)
    }

    #[inline]
    fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    #[inline]
    fn dot(self, other: Self) -> Wide {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline]
    fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// Sums where [`Vectors::cross`] has differences.
    #[inline]
    fn permanent(self, other: Self) -> Self {
        Self {
            x: self.y * other.z + self.z * other.y,
            y: self.z * other.x + self.x * other.z,
            z: self.x * other.y + self.y * other.x,
        }
    }
}

/// 1 with the sign of each lane.
trait SignumLike {
    fn signum_like(self) -> Self;
}

impl SignumLike for Wide {
    #[inline]
    fn signum_like(self) -> Self {
        (self & Self::splat(-0.0)) | Self::splat(1.0)
    }
}
