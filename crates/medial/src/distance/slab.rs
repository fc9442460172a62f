//! Nearest ball of a slab, exactly and by the bare face.

use glam::DVec3;
use surface::closest_on_triangle;

use super::Foot;
use super::cone::ConeAxis;
use super::plane::{CenterPlane, are_inside};
use crate::Ball;

/// Squared sine of the angle between the sides of a slab below which the cones at its border are
/// computed even when the stationary ball is inside.
///
/// The solution then has fewer than half its digits, and a border may be nearer by rounding.
const MIN_RELIABLE_SINE_SQUARED: f64 = 1e-8;

/// Squared sine above which the signs of the weights select the cones at the border.
///
/// Below, rounding may give the wrong sign, and all three cones are computed.
const MIN_SIGN_SINE_SQUARED: f64 = 1e-4;

/// Computes the ball between three balls with the smallest signed distance to `p`, exactly.
///
/// Balls may coincide, lie on a line, or contain each other.
///
/// ```
/// use glam::DVec3;
/// use medial::{Ball, slab_foot};
///
/// let slab = [
///     Ball::new(DVec3::ZERO, 1.0),
///     Ball::new(DVec3::X * 10.0, 1.0),
///     Ball::new(DVec3::Y * 10.0, 1.0),
/// ];
/// let foot = slab_foot(DVec3::new(2.0, 3.0, 4.0), &slab);
/// assert!((foot.distance - 3.0).abs() < 1e-14);
/// assert!((foot.weights[1] - 0.2).abs() < 1e-15 && (foot.weights[2] - 0.3).abs() < 1e-15);
/// ```
#[must_use]
pub fn slab_foot(p: DVec3, balls: &[Ball; 3]) -> Foot {
    SlabParts { balls, plane: CenterPlane::new(balls).as_ref(), cones: None }.foot(p)
}

/// Slab with what the feet of many points on it have in common.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PreparedSlab {
    balls: [Ball; 3],
    plane: Option<CenterPlane>,
    /// Axes of the cones opposite to each ball.
    cones: [ConeAxis; 3],
}

impl PreparedSlab {
    pub(crate) fn new(balls: [Ball; 3]) -> Self {
        let cones = [0, 1, 2].map(|opposite| opposite_axis(&balls, opposite));
        Self { balls, plane: CenterPlane::new(&balls), cones }
    }

    /// Computes the foot that [`slab_foot`] does.
    pub(crate) fn foot(&self, p: DVec3) -> Foot {
        let Self { balls, plane, cones } = self;
        SlabParts { balls, plane: plane.as_ref(), cones: Some(cones) }.foot(p)
    }
}

/// Computes the ball at the point of the bare face of centers that is closest to `p`: the rule of
/// the source, see [`FootRule::BareFace`](crate::FootRule::BareFace).
#[must_use]
pub fn bare_face_foot(p: DVec3, balls: &[Ball; 3]) -> Foot {
    let closest = closest_on_triangle(p, Ball::centers(balls));
    Foot::at(p, balls, closest.barycentric)
}

/// Slab by its parts, of which cones are computed when they are needed.
struct SlabParts<'a> {
    balls: &'a [Ball; 3],
    plane: Option<&'a CenterPlane>,
    cones: Option<&'a [ConeAxis; 3]>,
}

impl SlabParts<'_> {
    #[inline(always)]
    fn foot(&self, p: DVec3) -> Foot {
        let Some(plane) = self.plane else { return self.border_foot(p) };

        match plane.stationary_weights(p, self.balls) {
            Some(weights) if are_inside(weights) => {
                let foot = Foot::at(p, self.balls, weights);
                let is_reliable = plane.sine_squared > MIN_RELIABLE_SINE_SQUARED;
                if is_reliable { foot } else { foot.nearer(self.border_foot(p)) }
            }
            Some(weights) if plane.sine_squared > MIN_SIGN_SINE_SQUARED => {
                self.foot_beyond(p, weights)
            }
            _ => self.border_foot(p),
        }
    }

    /// Computes the nearest foot on the three cones at the border of the slab.
    fn border_foot(&self, p: DVec3) -> Foot {
        self.nearest_on(p, [2, 0, 1].into_iter())
    }

    /// Computes the nearest foot where some weights of the stationary ball are negative: on the
    /// cones that it lies beyond.
    ///
    /// On the way to the stationary ball from any ball of the slab f falls, since it is convex, and
    /// that way leaves the slab through one of these cones.
    #[inline(always)]
    fn foot_beyond(&self, p: DVec3, weights: [f64; 3]) -> Foot {
        let foot = self.nearest_on(p, (0..3).filter(|&k| weights[k] < 0.0));
        // Weights that are NaN are not negative.
        if foot.distance.is_nan() { self.border_foot(p) } else { foot }
    }

    /// Computes the nearest foot on the cones opposite to some balls, the first of equals; its
    /// distance is NaN where there are none.
    ///
    /// Only numbers are compared, and one foot is written: whole feet take twice as long.
    #[inline(always)]
    fn nearest_on(&self, p: DVec3, opposites: impl Iterator<Item = usize>) -> Foot {
        let (mut nearest, mut weights, mut is_first) = (f64::NAN, [0.0; 3], true);
        for opposite in opposites {
            let (first, second) = ((opposite + 1) % 3, (opposite + 2) % 3);
            let t = match self.cones {
                Some(cones) => cones[opposite].parameter(p),
                None => opposite_axis(self.balls, opposite).parameter(p),
            };
            let distance = Ball::between(self.balls[first], self.balls[second], t).distance(p);
            if is_first || distance < nearest {
                (nearest, is_first) = (distance, false);
                weights = [0.0; 3];
                (weights[first], weights[second]) = (1.0 - t, t);
            }
        }
        Foot { weights, ball: Ball::interpolate(self.balls, weights), distance: nearest }
    }
}

/// Returns the axis of the cone opposite to a ball.
fn opposite_axis(balls: &[Ball; 3], opposite: usize) -> ConeAxis {
    ConeAxis::new(balls[(opposite + 1) % 3], balls[(opposite + 2) % 3])
}
