//! Planes of the centers of a slab, and planes that touch its balls.

use glam::DVec3;
use surface::triangle;

use super::Foot;
use crate::Ball;

/// Squared sine of the angle between two sides of a slab's face of centers below which the slab is
/// handled as its three cones.
///
/// Below it the solution in the plane has lost all its digits, while the cones are within `1e-8` of
/// a side of every ball of the slab. It is relative to the sides, so that it holds at any scale.
const MIN_SINE_SQUARED: f64 = 1e-16;

/// Plane that touches the three balls of a slab on the side of a point.
pub(crate) struct TangentPlane {
    /// Unit normal of the plane, on the side of the point.
    pub(crate) outward: DVec3,
    /// Weights of the ball that the plane touches below the point. It is the nearest ball where
    /// none is negative.
    weights: [f64; 3],
}

/// Plane of the centers of a slab, with the gradient of the radius in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct CenterPlane {
    /// Product of the sides from the first center to the second and the third.
    cross: DVec3,
    /// Squared length of the product.
    cross_squared: f64,
    /// Squared sine of the angle between the sides.
    pub(super) sine_squared: f64,
    /// Dual basis of the sides: gradients of the weights of the second and the third ball.
    duals: [DVec3; 2],
    /// Gradient of the radius.
    slope: DVec3,
    /// √(1 − |G|²) times the length of the product, with G that gradient; NaN where its slope is 1
    /// or more.
    flatness: f64,
}

impl TangentPlane {
    /// Computes the plane; `None` where the centers are on a line, or no plane touches all balls.
    pub(crate) fn new(p: DVec3, balls: &[Ball; 3]) -> Option<Self> {
        let plane = CenterPlane::new(balls)?;
        let weights = plane.stationary_weights(p, balls)?;
        Some(Self { outward: plane.outward(p - balls[0].center), weights })
    }

    /// Returns true if the plane touches the slab below the point, whose distance is then that
    /// from the plane.
    pub(crate) fn is_below_point(&self) -> bool {
        are_inside(self.weights)
    }

    /// Computes a ball of the slab near the nearest one: the one below the point, without its
    /// negative weights.
    pub(crate) fn near_foot(&self, p: DVec3, balls: &[Ball; 3]) -> Foot {
        let kept = self.weights.map(|weight| weight.max(0.0));
        let sum: f64 = kept.iter().sum();
        Foot::at(p, balls, kept.map(|weight| weight / sum))
    }
}

impl CenterPlane {
    /// Computes the plane; `None` where the centers are on a line.
    pub(super) fn new(balls: &[Ball; 3]) -> Option<Self> {
        let [a, b, c] = balls;
        let (e1, e2) = (b.center - a.center, c.center - a.center);
        let cross = triangle::normal([a.center, b.center, c.center]);
        let cross_squared = cross.length_squared();
        let sine_squared = cross_squared / (e1.length_squared() * e2.length_squared());
        // Coinciding centers give NaN, and no plane either.
        if sine_squared.is_nan() || sine_squared <= MIN_SINE_SQUARED {
            return None;
        }

        // Each weight changes by 1 along its side and not along the other.
        let duals = [e2.cross(cross) / cross_squared, cross.cross(e1) / cross_squared];
        let slope = duals[0] * (b.radius - a.radius) + duals[1] * (c.radius - a.radius);
        let rest = 1.0 - slope.length_squared();
        let flatness = if rest > 0.0 { (cross_squared * rest).sqrt() } else { f64::NAN };
        Some(Self { cross, cross_squared, sine_squared, duals, slope, flatness })
    }

    /// Computes the weights of the stationary ball, which is in the slab where none is negative;
    /// `None` where the slope of the radius is 1 or more.
    ///
    /// With G the gradient of the radius in the plane and y the height of P over it, f is
    /// stationary at the foot of the perpendicular moved by `G y / √(1 − |G|²)`.
    #[inline]
    pub(super) fn stationary_weights(&self, p: DVec3, balls: &[Ball; 3]) -> Option<[f64; 3]> {
        if self.flatness.is_nan() {
            return None;
        }

        // The foot of the perpendicular, moved by the lead.
        let w = p - balls[0].center;
        let lead = w.dot(self.cross).abs() / self.flatness;
        let at = w + lead * self.slope;
        let [b, c] = [self.duals[0].dot(at), self.duals[1].dot(at)];
        Some([1.0 - b - c, b, c])
    }

    /// Computes the unit normal of the plane that touches the three balls, on the side of `w`.
    fn outward(&self, w: DVec3) -> DVec3 {
        let rest = (1.0 - self.slope.length_squared()) / self.cross_squared;
        let up = rest.max(0.0).sqrt().copysign(w.dot(self.cross));
        (up * self.cross - self.slope).normalize_or_zero()
    }
}

/// Returns true if weights are those of a ball in the slab.
pub(super) fn are_inside(weights: [f64; 3]) -> bool {
    weights.iter().all(|&weight| weight >= 0.0)
}
