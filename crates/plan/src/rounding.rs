//! Rounding of distances between bodies, below which no depth is proved.

use proximity::SurfaceTree;
use response::{ParameterError, parameter};
use scene::Scene;

/// Roundings of a coordinate that a distance may be off by.
const ROUNDINGS: f64 = 64.0;

/// Roundings of a distance below which a search for the deepest point may not come to an end.
const SEARCHED_ROUNDINGS: f64 = 4.0;

/// Returns a bound on the rounding of distances between two bodies.
pub(crate) fn rounding(bodies: [&SurfaceTree; 2]) -> f64 {
    // The largest coordinate, in single precision; the first directions are the axes.
    let mut size: f64 = 0.0;
    for body in bodies {
        let bounds = body.tree().root();
        for axis in 0..3 {
            for end in bounds.interval(axis) {
                size = size.max(f64::from(end).abs());
            }
        }
    }
    rounding_at(size)
}

/// Checks that depths can be proved within a tolerance where the bodies are.
pub(crate) fn check_rounding(scene: &Scene, tolerance: f64) -> Result<(), ParameterError> {
    check_tolerance(tolerance, SEARCHED_ROUNDINGS * rounding_at(scene.largest_coordinate()))
}

/// Checks that depths of two bodies can be proved within a tolerance where they are.
pub(crate) fn check_pair_rounding(
    bodies: [&SurfaceTree; 2],
    tolerance: f64,
) -> Result<(), ParameterError> {
    /// Bounds in single precision are larger than coordinates by less than this share.
    const WIDENING: f64 = 1e-6;

    let least = SEARCHED_ROUNDINGS * (1.0 - WIDENING) * rounding(bodies);
    check_tolerance(tolerance, least)
}

/// Checks that a tolerance is not below the least that can be proved.
fn check_tolerance(tolerance: f64, least: f64) -> Result<(), ParameterError> {
    let range = "at least the rounding of distances between the largest coordinates";
    parameter("tolerance", tolerance, range, tolerance >= least).map(|_| ())
}

/// Returns a bound on the rounding of distances where coordinates are up to `size`.
fn rounding_at(size: f64) -> f64 {
    ROUNDINGS * f64::EPSILON * size
}

#[cfg(test)]
mod tests {
    use fixtures::Mesh;
    use fixtures::shapes::icosphere;
    use glam::DVec3;

    use super::*;

    fn tree(mesh: &Mesh) -> SurfaceTree {
        SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("a tree")
    }

    #[test]
    fn rounding_is_that_of_the_farthest_vertex() {
        let mut ball = icosphere(1.0, 2);
        ball.positions[7] = DVec3::new(0.0, 1e6, 0.0);
        let [near, far] = [tree(&icosphere(1.0, 2)), tree(&ball)];
        for bodies in [[&near, &far], [&far, &near]] {
            assert!(rounding(bodies) >= ROUNDINGS * f64::EPSILON * 1e6);
        }
        assert!(rounding([&near, &near]) < ROUNDINGS * f64::EPSILON * 1.1);
    }
}
