//! Coplanarity cubic of a moving polygon: the volume that its plane spans with the origin.
//!
//! With edges `e` and `f` of corner `A`, all linear in time, the volume `A . (e x f)` is a cubic
//! that is zero at every contact. Its Bernstein coefficients need the area vectors of both ends and
//! one mixed one.
//!
//! Sources: X. Provot, "Collision and self-collision handling in cloth model dedicated to design
//! garments", Graphics Interface 1997 (the cubic); M. Tang, D. Manocha and R. Tong, I3D 2010 (its
//! Bernstein form as a filter). The rounding bound is derived in `docs/ccd-error-analysis.md`,
//! lemma 3.

use glam::DVec3;

use crate::cubic::BernsteinCubic;
use crate::outline::Outline;
use crate::polygon::separation_bound;
use crate::rounding::{AREA_DIRECTION, COPLANARITY, LENGTH_UP, NORMAL, UNDERFLOW};
use crate::scalar::{fast_max, max_each, mix};
use crate::shape::{Corners, PolygonShape};

/// Area vectors of a moving polygon, and the bounds of their errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coplanarity<'a> {
    outline: &'a Outline,
    /// Area vectors at times 0 and 1.
    areas: [DVec3; 2],
    /// `B`: permanent of the area vectors.
    permanent: DVec3,
    /// `[n . a0, n . a1]` for the area vector `n` of time 0, then of time 1.
    heights: [[f64; 2]; 2],
    /// `X + Y`: largest coordinates of the edges of corner 0, summed.
    max_edges: DVec3,
}

impl<'a> Coplanarity<'a> {
    /// Computes the area vectors of both ends.
    #[inline]
    pub(crate) fn new(outline: &'a Outline) -> Self {
        let ([e0, e1], [f0, f1]) = (outline.first_edge, outline.last_edge);
        let (x, y) = (max_each(e0.abs(), e1.abs()), max_each(f0.abs(), f1.abs()));
        let permanent = permanent(x, y);
        let areas = [e0.cross(f0), e1.cross(f1)];
        let ([a0, a1], [n0, n1]) = (outline.corner, areas);
        let heights = [[n0.dot(a0), n0.dot(a1)], [n1.dot(a0), n1.dot(a1)]];
        Self { outline, areas, permanent, heights, max_edges: x + y }
    }

    /// Evaluates the direction certificate with the area vectors of both ends, during `0..=end`.
    #[inline]
    pub(crate) fn areas_separate<const N: usize>(&self, end: f64, separation: f64) -> bool
    where
        PolygonShape<N>: Corners<N>,
    {
        self.area_separates::<N>(0, end, separation) || self.area_separates::<N>(1, end, separation)
    }

    /// Evaluates the certificate with the area vector of one end.
    ///
    /// At that end all corners have the height of corner 0 over the area vector; at the other, the
    /// edges add to that height.
    #[inline]
    fn area_separates<const N: usize>(&self, own: usize, end: f64, separation: f64) -> bool
    where
        PolygonShape<N>: Corners<N>,
    {
        // Corner 0 must stay on one side.
        let (n, other) = (self.areas[own], 1 - own);
        let (e, f) = (self.outline.first_edge[other], self.outline.last_edge[other]);
        if self.heights[own][0] * self.heights[own][1] <= 0.0 {
            return false;
        }

        // Measure heights on that side, and find the lowest corner at each end.
        let [at_0, at_1] = self.heights[own];
        let side = 1.0_f64.copysign(at_0);
        let mut lowest = [side * at_0, side * at_1];
        lowest[other] += PolygonShape::<N>::min_rise(side * n.dot(e), side * n.dot(f));
        let bound = self.area_bound() + separation_bound(n, separation);
        lowest[0] > bound && mix(lowest[0], lowest[1], end) > bound
    }

    /// Bounds the error of heights over an area vector.
    #[inline]
    fn area_bound(&self) -> f64 {
        AREA_DIRECTION * self.permanent.dot(self.outline.max_abs() + self.max_edges) + UNDERFLOW
    }

    /// Computes the cubic with its bound.
    #[inline]
    pub(crate) fn cubic(&self) -> BernsteinCubic {
        let mixed = self.mixed_area();
        let [a0, a1] = self.outline.corner;
        let [[b0, h01], [h10, b3]] = self.heights;
        let third = 1.0 / 3.0;
        let b1 = (h01 + a0.dot(mixed)) * third;
        let b2 = (h10 + a1.dot(mixed)) * third;

        let permanent = max_each(a0.abs(), a1.abs()).dot(self.permanent);
        BernsteinCubic::new([b0, b1, b2, b3], COPLANARITY * permanent + UNDERFLOW)
    }

    /// Returns how far from zero the cubic must be for the plane to be farther than `separation`
    /// from the origin: the separation times the largest area.
    pub(crate) fn margin(&self, separation: f64) -> f64 {
        // The middle Bernstein coefficient of the area vector is half of the mixed one.
        let [at_0, at_1] = self.areas.map(DVec3::length);
        let area = fast_max(fast_max(at_0, at_1), 0.5 * self.mixed_area().length());
        separation * (area + NORMAL * self.permanent.element_sum() + UNDERFLOW) * LENGTH_UP
    }

    /// Computes twice the middle Bernstein coefficient of the area vector.
    #[inline]
    fn mixed_area(&self) -> DVec3 {
        let ([e0, e1], [f0, f1]) = (self.outline.first_edge, self.outline.last_edge);
        e0.cross(f1) + e1.cross(f0)
    }
}

/// Sums the absolute values of the products whose differences form a cross product.
#[inline]
fn permanent(x: DVec3, y: DVec3) -> DVec3 {
    DVec3::new(x.y * y.z + x.z * y.y, x.z * y.x + x.x * y.z, x.x * y.y + x.y * y.x)
}
