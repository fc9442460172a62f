//! The ball of a slab that a point is nearest to, exactly and by the bare face.

use glam::DVec3;
use surface::closest_on_triangle;

use super::Foot;
use super::cone::cone_parameter;
use crate::Ball;

/// Sine of the angle between two sides of a slab's face of centres below which
/// the slab is handled by its three cones alone.
///
/// Below the root of the machine epsilon the in-plane solve has lost all its
/// digits, while the cones are within `1e-8` of a side of every ball of the
/// slab. Relative to the sides, so it holds at any scale.
const SLIVER_SINE: f64 = 1e-8;

/// Sine below which the cones are looked at even when the stationary point is
/// inside: the solve then has fewer than half its digits, and a border may be
/// nearer by rounding.
const DOUBTFUL_SINE: f64 = 1e-4;

/// The ball between three balls with the least signed distance to `p`, exactly.
///
/// Balls may coincide, lie on a line, or swallow each other.
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
    match Plane::of(balls) {
        Some(plane) => match plane.stationary(p, balls) {
            Some(weights) if plane.sine > DOUBTFUL_SINE => Foot::at(p, balls, weights),
            Some(weights) => Foot::at(p, balls, weights).nearer(border_foot(p, balls)),
            None => border_foot(p, balls),
        },
        None => border_foot(p, balls),
    }
}

/// The ball at the point of the bare face of centres that is closest to `p`:
/// the source's rule, see [`FootRule::BareFace`](crate::FootRule::BareFace).
#[must_use]
pub fn bare_face_foot(p: DVec3, balls: &[Ball; 3]) -> Foot {
    let closest = closest_on_triangle(p, balls.map(|ball| ball.center));
    Foot::at(p, balls, closest.barycentric)
}

/// The plane of a slab's centres with the slope of the radius in it.
struct Plane {
    /// Sides from the first centre to the second and the third.
    sides: [DVec3; 2],
    normal: DVec3,
    /// Of the angle between the sides.
    sine: f64,
    /// Inverse of the sides' Gram matrix: xx, xy, yy.
    inverse: [f64; 3],
    /// Gradient of the radius in weights of the second and the third ball.
    slope: [f64; 2],
    /// Its squared length, without unit.
    slope_squared: f64,
}

impl Plane {
    /// `None` where the centres lie on a line.
    fn of(balls: &[Ball; 3]) -> Option<Self> {
        let [a, b, c] = balls;
        let (e1, e2) = (b.center - a.center, c.center - a.center);
        let (g11, g12, g22) = (e1.length_squared(), e1.dot(e2), e2.length_squared());
        let cross = e1.cross(e2);
        let area = cross.length();
        let sine = area / (g11 * g22).sqrt();
        // A NaN, from centres that coincide, is no plane either.
        if sine.is_nan() || sine <= SLIVER_SINE {
            return None;
        }
        let determinant = area * area;
        let inverse = [g22 / determinant, -g12 / determinant, g11 / determinant];
        let growth = [b.radius - a.radius, c.radius - a.radius];
        let slope = apply(inverse, growth);
        let slope_squared = slope[0] * growth[0] + slope[1] * growth[1];
        Some(Self { sides: [e1, e2], normal: cross / area, sine, inverse, slope, slope_squared })
    }

    /// Weights of the stationary ball, if it lies inside the slab.
    ///
    /// With G the gradient of the radius in the plane and y the height of P
    /// over it, f is stationary at the foot of the perpendicular moved by
    /// `G y / √(1 − |G|²)`.
    fn stationary(&self, p: DVec3, balls: &[Ball; 3]) -> Option<[f64; 3]> {
        if self.slope_squared >= 1.0 {
            return None;
        }
        let w = p - balls[0].center;
        let [foot_b, foot_c] = apply(self.inverse, self.sides.map(|side| side.dot(w)));
        let lead = w.dot(self.normal).abs() / (1.0 - self.slope_squared).sqrt();
        let (b, c) = (foot_b + lead * self.slope[0], foot_c + lead * self.slope[1]);
        let a = 1.0 - b - c;
        (a >= 0.0 && b >= 0.0 && c >= 0.0).then_some([a, b, c])
    }
}

fn apply([xx, xy, yy]: [f64; 3], [x, y]: [f64; 2]) -> [f64; 2] {
    [xx * x + xy * y, xy * x + yy * y]
}

/// The best foot on the three cones at the slab's border.
fn border_foot(p: DVec3, balls: &[Ball; 3]) -> Foot {
    let [a, b, c] = *balls;
    let t = cone_parameter(p, a, b);
    let ab = Foot::at(p, balls, [1.0 - t, t, 0.0]);
    let t = cone_parameter(p, b, c);
    let bc = Foot::at(p, balls, [0.0, 1.0 - t, t]);
    let t = cone_parameter(p, c, a);
    let ca = Foot::at(p, balls, [t, 0.0, 1.0 - t]);
    ab.nearer(bc).nearer(ca)
}
