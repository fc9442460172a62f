//! Point of a moving polygon closest to the origin, and its weights.
//!
//! Directions are only hints, to be certified. The length of weighted corners is that of a point of
//! the polygon, and proves that it is near.

use glam::DVec3;

use crate::polygon::MovingPolygon;
use crate::rounding::UNDERFLOW;
use crate::shape::{Corners, PolygonShape};

/// Point of a polygon closest to the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ClosestToOrigin<const N: usize> {
    pub(crate) point: DVec3,
    /// Weights of the corners.
    pub(crate) weights: [f64; N],
}

/// Point of a polygon closest to the origin, with the length of its weighted corners.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WeightedClosest<const N: usize> {
    pub(crate) closest: ClosestToOrigin<N>,
    /// The closest point or, where that differs from the weighted corners, these.
    pub(crate) hint: DVec3,
    /// Squared length of the weighted corners. Up to [`Outline::rounding`](crate::outline::Outline),
    /// the polygon has a point at that distance from the origin, whatever the weights are worth.
    pub(crate) length_squared: f64,
}

impl<const N: usize> MovingPolygon<'_, N>
where
    PolygonShape<N>: Corners<N>,
{
    /// Finds the point closest to the origin at time `t`.
    #[inline]
    pub(crate) fn closest(&self, t: f64) -> ClosestToOrigin<N> {
        let [first, last] = self.outline.edges(t);
        let corner = self.outline.corner_at(t);
        let area = first.cross(last);
        let squared = area.length_squared();

        // Where the origin projects into the polygon, the projection is the closest point. A polygon so
        // thin that the square of its area underflows is as its edges.
        if squared > UNDERFLOW {
            let turned = area.cross(corner);
            let inside =
                PolygonShape::<N>::edge_functions(turned.dot(first), -turned.dot(last), squared);
            if inside.iter().all(|&w| w >= 0.0) {
                let point = area * (area.dot(corner) / squared);
                let weights = PolygonShape::<N>::corner_weights(inside);
                return ClosestToOrigin { point, weights };
            }
        }
        closest_on_edges(&self.corners(t))
    }

    /// Finds the point closest to the origin at time `t`, and the point of the polygon that its
    /// weights make.
    #[inline]
    pub(crate) fn weighted_closest(&self, t: f64) -> WeightedClosest<N> {
        self.weighted(self.closest(t), t)
    }

    /// Finds the point of the polygon that the weights of the closest one at time `t` make.
    ///
    /// The area vector of a polygon whose corners are nearly in line may be rounding alone. A point
    /// along it may be far from the polygon, and its weights those of any other point. Where the two
    /// differ, the closest point of the edges is taken if that is nearer.
    #[inline]
    pub(crate) fn weighted(&self, closest: ClosestToOrigin<N>, t: f64) -> WeightedClosest<N> {
        let corners = self.corners(t);
        let mean = weighted(&corners, closest.weights);
        let length_squared = mean.length_squared();
        let same = SAME_POINT * SAME_POINT * length_squared + self.outline.rounding().powi(2);
        if mean.distance_squared(closest.point) <= same {
            return WeightedClosest { hint: closest.point, closest, length_squared };
        }
        on_edges_if_nearer(&corners, closest, mean)
    }
}

/// Returns the closest point of the edges if it is nearer than the weighted corners, else these.
#[cold]
fn on_edges_if_nearer<const N: usize>(
    corners: &[DVec3; N],
    closest: ClosestToOrigin<N>,
    mean: DVec3,
) -> WeightedClosest<N> {
    let on_edges = closest_on_edges(corners);
    let squared_on_edges = weighted(corners, on_edges.weights).length_squared();
    if squared_on_edges < mean.length_squared() {
        let (hint, length_squared) = (on_edges.point, squared_on_edges);
        return WeightedClosest { closest: on_edges, hint, length_squared };
    }
    WeightedClosest { closest, hint: mean, length_squared: mean.length_squared() }
}

impl<const N: usize> WeightedClosest<N> {
    /// Returns the point whose direction is to be certified.
    #[inline]
    pub(crate) fn into_hint(self) -> ClosestToOrigin<N> {
        ClosestToOrigin { point: self.hint, ..self.closest }
    }
}

/// Distance between the closest point and the weighted corners, relative to their length, up to
/// which both are the same point.
///
/// Larger leaves points in use whose lengths are off by it; smaller also searches the edges for
/// points that are only rounded.
const SAME_POINT: f64 = 1e-11;

/// Returns the sum of the corners times their weights.
fn weighted<const N: usize>(corners: &[DVec3; N], weights: [f64; N]) -> DVec3 {
    (0..N).map(|i| corners[i] * weights[i]).sum()
}

/// Finds the point of the edges closest to the origin.
fn closest_on_edges<const N: usize>(corners: &[DVec3; N]) -> ClosestToOrigin<N> {
    let (mut edge, mut fraction, mut point) = (0, 0.0, DVec3::ZERO);
    let mut min_squared = f64::INFINITY;
    for i in 0..N {
        let (a, b) = (corners[i], corners[(i + 1) % N]);
        let fraction_i = closest_fraction(a, b);
        let point_i = if fraction_i >= 1.0 { b } else { a + fraction_i * (b - a) };
        let squared = point_i.length_squared();
        if squared < min_squared {
            (min_squared, edge, fraction, point) = (squared, i, fraction_i, point_i);
        }
    }

    // Rounding is large beside a point near the origin, but as a direction the point must be
    // perpendicular to the edge.
    if 0.0 < fraction && fraction < 1.0 {
        let along = corners[(edge + 1) % N] - corners[edge];
        point -= along * (point.dot(along) / along.length_squared());
    }

    let mut weights = [0.0; N];
    weights[edge] = 1.0 - fraction;
    weights[(edge + 1) % N] = fraction;
    ClosestToOrigin { point, weights }
}

/// Returns the parameter of the point of segment `ab` closest to the origin: 0 at `a`, 1 at `b`. A
/// segment whose square underflows is as a point.
fn closest_fraction(a: DVec3, b: DVec3) -> f64 {
    let ab = b - a;
    let squared = ab.length_squared();
    if squared > UNDERFLOW { (-a.dot(ab) / squared).clamp(0.0, 1.0) } else { 0.0 }
}
