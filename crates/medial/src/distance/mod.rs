//! Exact distances from points and balls to balls, cones and slabs, and between two of these, in
//! closed form.
//!
//! A cone is the union of all balls interpolated between two, a slab of all those interpolated
//! between three; both are the convex hulls of their balls. The distance of a point P to one is
//! the minimum of `f(w) = |P − c(w)| − r(w)` over the weights w. As a norm of an affine function
//! less an affine function, f is convex: a stationary point inside the range of the weights is the
//! minimum, and without one the minimum is on the border of the range.
//!
//! Sources: B. Gilles, *Anatomical and kinematical modelling of the musculoskeletal system using
//! MRI*, PhD thesis, 2007, section 4.7.2, takes the closest point of the bare face and interpolates
//! the radius there; see [`FootRule::BareFace`] for its error. The slab as a primitive is that of
//! P. Li, B. Wang, F. Sun, X. Guo, C. Zhang and W. Wang, "Q-MAT: Computing Medial Axis Transform by
//! Quadratic Error Minimization", ACM TOG 35(1), 2015. The closed forms here are derived from
//! stationarity alone and need no quadratics case by case.

mod cone;
mod pair;
mod plane;
mod slab;

use glam::DVec3;

pub use self::cone::cone_foot;
pub use self::pair::{PairFoot, pair_foot};
pub(crate) use self::plane::TangentPlane;
pub(crate) use self::slab::PreparedSlab;
pub use self::slab::{bare_face_foot, slab_foot};
use crate::Ball;

/// Rule that selects the ball of a primitive that a point is compared with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum FootRule {
    /// The ball with the smallest signed distance: the distance of the primitive is exact.
    #[default]
    Exact,
    /// The ball at the closest point of the bare face of centers, as in the source.
    ///
    /// Its distance is never below the exact one, so that a contact may be lost, but never
    /// invented. Where the radius changes with slope k, it is too large by
    /// `r (1/√(1 − k²) − 1) ≈ r k²/2` at the surface, and the normal is off by `asin k`.
    BareFace,
}

/// Ball of a primitive that a point P is compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Weights of the primitive's balls, `>= 0`, with sum one.
    pub weights: [f64; 3],
    /// The ball interpolated with them.
    pub ball: Ball,
    /// `|P − c| − r`: signed distance of P to that ball, negative inside.
    pub distance: f64,
}

impl Foot {
    /// Interpolates balls with `weights`, and computes the distance of `p`.
    pub(crate) fn at(p: DVec3, balls: &[Ball; 3], weights: [f64; 3]) -> Self {
        let ball = Ball::interpolate(balls, weights);
        Self { weights, ball, distance: ball.distance(p) }
    }

    /// Returns the nearer of two feet of one point, the first of equals.
    pub(crate) fn nearer(self, other: Self) -> Self {
        if other.distance < self.distance { other } else { self }
    }

    /// Computes the unit vector from the center of the ball to `p`; `None` where they coincide up
    /// to rounding.
    #[must_use]
    pub fn normal(&self, p: DVec3) -> Option<DVec3> {
        direction(self.ball.center, p)
    }
}

/// Computes the foot of `p` on the primitive of three balls.
///
/// A cone is a slab with one ball given twice, a ball one with three.
#[must_use]
pub fn foot(p: DVec3, balls: &[Ball; 3], rule: FootRule) -> Foot {
    match rule {
        FootRule::Exact => slab_foot(p, balls),
        FootRule::BareFace => bare_face_foot(p, balls),
    }
}

/// Share of the coordinates' size below which the difference of two points has no direction: a few
/// rounding errors of an interpolation.
///
/// Ten times smaller, and the direction would be that of the rounding; ten thousand times larger
/// still is a picometer in a body measured in millimeters.
const DIRECTION_FLOOR: f64 = 16.0 * f64::EPSILON;

/// Computes the unit vector from `from` to `to`; `None` where they coincide up to rounding.
pub(crate) fn direction(from: DVec3, to: DVec3) -> Option<DVec3> {
    let d = to - from;
    let length = d.length();
    let scale = from.abs().max_element().max(to.abs().max_element());
    (length > DIRECTION_FLOOR * scale).then(|| d / length)
}
