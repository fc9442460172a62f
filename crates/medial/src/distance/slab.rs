//! Nearest ball of a slab, exactly and by the bare face.

use glam::DVec3;
use surface::closest_on_triangle;

use super::Foot;
use super::cone::cone_parameter;
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
    let Some(plane) = CenterPlane::new(balls) else { return border_foot(p, balls) };

    match plane.stationary_weights(p, balls) {
        Some(weights) if are_inside(weights) => {
            let foot = Foot::at(p, balls, weights);
            let is_reliable = plane.sine_squared > MIN_RELIABLE_SINE_SQUARED;
            if is_reliable { foot } else { foot.nearer(border_foot(p, balls)) }
        }
        Some(weights) if plane.sine_squared > MIN_SIGN_SINE_SQUARED => {
            foot_beyond(p, balls, weights)
        }
        _ => border_foot(p, balls),
    }
}

/// Computes the ball at the point of the bare face of centers that is closest to `p`: the rule of
/// the source, see [`FootRule::BareFace`](crate::FootRule::BareFace).
#[must_use]
pub fn bare_face_foot(p: DVec3, balls: &[Ball; 3]) -> Foot {
    let closest = closest_on_triangle(p, Ball::centers(balls));
    Foot::at(p, balls, closest.barycentric)
}

/// Computes the nearest foot on the three cones at the border of the slab.
fn border_foot(p: DVec3, balls: &[Ball; 3]) -> Foot {
    let [ab, bc, ca] = [2, 0, 1].map(|opposite| foot_on_side(p, balls, opposite));
    ab.nearer(bc).nearer(ca)
}

/// Computes the nearest foot where some weights of the stationary ball are negative: on the cones
/// that it lies beyond.
///
/// On the way to the stationary ball from any ball of the slab f falls, since it is convex, and that
/// way leaves the slab through one of these cones.
fn foot_beyond(p: DVec3, balls: &[Ball; 3], weights: [f64; 3]) -> Foot {
    let feet = (0..3).filter(|&k| weights[k] < 0.0).map(|k| foot_on_side(p, balls, k));
    feet.reduce(Foot::nearer).unwrap_or_else(|| border_foot(p, balls))
}

/// Computes the nearest foot on the cone opposite to a ball.
fn foot_on_side(p: DVec3, balls: &[Ball; 3], opposite: usize) -> Foot {
    let [from, to] = [(opposite + 1) % 3, (opposite + 2) % 3];
    let t = cone_parameter(p, balls[from], balls[to]);

    let mut weights = [0.0; 3];
    (weights[from], weights[to]) = (1.0 - t, t);
    Foot::at(p, balls, weights)
}
