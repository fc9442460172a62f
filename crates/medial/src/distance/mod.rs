//! Exact distances from points and balls to balls, cones and slabs, and
//! between two such primitives, in closed form.
//!
//! A cone is the union of all balls interpolated between two, a slab of all
//! those interpolated between three; both are the convex hulls of their balls
//! at the ends. The distance of a point P to one is the least of
//! `f(w) = |P − c(w)| − r(w)` over the weights w. As a norm of something affine
//! less something affine, f is convex: a stationary point inside the weights'
//! range is the least, and without one the least lies on the range's border.
//!
//! Sources: B. Gilles, *Anatomical and kinematical modelling of the
//! musculoskeletal system using MRI*, PhD thesis, 2007, section 4.7.2, takes
//! the closest point of the bare face and interpolates the radius there; see
//! [`FootRule::BareFace`] for what that misses. The slab as a primitive is that
//! of P. Li, B. Wang, F. Sun, X. Guo, C. Zhang and W. Wang, "Q-MAT: Computing
//! Medial Axis Transform by Quadratic Error Minimization", ACM TOG 35(1), 2015.
//! The closed forms here are derived from stationarity alone and need no case
//! by case quadratics.

mod cone;
mod pair;
mod slab;

use glam::DVec3;

pub use self::cone::cone_foot;
pub use self::pair::{PairFoot, pair_foot};
pub(crate) use self::slab::Touching;
pub use self::slab::{bare_face_foot, slab_foot};
use crate::Ball;

/// Which ball of a primitive stands for it against a point.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FootRule {
    /// The ball that comes nearest or reaches deepest: the distance is exact.
    #[default]
    Exact,
    /// The ball at the closest point of the bare face of centers, as the source
    /// has it.
    ///
    /// Its distance is never smaller than the exact one, so a contact may be
    /// missed, never invented. Where the radius changes with slope k, by
    /// `r (1/√(1 − k²) − 1) ≈ r k²/2` at the surface, with a normal that is off
    /// by `asin k`.
    BareFace,
}

/// The ball of a primitive that is compared with a point P.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Foot {
    /// Weights of the primitive's balls, none negative, with sum one.
    pub weights: [f64; 3],
    /// The ball interpolated with them.
    pub ball: Ball,
    /// `|P − c| − r`: signed distance of P to that ball, negative inside.
    pub distance: f64,
}

impl Foot {
    /// The ball with `weights` of `balls`, seen from `p`.
    pub(crate) fn at(p: DVec3, balls: &[Ball; 3], weights: [f64; 3]) -> Self {
        let ball = Ball::interpolate(balls, weights);
        Self { weights, ball, distance: ball.distance(p) }
    }

    /// The nearer of two feet of one point; the first when they are equally near.
    pub(crate) fn nearer(self, other: Self) -> Self {
        if other.distance < self.distance { other } else { self }
    }

    /// Unit vector from the ball's center to `p`, or `None` where they coincide
    /// up to rounding and no direction is left.
    #[must_use]
    pub fn normal(&self, p: DVec3) -> Option<DVec3> {
        direction(self.ball.center, p)
    }
}

/// The foot of `p` on the primitive of three balls under `rule`.
///
/// A cone is a slab with one ball given twice, a ball one with three.
#[must_use]
pub fn foot(p: DVec3, balls: &[Ball; 3], rule: FootRule) -> Foot {
    match rule {
        FootRule::Exact => slab_foot(p, balls),
        FootRule::BareFace => bare_face_foot(p, balls),
    }
}

/// Share of the coordinates' size below which the difference of two points has
/// no direction: a few rounding errors of an interpolation. Ten times smaller
/// and the direction would be that of the rounding; ten thousand times larger
/// still is a picometre in a body measured in millimetres.
const DIRECTION_FLOOR: f64 = 16.0 * f64::EPSILON;

/// Unit vector from `from` to `to`, where rounding leaves one.
pub(crate) fn direction(from: DVec3, to: DVec3) -> Option<DVec3> {
    let d = to - from;
    let length = d.length();
    let scale = from.abs().max_element().max(to.abs().max_element());
    (length > DIRECTION_FLOOR * scale).then(|| d / length)
}
