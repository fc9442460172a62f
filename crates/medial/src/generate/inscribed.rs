//! Balls of a union that extend outside the surface, at points of its primitives.
//!
//! The closest surface point is searched for again whenever the balls have moved. Where they moved
//! little, the faces around are listed, and one of these is still the closest.

use std::collections::BTreeSet;

use glam::DVec3;
use kdop::Workspace;
use surface::progress::{Interrupted, Progress};

use super::normal_equations::Residual;
use crate::batches::map_in_batches;
use crate::surface_distance::{SurfaceDistance, SurfaceFoot};
use crate::{Ball, MedialSurface};

/// Number of subdivisions of a primitive's sides: 15 points per slab.
const DIVISIONS: u32 = 4;

/// Largest move for which the faces around are listed, in radii: lists for longer moves take longer
/// to search than the tree.
const SHORT_MOVE: f64 = 0.1;

/// Extent of a list, in moves of the ball: it is valid for as many of them.
const LIST_MOVES: f64 = 2.0;

/// Number of points per batch: about a millisecond.
const POINTS_PER_BATCH: usize = 64;

/// Points of the primitives, with the closest surface points at the last search.
pub(super) struct Inscribed {
    points: Vec<PrimitivePoint>,
    /// Importance of each of the squares in the sum over all points.
    importance: f64,
}

/// Point of a primitive.
struct PrimitivePoint {
    primitive: u32,
    weights: [f64; 3],
    /// Center of its ball at the last search, and the face that was closest to it.
    center: DVec3,
    face: u32,
    list: Option<FaceList>,
    closest: Option<SidedPoint>,
}

/// All faces that are at most `radius` from `center`.
struct FaceList {
    center: DVec3,
    radius: f64,
    faces: Vec<u32>,
}

/// Surface point, with the side that the center of a ball was on: 1 inside, −1 outside.
#[derive(Clone, Copy)]
struct SidedPoint {
    point: DVec3,
    side: f64,
}

/// Result of the search at a point.
struct Searched {
    center: DVec3,
    foot: SurfaceFoot,
    /// Replacement of the list, unless the list was used.
    list: Option<Option<FaceList>>,
}

impl Inscribed {
    /// Selects points, none if they are of no importance.
    ///
    /// `faces` holds a face for each primitive, from which the search is short if it is near.
    pub(super) fn new(medial: &MedialSurface, total_importance: f64, faces: &[u32]) -> Self {
        let points =
            if total_importance > 0.0 { regular_points(medial, faces) } else { Vec::new() };
        let importance = total_importance / crate::real(points.len().max(1));
        Self { points, importance }
    }

    /// Searches for the surface points closest to the balls now.
    pub(super) fn search(
        &mut self,
        medial: &MedialSurface,
        distance: &SurfaceDistance<'_>,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        let points = &self.points;
        let search = |workspace: &mut Workspace, i: usize| {
            points[i].search(points[i].ball(medial).center, distance, workspace)
        };
        let found =
            map_in_batches(points.len(), POINTS_PER_BATCH, progress, Workspace::default, search)?;

        // The points keep what the next search and the residuals need.
        for (point, Searched { center, foot, list }) in self.points.iter_mut().zip(found) {
            let side = 1.0_f64.copysign(distance.depth(center, &foot));
            point.closest = Some(SidedPoint { point: foot.point, side });
            (point.center, point.face) = (center, foot.face);
            if let Some(list) = list {
                point.list = list;
            }
        }
        Ok(())
    }

    /// Returns the residuals of the balls that extend beyond the surface points of the last search.
    pub(super) fn residuals(&self, medial: &MedialSurface) -> impl Iterator<Item = Residual> {
        self.points.iter().filter_map(|point| point.residual(point.ball(medial), self.importance))
    }
}

impl PrimitivePoint {
    fn ball(&self, medial: &MedialSurface) -> Ball {
        Ball::interpolate(&medial.primitive_balls(self.primitive), self.weights)
    }

    /// Finds the closest surface point to the center of its ball, by its list where that is valid.
    fn search(
        &self,
        center: DVec3,
        distance: &SurfaceDistance<'_>,
        workspace: &mut Workspace,
    ) -> Searched {
        if let Some(foot) = self.list.as_ref().and_then(|list| list.nearest(distance, center)) {
            return Searched { center, foot, list: None };
        }

        // Otherwise by the tree, with a list for the moves to come.
        let foot = distance.nearest_from(center, self.face, workspace);
        let move_length = center.distance(self.center);
        let list = FaceList::around(distance, center, foot.distance, move_length, workspace);
        Searched { center, foot, list: Some(list) }
    }

    /// Returns the residual of its ball, if that extends outside the surface.
    fn residual(&self, ball: Ball, importance: f64) -> Option<Residual> {
        let SidedPoint { point, side } = self.closest?;
        let away = ball.center - point;
        let depth = side * away.length();
        let gradient = side * away.normalize_or_zero();
        (ball.radius > depth).then_some(Residual {
            primitive: self.primitive,
            weights: self.weights,
            gradient: (-gradient).extend(1.0),
            value: ball.radius - depth,
            importance,
        })
    }
}

impl FaceList {
    /// Lists the faces around a center at this distance from the surface; `None` after a long move.
    fn around(
        distance: &SurfaceDistance<'_>,
        center: DVec3,
        surface_distance: f64,
        move_length: f64,
        workspace: &mut Workspace,
    ) -> Option<Self> {
        if move_length > SHORT_MOVE * surface_distance {
            return None;
        }
        let radius = surface_distance + LIST_MOVES * move_length;
        let faces = distance.faces_within(center, radius, workspace);
        Some(Self { center, radius, faces })
    }

    /// Finds the closest point of the surface; `None` where it may be on a face that is not listed.
    fn nearest(&self, distance: &SurfaceDistance<'_>, p: DVec3) -> Option<SurfaceFoot> {
        let valid_radius = self.radius - p.distance(self.center);
        let feet = self.faces.iter().map(|&face| distance.on_face(p, face));
        let nearest = feet.min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        (nearest.distance <= valid_radius).then_some(nearest)
    }
}

/// Returns points at regular weights of every primitive; those on a shared ball or edge once.
fn regular_points(medial: &MedialSurface, faces: &[u32]) -> Vec<PrimitivePoint> {
    let mut seen = BTreeSet::new();
    let mut points = Vec::new();
    for (primitive, &[a, b, c]) in (0_u32..).zip(medial.primitives()) {
        for i in 0..=DIVISIONS {
            for j in 0..=DIVISIONS - i {
                // The same combination of balls is the same point.
                let parts = [(a, DIVISIONS - i - j), (b, i), (c, j)];
                let mut key = parts.map(|part| if part.1 == 0 { (0, 0) } else { part });
                key.sort_unstable();
                if !seen.insert(key) {
                    continue;
                }
                points.push(PrimitivePoint {
                    primitive,
                    weights: parts.map(|(_, part)| f64::from(part) / f64::from(DIVISIONS)),
                    center: DVec3::INFINITY,
                    face: faces[primitive as usize],
                    list: None,
                    closest: None,
                });
            }
        }
    }
    points
}
