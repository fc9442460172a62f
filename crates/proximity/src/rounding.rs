//! Rounding of distances between two surfaces.

use crate::SurfaceTree;

/// Bounds how much a computed distance between points or faces of two surfaces may exceed the exact
/// one.
///
/// With s the largest coordinate of both and u = 2⁻⁵³, edges and differences of points are at most
/// 2 √3 s and points √3 s long. So a foot is at most 256 u · 5 √3 s farther than the closest point
/// (`surface::closest`), and the distance to it is rounded by 4 u · 2 √3 s: below 2240 u s.
pub(crate) fn distance_rounding(bodies: [&SurfaceTree; 2]) -> f64 {
    /// Multiple of `f64::EPSILON`, which is 2 u.
    const ROUNDINGS: f64 = 1120.0;

    let size = bodies.map(largest_coordinate).into_iter().fold(0.0, f64::max);
    ROUNDINGS * f64::EPSILON * size
}

/// Bounds the coordinates of a surface.
fn largest_coordinate(body: &SurfaceTree) -> f64 {
    // Bounds in single precision are rounded outward; the first directions are the axes.
    let bounds = body.tree().root();
    let ends = (0..3).flat_map(|axis| bounds.interval(axis));
    let size = ends.map(|end| f64::from(end).abs()).fold(0.0, f64::max);
    if size.is_finite() {
        return size;
    }

    // Beyond the range of single precision.
    let points = body.positions().as_slice().iter();
    points.map(|point| point.abs().max_element()).fold(0.0, f64::max)
}
