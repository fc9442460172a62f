//! The point of a polygon closest to the origin, and its weights.
//!
//! Only hints come from here: directions to certify, and the weights of a
//! contact that rounding cannot tell from a near miss.

use glam::DVec3;

use crate::polygon::{Corners, MovingPolygon, Shape, mix_points};

/// A point of a polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Closest<const N: usize> {
    pub(crate) point: DVec3,
    /// Weights of the corners.
    pub(crate) weights: [f64; N],
}

impl<const N: usize> MovingPolygon<'_, N>
where
    Shape<N>: Corners<N>,
{
    /// The point closest to the origin at time `t`.
    #[inline]
    pub(crate) fn closest(&self, t: f64) -> Closest<N> {
        let [first, last] = self.outline.edges(t);
        let corner = mix_points(self.outline.corner[0], self.outline.corner[1], t);
        let area = first.cross(last);
        let squared = area.length_squared();
        if squared > 0.0 {
            let turned = area.cross(corner);
            let inside = Shape::<N>::edge_functions(turned.dot(first), -turned.dot(last), squared);
            if inside.iter().all(|&w| w >= 0.0) {
                let point = area * (area.dot(corner) / squared);
                return Closest { point, weights: Shape::<N>::corner_weights(inside) };
            }
        }
        closest_on_edges(&self.corners(t))
    }
}

fn closest_on_edges<const N: usize>(corners: &[DVec3; N]) -> Closest<N> {
    let mut best = (f64::INFINITY, 0, 0.0, DVec3::ZERO);
    for i in 0..N {
        let (a, b) = (corners[i], corners[(i + 1) % N]);
        let share = closest_share(a, b);
        let point = if share >= 1.0 { b } else { a + share * (b - a) };
        let squared = point.length_squared();
        if squared < best.0 {
            best = (squared, i, share, point);
        }
    }
    let (_, i, share, mut point) = best;
    if 0.0 < share && share < 1.0 {
        // Rounding is large beside a point near the origin, but as a direction
        // it must be perpendicular to the edge.
        let edge = corners[(i + 1) % N] - corners[i];
        point -= edge * (point.dot(edge) / edge.length_squared());
    }
    let mut weights = [0.0; N];
    weights[i] = 1.0 - share;
    weights[(i + 1) % N] = share;
    Closest { point, weights }
}

/// Share of `b` in the point of segment `ab` closest to the origin.
fn closest_share(a: DVec3, b: DVec3) -> f64 {
    let ab = b - a;
    let squared = ab.length_squared();
    if squared > 0.0 { (-a.dot(ab) / squared).clamp(0.0, 1.0) } else { 0.0 }
}
