//! Faces of one body that cross each other.

use std::collections::BTreeSet;

use glam::DVec3;
use musculo_collide::kdop::Workspace;
use musculo_collide::surface::{parallel, triangle};
use musculo_collide::{Body, Progress, Scene, SceneError};
use serde::Serialize;

use super::text::{counted, length};
use crate::scene::Unit;

/// Pairs of faces of one body that cross.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SelfCrossings {
    /// Number of pairs.
    count: usize,
    /// Number of faces that cross others.
    faces: usize,
    /// Length of the curve in which they cross, to rounding.
    curve_length: f64,
    /// All pairs, ascending.
    pairs: Vec<CrossingFaces>,
}

/// Two faces of a body that cross.
#[derive(Clone, Copy, Debug, Serialize)]
struct CrossingFaces {
    faces: [u32; 2],
    /// Point halfway between the centers of the faces.
    at: [f64; 3],
}

/// Finds the self-crossings of every body, in the order of the scene; `None` without any.
pub(crate) fn self_crossings(scene: &mut Scene) -> Result<Vec<Option<SelfCrossings>>, SceneError> {
    // Bodies far from all others have no trees yet.
    scene.fit_all()?;
    #[expect(clippy::cast_precision_loss, reason = "an estimate of the time")]
    let cost = |body: &Body| body.surface().faces().len() as f64;
    let bodies = scene.bodies();
    Ok(parallel::map_costly_first(bodies, cost, Workspace::default, SelfCrossings::find))
}

impl SelfCrossings {
    fn find(workspace: &mut Workspace, body: &Body) -> Option<Self> {
        // An interruption ends the whole program, so that none is polled here.
        let (mut pairs, mut crossing, mut curve_length) = (Vec::new(), BTreeSet::new(), 0.0);
        for faces in body.tree()?.self_crossings(workspace, Progress::none()).ok()? {
            let [a, b] = faces.map(|face| body.corners(face));
            crossing.extend(faces);
            curve_length += common_length(a, b);
            let at = (a.into_iter().chain(b).sum::<DVec3>() / 6.0).to_array();
            pairs.push(CrossingFaces { faces, at });
        }
        let (count, faces) = (pairs.len(), crossing.len());
        (count > 0).then_some(Self { count, faces, curve_length, pairs })
    }

    /// Describes the number of pairs and faces, the length of the curve, and the first place.
    pub(super) fn text(&self, unit: Unit) -> String {
        // The place is rounded as lengths are.
        let [count, faces] = [(self.count, "self-crossing"), (self.faces, "face")]
            .map(|(count, noun)| counted(count, noun));
        let curve = format!("{} {}", length(self.curve_length, unit), unit.symbol());
        let summary = format!("{count} of {faces} along {curve}");
        let Some(CrossingFaces { faces: [a, b], at }) = self.pairs.first() else { return summary };
        let [x, y, z] = at.map(|coordinate| length(coordinate, unit));
        let which = if self.count == 1 { "" } else { "the first " };
        format!("{summary}, {which}of faces {a} and {b} at ({x}, {y}, {z})")
    }
}

/// Computes the length of the segment that two crossing triangles have in common; 0 in one plane.
fn common_length(a: [DVec3; 3], b: [DVec3; 3]) -> f64 {
    let [normal_a, normal_b] = [a, b].map(|corners| triangle::normal(corners).normalize_or_zero());
    let along = normal_a.cross(normal_b).normalize_or_zero();

    // Both triangles cut the line of the two planes in an interval.
    let [cut_a, cut_b] = [(a, b[0], normal_b), (b, a[0], normal_a)].map(|(corners, at, normal)| {
        cut(corners, corners.map(|corner| (corner - at).dot(normal)), along)
    });
    (cut_a[1].min(cut_b[1]) - cut_a[0].max(cut_b[0])).max(0.0)
}

/// Computes the interval along a direction in which a triangle meets a plane, from the signed
/// distances of its corners.
fn cut(corners: [DVec3; 3], distances: [f64; 3], along: DVec3) -> [f64; 2] {
    let mut interval = [f64::INFINITY, f64::NEG_INFINITY];
    for (p, q) in [(0, 1), (1, 2), (2, 0)] {
        if (distances[p] < 0.0) == (distances[q] < 0.0) {
            continue;
        }
        let t = distances[p] / (distances[p] - distances[q]);
        let at = corners[p].lerp(corners[q], t).dot(along);
        interval = [interval[0].min(at), interval[1].max(at)];
    }
    interval
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_common_segment_has_its_length() {
        let flat = [DVec3::ZERO, 4.0 * DVec3::X, 4.0 * DVec3::Y];
        let upright =
            |x: f64| [[x, 1.0, -1.0], [x, 1.0, 1.0], [x, 9.0, 0.0]].map(DVec3::from_array);
        // From y = 1 to the oblique side at y = 4 − x.
        assert!((common_length(flat, upright(1.0)) - 2.0).abs() < 1e-12);
        assert!((common_length(upright(2.5), flat) - 0.5).abs() < 1e-12);
        assert!(common_length(flat, upright(3.5)).abs() < 1e-12, "apart");
        assert!(common_length(flat, flat).abs() < 1e-12, "in one plane");
    }
}
