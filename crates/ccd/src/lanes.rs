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

use crate::polygon::Shape;
use crate::rounding::{AREA_DIRECTION, COPLANARITY, LARGE, LENGTH_UP, NORMAL, SMALL, UNDERFLOW};

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

/// Corner 0 and its two edges, smallest and largest coordinates, at one time.
type Differences = [Vectors; 5];

/// What depends on the number of corners: [`Corners`](crate::polygon::Corners)
/// in lanes.
pub(crate) trait LaneCorners {
    fn differences(x: &[Vectors; 4]) -> Differences;
    fn least_rise(a: Wide, b: Wide) -> Wide;
}

impl LaneCorners for Shape<3> {
    #[inline]
    fn differences(&[p, a, b, c]: &[Vectors; 4]) -> Differences {
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        [a.minus(p), b.minus(a), c.minus(a), low.minus(p), high.minus(p)]
    }

    #[inline]
    fn least_rise(a: Wide, b: Wide) -> Wide {
        a.fast_min(b).fast_min(Wide::splat(0.0))
    }
}

impl LaneCorners for Shape<4> {
    #[inline]
    fn differences(&[a0, a1, b0, b1]: &[Vectors; 4]) -> Differences {
        let (low, high) = (b0.min(b1).minus(a0.max(a1)), b0.max(b1).minus(a0.min(a1)));
        [b0.minus(a0), b1.minus(b0), a0.minus(a1), low, high]
    }

    #[inline]
    fn least_rise(a: Wide, b: Wide) -> Wide {
        a.fast_min(Wide::splat(0.0)) + b.fast_min(Wide::splat(0.0))
    }
}

/// One bit for each query that the filters cannot drop.
#[inline]
pub(crate) fn left_over<P: LaneCorners>(
    x0: &[Vectors; 4],
    x1: &[Vectors; 4],
    end: f64,
    separation: f64,
) -> u32 {
    let [c0, e0, f0, low_0, high_0] = P::differences(x0);
    let [c1, e1, f1, low_1, high_1] = P::differences(x1);
    let extent = Extent { low: low_0.min(low_1), high: high_0.max(high_1) };
    let usual = extent.is_usual();
    let mut dropped = usual & extent.axis_separates(separation);
    if !dropped.all() {
        let edges = [[e0, e1], [f0, f1]];
        let filter = Filter::new([c0, c1], edges, extent.reach(), separation);
        dropped |= usual & filter.areas_separate::<P>(end);
        if !dropped.all() {
            dropped |= usual & filter.cubic_is_one_signed();
        }
    }
    !dropped.to_bitmask() & ((1 << LANES) - 1)
}

/// Smallest and largest coordinates of a polygon over a step.
struct Extent {
    low: Vectors,
    high: Vectors,
}

impl Extent {
    #[inline]
    fn reach(&self) -> Vectors {
        self.low.negated().max(self.high)
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
        let over = Wide::splat(separation * LENGTH_UP);
        let under = Wide::splat(-separation * LENGTH_UP);
        let (low, high) = (self.low, self.high);
        (low.x.simd_gt(over) | low.y.simd_gt(over) | low.z.simd_gt(over))
            | (high.x.simd_lt(under) | high.y.simd_lt(under) | high.z.simd_lt(under))
    }
}

/// The filters beyond the axes: [`Coplanarity`](crate::coplanarity::Coplanarity)
/// in lanes.
struct Filter {
    corner: [Vectors; 2],
    edges: [[Vectors; 2]; 2],
    areas: [Vectors; 2],
    permanent: Vectors,
    heights: [[Wide; 2]; 2],
    area_bound: Wide,
    separation: f64,
}

impl Filter {
    #[inline]
    fn new(
        corner: [Vectors; 2],
        edges: [[Vectors; 2]; 2],
        reach: Vectors,
        separation: f64,
    ) -> Self {
        let [[e0, e1], [f0, f1]] = edges;
        let (x, y) = (e0.abs().max(e1.abs()), f0.abs().max(f1.abs()));
        let permanent = x.permanent(y);
        let areas = [e0.cross(f0), e1.cross(f1)];
        let heights = areas.map(|n| corner.map(|a| n.dot(a)));
        let area_bound = Wide::splat(AREA_DIRECTION) * permanent.dot(reach.plus(x).plus(y))
            + Wide::splat(UNDERFLOW);
        Self { corner, edges, areas, permanent, heights, area_bound, separation }
    }

    #[inline]
    fn areas_separate<P: LaneCorners>(&self, end: f64) -> Mask {
        self.area_separates::<P>(0, end) | self.area_separates::<P>(1, end)
    }

    #[inline]
    fn area_separates<P: LaneCorners>(&self, own: usize, end: f64) -> Mask {
        let (n, other) = (self.areas[own], 1 - own);
        let (e, f) = (self.edges[0][other], self.edges[1][other]);
        let side = one_with_sign_of(self.heights[own][0]);
        let rise = P::least_rise(side * n.dot(e), side * n.dot(f));
        let mut least = self.heights[own].map(|height| side * height);
        least[other] += rise;
        let bound = self.area_bound + self.allowance(n);
        let at_end = Wide::splat(1.0 - end) * least[0] + Wide::splat(end) * least[1];
        least[0].simd_gt(bound) & at_end.simd_gt(bound)
    }

    #[inline]
    fn cubic_is_one_signed(&self) -> Mask {
        let [[e0, e1], [f0, f1]] = self.edges;
        let [a0, a1] = self.corner;
        let mixed = e0.cross(f1).plus(e1.cross(f0));
        let third = Wide::splat(1.0 / 3.0);
        let [[b0, h01], [h10, b3]] = self.heights;
        let (b1, b2) = ((h01 + a0.dot(mixed)) * third, (h10 + a1.dot(mixed)) * third);
        let error = Wide::splat(COPLANARITY) * a0.abs().max(a1.abs()).dot(self.permanent)
            + Wide::splat(UNDERFLOW);
        one_signed([b0, b1, b2, b3], error + self.margin(mixed))
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
    fn margin(&self, mixed: Vectors) -> Wide {
        if self.separation > 0.0 {
            let [n0, n1] = self.areas;
            let middle = Wide::splat(0.5) * mixed.dot(mixed).sqrt();
            let area = n0.dot(n0).sqrt().fast_max(n1.dot(n1).sqrt()).fast_max(middle);
            let permanent = self.permanent;
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
    fn negated(self) -> Self {
        let zero = Wide::splat(0.0);
        Self { x: zero - self.x, y: zero - self.y, z: zero - self.z }
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
#[inline]
fn one_with_sign_of(x: Wide) -> Wide {
    (x & Wide::splat(-0.0)) | Wide::splat(1.0)
}
