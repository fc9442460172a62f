//! The cubic of a moving polygon: when its plane holds the origin.
//!
//! With edges `e` and `f` of corner `A`, all linear in time, the volume
//! `A . (e x f)` is a cubic that is zero at every contact. Its Bernstein
//! coefficients need the area vectors of both ends and one mixed one.
//!
//! Sources: X. Provot, "Collision and self-collision handling in cloth model
//! dedicated to design garments", Graphics Interface 1997 (the cubic); M. Tang,
//! D. Manocha and R. Tong, I3D 2010 (its Bernstein form as a filter). The
//! rounding bound is our own: `docs/ccd-error-analysis.md`, lemma 2.

use glam::DVec3;

use crate::cubic::Cubic;
use crate::polygon::{MovingPolygon, larger, mix, separation_bound, smaller};
use crate::rounding::{COPLANARITY, DIRECTION, LENGTH_UP, NORMAL, UNDERFLOW};

/// Area vectors of a moving polygon, and what bounds their errors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Coplanarity {
    /// Area vectors at times 0 and 1.
    areas: [DVec3; 2],
    /// `B`: permanent of the area vectors.
    permanent: DVec3,
    /// Corner 0 at times 0 and 1.
    corner: [DVec3; 2],
    /// Area vectors dotted with corner 0: `[area at 0 or 1][corner at 0 or 1]`.
    heights: [[f64; 2]; 2],
    /// `8 u sum B_k (Q_k + X_k + Y_k)`: bound of projections onto an area vector.
    area_bound: f64,
}

impl Coplanarity {
    #[inline]
    pub(crate) fn new<const N: usize>(polygon: &MovingPolygon<N>) -> Self {
        let ([e0, e1], [f0, f1]) = (polygon.first_edge, polygon.last_edge);
        let (x, y) = (largest(e0, e1), largest(f0, f1));
        let permanent =
            DVec3::new(x.y * y.z + x.z * y.y, x.z * y.x + x.x * y.z, x.x * y.y + x.y * y.x);
        let areas = [e0.cross(f0), e1.cross(f1)];
        let corner = [polygon.start[0], polygon.end[0]];
        let heights = areas.map(|n| corner.map(|a| n.dot(a)));
        let area_bound = DIRECTION * permanent.dot(polygon.reach() + x + y) + UNDERFLOW;
        Self { areas, permanent, corner, heights, area_bound }
    }

    /// Direction certificate with the area vectors of both ends, during
    /// `0..=end`.
    ///
    /// At its own end all corners have the height of corner 0 over an area
    /// vector, so only those of the other end are projected.
    #[inline]
    pub(crate) fn areas_separate<const N: usize>(
        &self,
        polygon: &MovingPolygon<N>,
        end: f64,
        separation: f64,
    ) -> bool {
        let bound = |n| self.area_bound + separation_bound(n, separation);
        let [[at_start, first], [other, at_end]] = self.heights;
        one_side(self.areas[0], at_start, first, &polygon.end, end, bound(self.areas[0]))
            || one_side_reversed(
                self.areas[1],
                at_end,
                other,
                &polygon.start,
                end,
                bound(self.areas[1]),
            )
    }

    /// The cubic with its bound.
    #[inline]
    pub(crate) fn cubic<const N: usize>(&self, polygon: &MovingPolygon<N>) -> Cubic {
        let mixed = self.mixed_area(polygon);
        let [a0, a1] = self.corner;
        let [[b0, h01], [h10, b3]] = self.heights;
        let b1 = (h01 + a0.dot(mixed)) / 3.0;
        let b2 = (h10 + a1.dot(mixed)) / 3.0;
        let permanent = largest(a0, a1).dot(self.permanent);
        Cubic::new([b0, b1, b2, b3], COPLANARITY * permanent + UNDERFLOW)
    }

    /// How far from zero the cubic must be for the plane to be further than
    /// `separation` from the origin: the separation times the largest area.
    pub(crate) fn margin<const N: usize>(
        &self,
        polygon: &MovingPolygon<N>,
        separation: f64,
    ) -> f64 {
        let mixed = 0.5 * self.mixed_area(polygon).length();
        let area = larger(larger(self.areas[0].length(), self.areas[1].length()), mixed);
        let rounding = NORMAL * self.permanent.element_sum() + UNDERFLOW;
        separation * (area + rounding) * LENGTH_UP
    }

    /// Twice the middle Bernstein coefficient of the area vector.
    #[inline]
    fn mixed_area<const N: usize>(&self, polygon: &MovingPolygon<N>) -> DVec3 {
        let ([e0, e1], [f0, f1]) = (polygon.first_edge, polygon.last_edge);
        e0.cross(f1) + e1.cross(f0)
    }
}

/// Whether heights over `n` that start together keep to one side up to `end`.
#[inline]
fn one_side<const N: usize>(
    n: DVec3,
    together: f64,
    first: f64,
    others: &[DVec3; N],
    end: f64,
    bound: f64,
) -> bool {
    let side = 1.0_f64.copysign(together);
    let least = others[1..].iter().fold(side * first, |least, q| smaller(least, side * n.dot(*q)));
    side * together > bound && mix(side * together, least, end) > bound
}

/// Whether heights over `n` that end together keep to one side up to `end`.
#[inline]
fn one_side_reversed<const N: usize>(
    n: DVec3,
    together: f64,
    first: f64,
    others: &[DVec3; N],
    end: f64,
    bound: f64,
) -> bool {
    let side = 1.0_f64.copysign(first);
    let least = others[1..].iter().fold(side * first, |least, q| smaller(least, side * n.dot(*q)));
    least > bound && mix(least, side * together, end) > bound
}

/// Component-wise larger absolute value.
#[inline]
fn largest(a: DVec3, b: DVec3) -> DVec3 {
    let (a, b) = (a.abs(), b.abs());
    DVec3::new(larger(a.x, b.x), larger(a.y, b.y), larger(a.z, b.z))
}
