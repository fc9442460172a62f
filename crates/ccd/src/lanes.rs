//! Filters of the search in SIMD lanes: several queries side by side.
//!
//! A register holds one lane per query: two with SSE2 or NEON, four where the compiler may use AVX.
//! More lanes than a register holds would only spill (on SSE2, four lanes took 41 ns per query, two
//! take 15).
//!
//! The certificates are those of the single query: axes, area vectors of both ends, signs of the
//! cubic. Their arithmetic is the same, operation by operation, and so are their bounds.

use glam::DVec3;
#[cfg(not(target_feature = "avx"))]
use wide::f64x2 as Wide;
#[cfg(target_feature = "avx")]
use wide::f64x4 as Wide;

use crate::rounding::{
    AREA_DIRECTION, COPLANARITY, LARGE, LENGTH_UNDERFLOW, LENGTH_UP, NORMAL, SMALL, UNDERFLOW,
};
use crate::shape::{Coordinates, Differences, PointDifferences, PolygonShape};

/// Number of queries that are filtered together.
pub(crate) const LANES: usize = size_of::<Wide>() / size_of::<f64>();

/// Result of a test: all bits of a lane are set where it holds.
type Mask = Wide;

/// One vector per lane.
#[derive(Clone, Copy)]
pub(crate) struct Vectors {
    x: Wide,
    y: Wide,
    z: Wide,
}

/// Formulas that depend on the number of corners: [`Corners`](crate::shape::Corners) in lanes.
pub(crate) trait LaneCorners: PointDifferences {
    /// Returns the minimum that corners add to the height of corner 0.
    fn min_rise(a: Wide, b: Wide) -> Wide;
}

impl LaneCorners for PolygonShape<3> {
    #[inline]
    fn min_rise(a: Wide, b: Wide) -> Wide {
        a.fast_min(b).fast_min(Wide::splat(0.0))
    }
}

impl LaneCorners for PolygonShape<4> {
    #[inline]
    fn min_rise(a: Wide, b: Wide) -> Wide {
        a.fast_min(Wide::splat(0.0)) + b.fast_min(Wide::splat(0.0))
    }
}

/// Filters queries: the bit of every query that the filters cannot drop is set.
#[inline]
pub(crate) fn not_excluded<P: LaneCorners>(
    x0: &[Vectors; 4],
    x1: &[Vectors; 4],
    end: f64,
    separation: f64,
) -> u32 {
    let (start, finish) = (P::differences(x0), P::differences(x1));
    let bounds =
        AxisBounds { lower: start.lower.min(finish.lower), upper: start.upper.max(finish.upper) };

    // Each filter is more expensive than the one before, and runs while a lane is left.
    let usual = bounds.are_usual();
    let mut dropped = usual & bounds.axis_separates(separation);
    if !dropped.all() {
        let filter = LaneFilter::new(&start, &finish, bounds.max_abs(), separation);
        dropped |= usual & filter.areas_separate::<P>(end);
        if !dropped.all() {
            dropped |= usual & filter.cubic_excludes_zero();
        }
    }
    !dropped.to_bitmask() & ((1 << LANES) - 1)
}

/// Smallest and largest coordinates of a polygon over a step.
struct AxisBounds {
    lower: Vectors,
    upper: Vectors,
}

impl AxisBounds {
    #[inline]
    fn max_abs(&self) -> Vectors {
        self.lower.negated().max(self.upper)
    }

    /// Tests which queries need no scaling.
    #[inline]
    fn are_usual(&self) -> Mask {
        let max = self.max_abs();
        let size = max.x.fast_max(max.y).fast_max(max.z);
        size.simd_ge(Wide::splat(SMALL)) & size.simd_le(Wide::splat(LARGE))
    }

    #[inline]
    fn axis_separates(&self, separation: f64) -> Mask {
        let over = Wide::splat(separation * LENGTH_UP);
        let under = Wide::splat(-separation * LENGTH_UP);
        let (lower, upper) = (self.lower, self.upper);
        (lower.x.simd_gt(over) | lower.y.simd_gt(over) | lower.z.simd_gt(over))
            | (upper.x.simd_lt(under) | upper.y.simd_lt(under) | upper.z.simd_lt(under))
    }
}

/// Filters beyond the axes: [`Coplanarity`](crate::coplanarity::Coplanarity) in lanes.
struct LaneFilter {
    corner: [Vectors; 2],
    first_edge: [Vectors; 2],
    last_edge: [Vectors; 2],
    areas: [Vectors; 2],
    permanent: Vectors,
    heights: [[Wide; 2]; 2],
    area_bound: Wide,
    separation: f64,
}

impl LaneFilter {
    #[inline]
    fn new(
        start: &Differences<Vectors>,
        finish: &Differences<Vectors>,
        max_abs: Vectors,
        separation: f64,
    ) -> Self {
        let corner = [start.corner, finish.corner];
        let first_edge @ [e0, e1] = [start.first_edge, finish.first_edge];
        let last_edge @ [f0, f1] = [start.last_edge, finish.last_edge];
        let (x, y) = (e0.abs().max(e1.abs()), f0.abs().max(f1.abs()));
        let permanent = x.permanent(y);
        let areas = [e0.cross(f0), e1.cross(f1)];
        let heights = areas.map(|n| corner.map(|a| n.dot(a)));
        let area_bound = Wide::splat(AREA_DIRECTION) * permanent.dot(max_abs.plus(x).plus(y))
            + Wide::splat(UNDERFLOW);
        Self { corner, first_edge, last_edge, areas, permanent, heights, area_bound, separation }
    }

    #[inline]
    fn areas_separate<P: LaneCorners>(&self, end: f64) -> Mask {
        self.area_separates::<P>(0, end) | self.area_separates::<P>(1, end)
    }

    #[inline]
    fn area_separates<P: LaneCorners>(&self, own: usize, end: f64) -> Mask {
        // Heights are measured on the side of corner 0; the lowest corner counts.
        let (n, other) = (self.areas[own], 1 - own);
        let (e, f) = (self.first_edge[other], self.last_edge[other]);
        let side = one_with_sign_of(self.heights[own][0]);
        let rise = P::min_rise(side * n.dot(e), side * n.dot(f));
        let mut lowest = self.heights[own].map(|height| side * height);
        lowest[other] += rise;

        let bound = self.area_bound + self.separation_bound(n);
        let at_end = Wide::splat(1.0 - end) * lowest[0] + Wide::splat(end) * lowest[1];
        lowest[0].simd_gt(bound) & at_end.simd_gt(bound)
    }

    #[inline]
    fn cubic_excludes_zero(&self) -> Mask {
        let ([e0, e1], [f0, f1]) = (self.first_edge, self.last_edge);
        let [a0, a1] = self.corner;
        let mixed = e0.cross(f1).plus(e1.cross(f0));
        let third = Wide::splat(1.0 / 3.0);
        let [[b0, h01], [h10, b3]] = self.heights;
        let (b1, b2) = ((h01 + a0.dot(mixed)) * third, (h10 + a1.dot(mixed)) * third);

        let error = Wide::splat(COPLANARITY) * a0.abs().max(a1.abs()).dot(self.permanent)
            + Wide::splat(UNDERFLOW);
        all_beyond([b0, b1, b2, b3], error + self.margin(mixed))
    }

    /// Returns what the separation adds to a bound on projections onto `n`.
    #[inline]
    fn separation_bound(&self, n: Vectors) -> Wide {
        if self.separation > 0.0 {
            // Where the length would underflow, no projection is large enough.
            let squared = n.dot(n);
            let is_normal = squared.simd_gt(Wide::splat(UNDERFLOW));
            let length = is_normal.bitselect(squared.sqrt(), Wide::splat(f64::INFINITY));
            Wide::splat(self.separation) * length * Wide::splat(LENGTH_UP)
        } else {
            Wide::splat(0.0)
        }
    }

    /// Returns what the separation adds to the bound of the cubic.
    #[inline]
    fn margin(&self, mixed: Vectors) -> Wide {
        if self.separation > 0.0 {
            // The area vector is at most the largest of its Bernstein coefficients.
            let [n0, n1] = self.areas;
            let middle = Wide::splat(0.5) * mixed.dot(mixed).sqrt();
            let area = n0.dot(n0).sqrt().fast_max(n1.dot(n1).sqrt()).fast_max(middle);
            let permanent = self.permanent;
            let rounding = Wide::splat(NORMAL) * (permanent.x + permanent.y + permanent.z)
                + Wide::splat(LENGTH_UNDERFLOW);
            Wide::splat(self.separation) * (area + rounding) * Wide::splat(LENGTH_UP)
        } else {
            Wide::splat(0.0)
        }
    }
}

/// Tests whether all coefficients are on one side of zero, farther than `bound`.
#[inline]
fn all_beyond([b0, b1, b2, b3]: [Wide; 4], bound: Wide) -> Mask {
    let min = b0.fast_min(b1).fast_min(b2.fast_min(b3));
    let max = b0.fast_max(b1).fast_max(b2.fast_max(b3));
    min.simd_gt(bound) | max.simd_lt(Wide::splat(0.0) - bound)
}

impl Coordinates for Vectors {
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
}

impl Vectors {
    /// Gathers the same point of neighboring queries.
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

    /// Computes sums where [`Vectors::cross`] has differences.
    #[inline]
    fn permanent(self, other: Self) -> Self {
        Self {
            x: self.y * other.z + self.z * other.y,
            y: self.z * other.x + self.x * other.z,
            z: self.x * other.y + self.y * other.x,
        }
    }
}

/// Returns 1 with the sign of each lane.
#[inline]
fn one_with_sign_of(x: Wide) -> Wide {
    (x & Wide::splat(-0.0)) | Wide::splat(1.0)
}
