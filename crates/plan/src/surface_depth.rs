//! Depth of the surfaces of a pair, in certified brackets.
//!
//! Depth is the greatest distance of a point of one surface inside the other body from the other
//! surface, the larger of both directions. Unlike the depth of vertices it depends on the shape
//! alone, so that it changes by no more than two surfaces deviate.
//!
//! Distance from a surface changes by no more than the way between two points. A point of a face
//! is within `L/√3` of a corner, `L` the longest edge. If that corner is inside, the point is at
//! most as much deeper; if it is outside, the way there leaves the body. Where faces are small
//! beside the width that is asked for, depths of vertices therefore bracket the depth already.
//! Elsewhere the crate `overlap` searches by branch and bound.

use overlap::{Depth, DepthParams, Overlap, OverlapDetector};
use proximity::{PairProximity, SurfaceTree};
use scene::DepthBracket;

use crate::OperationCounts;
use crate::cost::count;

/// Closest points per search, some seconds: reached where whole surfaces are equally deep.
const MAX_QUERIES: u32 = 2_000_000;

/// Roundings of a coordinate that a distance may be off by.
const ROUNDINGS: f64 = 64.0;

/// Search for depths, in memory that is reused from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct SurfaceDepth {
    detector: OverlapDetector,
    measures: Overlap,
}

impl SurfaceDepth {
    /// Brackets the depth of two bodies whose proximity was computed, no wider than `width`.
    ///
    /// Wider only where a body covers a place twice or is not oriented: its depth is then bracketed
    /// by that of vertices.
    pub(crate) fn bracket(
        &mut self,
        found: &PairProximity,
        bodies: [&SurfaceTree; 2],
        width: f64,
        operations: &mut OperationCounts,
    ) -> DepthBracket {
        // Nothing meets and nothing is inside.
        if found.meeting_faces().is_empty() && !found.overlaps() {
            return DepthBracket::default();
        }
        let by_vertices = [0, 1].map(|side| vertex_bracket(side, found, bodies));
        let bracket = larger(by_vertices);
        if bracket.upper - bracket.lower <= width {
            return bracket;
        }

        // Both brackets hold, so that the narrower one of each side counts.
        let searched = self.search(found.meeting_faces(), bodies, width, operations);
        larger([0, 1].map(|side| match searched[side] {
            None => by_vertices[side],
            Some(found) => DepthBracket {
                lower: found.lower.max(by_vertices[side].lower),
                upper: found.upper.min(by_vertices[side].upper),
            },
        }))
    }

    /// Brackets the depth of each body's surface in the other body by branch and bound, from all
    /// pairs of faces that share a point.
    ///
    /// `None` for a side whose other body has no inside, or covers a place twice.
    pub(crate) fn search(
        &mut self,
        meeting: &[[u32; 2]],
        bodies: [&SurfaceTree; 2],
        width: f64,
        operations: &mut OperationCounts,
    ) -> [Option<DepthBracket>; 2] {
        operations.searched_faces += count(meeting.len());
        self.detector.measure_candidates(bodies, meeting, &mut self.measures);
        let params =
            DepthParams { relative_tolerance: 0.0, tolerance: width, max_queries: MAX_QUERIES };
        let depths = self.detector.depths(bodies, &params);
        operations.depth_queries += f64::from(self.detector.queries());

        let Overlap { no_inside, covers_twice, .. } = &self.measures;
        [0, 1].map(|side| {
            let other = 1 - side;
            let is_defined = no_inside[other].is_none() && !covers_twice[other];
            is_defined.then(|| depths[side].map_or_else(DepthBracket::default, bracket))
        })
    }
}

/// Returns the bracket of the larger of two depths.
pub(crate) fn larger([p, q]: [DepthBracket; 2]) -> DepthBracket {
    DepthBracket { lower: p.lower.max(q.lower), upper: p.upper.max(q.upper) }
}

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
    ROUNDINGS * f64::EPSILON * size
}

fn bracket(depth: Depth) -> DepthBracket {
    DepthBracket { lower: depth.lower, upper: depth.upper }
}

/// Brackets the depth of one surface in the other body by the depths of its vertices.
fn vertex_bracket(side: usize, found: &PairProximity, bodies: [&SurfaceTree; 2]) -> DepthBracket {
    let (own, other) = (bodies[side], bodies[1 - side]);
    let mut bracket = DepthBracket::default();
    if other.has_inside().is_err() {
        return bracket;
    }

    // Faces that meet the other surface, from their corners outside.
    for meeting in found.meeting_faces() {
        bracket.upper = bracket.upper.max(max_distance_to_corner(own, meeting[side]));
    }

    // Faces at inside vertices, from those.
    for near in found.sides()[side].near() {
        if near.gap >= 0.0 {
            continue;
        }
        bracket.lower = bracket.lower.max(-near.gap);
        for &face in own.surface().vertex_faces(near.vertex) {
            let depth = max_distance_to_corner(own, face) - near.gap;
            bracket.upper = bracket.upper.max(depth);
        }
    }
    bracket.upper += rounding(bodies);
    bracket
}

/// Bounds the distance of a point of a face from the nearest corner: longest edge over √3.
fn max_distance_to_corner(body: &SurfaceTree, face: u32) -> f64 {
    let [a, b, c] = body.corners(face);
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    (longest / 3.0).sqrt()
}

#[cfg(test)]
mod tests {
    use fixtures::shapes::{capsule, icosphere, plate};
    use glam::DVec3;

    use super::*;

    fn tree(mesh: &fixtures::Mesh) -> SurfaceTree {
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

    /// Brackets a depth at a width; returns true as well if it was searched for.
    fn depth(bodies: [&SurfaceTree; 2], width: f64) -> (DepthBracket, bool) {
        let mut found = PairProximity::default();
        found.compute(bodies[0], bodies[1], 0.0);
        let mut operations = OperationCounts::default();
        let bracket = SurfaceDepth::default().bracket(&found, bodies, width, &mut operations);
        (bracket, operations.depth_queries > 0.0)
    }

    #[test]
    fn brackets_hold_the_depth_at_every_width() {
        // A rod in a box: the end of its cap is 8 deep, the corners of the box are not.
        let rod = capsule(2.0, 30.0, 16);
        let lowest = rod.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        let rod = tree(&rod.translated(DVec3::new(12.0, 3.0, -8.0 - lowest)));
        let muscle = plate(DVec3::new(60.0, 60.0, 40.0), [1, 1]).translated(DVec3::Z * -20.0);
        let muscle = tree(&muscle);
        for width in [50.0, 2.0, 0.5, 0.1, 0.01] {
            let (bracket, _) = depth([&rod, &muscle], width);
            assert!(bracket.upper - bracket.lower <= width, "{width}: {bracket:?}");
            let contains = bracket.lower <= 8.0 + 1e-9 && bracket.upper >= 8.0 - 1e-9;
            assert!(contains, "{width}: {bracket:?}");
        }
    }

    #[test]
    fn vertices_of_fine_surfaces_take_no_search() {
        let [a, b] = [0.0, 58.0].map(|x| tree(&icosphere(30.0, 5).translated(DVec3::X * x)));
        let (coarse, is_searched) = depth([&a, &b], 2.0);
        assert!(!is_searched, "{coarse:?}");
        let (fine, is_searched) = depth([&a, &b], 0.01);
        assert!(is_searched, "{fine:?}");
        assert!(coarse.lower <= fine.upper && fine.lower <= coarse.upper);
    }
}
