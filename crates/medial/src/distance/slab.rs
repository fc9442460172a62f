//! The ball of a slab that a point is nearest to, exactly and by the bare face.

use glam::DVec3;
use surface::closest_on_triangle;

use super::Foot;
use super::cone::cone_parameter;
use crate::Ball;

/// Sine, squared, of the angle between two sides of a slab's face of centers below
/// which the slab is handled by its three cones alone.
///
/// Below it the in-plane solve has lost all its digits, while the cones are within
/// `1e-8` of a side of every ball of the slab. Relative to the sides, so it holds at
/// any scale.
const SLIVER: f64 = 1e-16;

/// Sine, squared, below which the cones are looked at even when the stationary point
/// is inside: the solve then has fewer than half its digits, and a border may be
/// nearer by rounding.
const DOUBTFUL: f64 = 1e-8;

/// Sine, squared, from which on the signs of weights tell which borders to look at.
const SLANTED: f64 = 1e-4;

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
    let Some(plane) = Plane::of(balls) else { return border_foot(p, balls) };
    match plane.stationary(p, balls) {
        Some(weights) if inside(weights) => {
            let foot = Foot::at(p, balls, weights);
            let is_sure = plane.sine_squared > DOUBTFUL;
            if is_sure { foot } else { foot.nearer(border_foot(p, balls)) }
        }
        Some(weights) if plane.sine_squared > SLANTED => foot_beyond(p, balls, weights),
        _ => border_foot(p, balls),
    }
}

/// The ball at the point of the bare face of centers that is closest to `p`:
/// the source's rule, see [`FootRule::BareFace`](crate::FootRule::BareFace).
#[must_use]
pub fn bare_face_foot(p: DVec3, balls: &[Ball; 3]) -> Foot {
    let closest = closest_on_triangle(p, balls.map(|ball| ball.center));
    Foot::at(p, balls, closest.barycentric)
}

/// What the plane that touches a slab's balls tells of a point, without a look at the
/// slab's border.
pub(crate) struct Touching {
    /// Unit normal of the plane, on the side of the point.
    pub(crate) outward: DVec3,
    /// Weights of the ball that the plane touches below the point; it is the nearest one
    /// where none is negative.
    weights: [f64; 3],
}

impl Touching {
    /// `None` where the centers lie on a line, or no plane touches all three balls.
    pub(crate) fn of(p: DVec3, balls: &[Ball; 3]) -> Option<Self> {
        let plane = Plane::of(balls)?;
        let weights = plane.stationary(p, balls)?;
        Some(Self { outward: plane.outward(p - balls[0].center), weights })
    }

    /// Whether the point is above the slab, and so its distance that from the plane.
    pub(crate) fn is_above(&self) -> bool {
        inside(self.weights)
    }

    /// A ball of the slab near the one that the point is nearest to: that below it,
    /// without what has negative weights.
    pub(crate) fn near_foot(&self, p: DVec3, balls: &[Ball; 3]) -> Foot {
        let kept = self.weights.map(|weight| weight.max(0.0));
        let sum: f64 = kept.iter().sum();
        Foot::at(p, balls, kept.map(|weight| weight / sum))
    }
}

/// The plane of a slab's centers with the slope of the radius in it.
struct Plane {
    /// Product of the sides from the first center to the second and the third, and its
    /// squared length.
    cross: DVec3,
    cross_squared: f64,
    /// Of the angle between the sides.
    sine_squared: f64,
    /// Their dual basis: what a way in the plane changes the weights of the second and
    /// the third ball by.
    duals: [DVec3; 2],
    /// Gradient of the radius.
    slope: DVec3,
}

impl Plane {
    /// `None` where the centers lie on a line.
    fn of(balls: &[Ball; 3]) -> Option<Self> {
        let [a, b, c] = balls;
        let (e1, e2) = (b.center - a.center, c.center - a.center);
        let cross = e1.cross(e2);
        let cross_squared = cross.length_squared();
        let sine_squared = cross_squared / (e1.length_squared() * e2.length_squared());
        // A NaN, from centers that coincide, is no plane either.
        if sine_squared.is_nan() || sine_squared <= SLIVER {
            return None;
        }
        let duals = [e2.cross(cross) / cross_squared, cross.cross(e1) / cross_squared];
        let slope = duals[0] * (b.radius - a.radius) + duals[1] * (c.radius - a.radius);
        Some(Self { cross, cross_squared, sine_squared, duals, slope })
    }

    /// Weights of the stationary ball, which lies inside the slab where none is
    /// negative. `None` where the radius grows as fast as the way.
    ///
    /// With G the gradient of the radius in the plane and y the height of P
    /// over it, f is stationary at the foot of the perpendicular moved by
    /// `G y / √(1 − |G|²)`.
    fn stationary(&self, p: DVec3, balls: &[Ball; 3]) -> Option<[f64; 3]> {
        let rest = 1.0 - self.slope.length_squared();
        if rest <= 0.0 {
            return None;
        }
        let w = p - balls[0].center;
        let lead = w.dot(self.cross).abs() / (self.cross_squared * rest).sqrt();
        let [b, c] = self.duals.map(|dual| dual.dot(w + lead * self.slope));
        Some([1.0 - b - c, b, c])
    }

    /// Unit normal of the plane that touches the three balls, on the side of `w`.
    fn outward(&self, w: DVec3) -> DVec3 {
        let rest = (1.0 - self.slope.length_squared()) / self.cross_squared;
        let up = rest.max(0.0).sqrt().copysign(w.dot(self.cross));
        (up * self.cross - self.slope).normalize_or_zero()
    }
}

fn inside(weights: [f64; 3]) -> bool {
    weights.iter().all(|&weight| weight >= 0.0)
}

/// The best foot on the three cones at the slab's border.
fn border_foot(p: DVec3, balls: &[Ball; 3]) -> Foot {
    let [ab, bc, ca] = [2, 0, 1].map(|opposite| foot_on_side(p, balls, opposite));
    ab.nearer(bc).nearer(ca)
}

/// The best foot where the stationary ball is outside of the slab, with some weights
/// negative: on the cones that it lies beyond. On the way to it from any ball of the
/// slab f falls, since f is convex, and that way leaves through one of them.
fn foot_beyond(p: DVec3, balls: &[Ball; 3], weights: [f64; 3]) -> Foot {
    let feet = (0..3).filter(|&k| weights[k] < 0.0).map(|k| foot_on_side(p, balls, k));
    feet.reduce(Foot::nearer).unwrap_or_else(|| border_foot(p, balls))
}

/// The best foot on the cone opposite to a ball.
fn foot_on_side(p: DVec3, balls: &[Ball; 3], opposite: usize) -> Foot {
    let [from, to] = [(opposite + 1) % 3, (opposite + 2) % 3];
    let t = cone_parameter(p, balls[from], balls[to]);
    let mut weights = [0.0; 3];
    (weights[from], weights[to]) = (1.0 - t, t);
    Foot::at(p, balls, weights)
}
