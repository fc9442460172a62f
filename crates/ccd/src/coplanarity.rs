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
use wide::f64x2;

use crate::cubic::BernsteinCubic;
use crate::ends::Ends;
use crate::outline::Outline;
use crate::polygon::separation_bound;
use crate::rounding::{
    AREA_DIRECTION, COPLANARITY, LENGTH_UNDERFLOW, LENGTH_UP, NORMAL, UNDERFLOW,
};
use crate::scalar::fast_max;
use crate::shape::{Corners, PolygonShape};

/// Area vectors of a moving polygon, and the bounds of their errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coplanarity<'a> {
    outline: &'a Outline,
    /// Area vectors at both ends.
    areas: Ends,
    /// `B`: permanent of the area vectors.
    permanent: DVec3,
    /// Heights of corner 0 at each end over the area vector of the same end.
    own_heights: f64x2,
    /// Heights of corner 0 at the other end over the area vector of each end.
    other_heights: f64x2,
    /// `X + Y`: largest coordinates of the edges of corner 0, summed.
    max_edges: DVec3,
}

impl<'a> Coplanarity<'a> {
    /// Computes the area vectors of both ends.
    #[inline]
    pub(crate) fn new(outline: &'a Outline) -> Self {
        let (e, f) = (outline.first_edge, outline.last_edge);
        let (x, y) = (e.max_abs(), f.max_abs());
        let areas = e.cross(f);
        let own_heights = areas.dot(outline.corner);
        let other_heights = areas.dot(outline.corner.swapped());
        let permanent = permanent(x, y);
        Self { outline, areas, permanent, own_heights, other_heights, max_edges: x + y }
    }

    /// Evaluates the direction certificate with the area vectors of both ends, during `0..=end`.
    ///
    /// At its own end all corners have the height of corner 0 over an area vector; at the other, the
    /// edges add to that height.
    #[inline]
    pub(crate) fn areas_separate<const N: usize>(&self, end: f64, separation: f64) -> bool
    where
        PolygonShape<N>: Corners<N>,
    {
        // Measure heights on the side of corner 0, which must stay there.
        let [[own_0, own_1], [other_0, other_1]] =
            [self.own_heights.to_array(), self.other_heights.to_array()];
        let (at_0, at_1) = (f64x2::new([own_0, other_1]), f64x2::new([other_0, own_1]));
        let side = (at_0 & f64x2::splat(-0.0)) | f64x2::splat(1.0);
        let at_end = f64x2::splat(1.0 - end) * at_0 + f64x2::splat(end) * at_1;
        let stays = (side * at_end).simd_gt(f64x2::splat(0.0));
        stays.any()
            && self.lowest_are_apart::<N>([side * at_0, side * at_1], side, end, separation).any()
    }

    /// Tests which area vectors have all corners beyond the bound, given the heights of corner 0 at
    /// both ends and the side on which heights are measured.
    #[inline]
    fn lowest_are_apart<const N: usize>(
        &self,
        [at_0, at_1]: [f64x2; 2],
        side: f64x2,
        end: f64,
        separation: f64,
    ) -> f64x2
    where
        PolygonShape<N>: Corners<N>,
    {
        // Edges add to the height at the other end: the lowest corner counts.
        let [e, f] = [self.outline.first_edge, self.outline.last_edge]
            .map(|edge| (side * self.areas.dot(edge.swapped())).to_array());
        let [rise_0, rise_1] = [0, 1].map(|own| PolygonShape::<N>::min_rise(e[own], f[own]));
        let at_0 = at_0 + f64x2::new([0.0, rise_1]);
        let at_1 = at_1 + f64x2::new([rise_0, 0.0]);

        let [n0, n1] = self.areas.to_array();
        let bound = f64x2::splat(self.area_bound())
            + f64x2::new([separation_bound(n0, separation), separation_bound(n1, separation)]);
        let at_end = f64x2::splat(1.0 - end) * at_0 + f64x2::splat(end) * at_1;
        at_0.simd_gt(bound) & at_end.simd_gt(bound)
    }

    /// Bounds the error of heights over an area vector.
    #[inline]
    fn area_bound(&self) -> f64 {
        AREA_DIRECTION * self.permanent.dot(self.outline.max_abs() + self.max_edges) + UNDERFLOW
    }

    /// Computes the cubic with its bound.
    #[inline]
    pub(crate) fn cubic(&self) -> BernsteinCubic {
        let third = f64x2::splat(1.0 / 3.0);
        let corner = self.outline.corner;
        let [b0, b3] = self.own_heights.to_array();
        let [b1, b2] = ((self.other_heights + corner.dot(self.mixed_area())) * third).to_array();

        let permanent = corner.max_abs().dot(self.permanent);
        BernsteinCubic::new([b0, b1, b2, b3], COPLANARITY * permanent + UNDERFLOW)
    }

    /// Returns how far from zero the cubic must be for the plane to be farther than `separation`
    /// from the origin: the separation times the largest area.
    pub(crate) fn margin(&self, separation: f64) -> f64 {
        // The middle Bernstein coefficient of the area vector is half of the mixed one.
        let [at_0, at_1] = self.areas.to_array().map(DVec3::length);
        let [mixed, _] = self.mixed_area().to_array();
        let area = fast_max(fast_max(at_0, at_1), 0.5 * mixed.length());
        let rounding = NORMAL * self.permanent.element_sum() + LENGTH_UNDERFLOW;
        separation * (area + rounding) * LENGTH_UP
    }

    /// Computes twice the middle Bernstein coefficient of the area vector, in both lanes.
    #[inline]
    fn mixed_area(&self) -> Ends {
        let mixed = self.outline.first_edge.cross(self.outline.last_edge.swapped());
        mixed.plus(mixed.swapped())
    }
}

/// Sums the absolute values of the products whose differences form a cross product.
#[inline]
fn permanent(x: DVec3, y: DVec3) -> DVec3 {
    DVec3::new(x.y * y.z + x.z * y.y, x.z * y.x + x.x * y.z, x.x * y.y + x.y * y.x)
}
