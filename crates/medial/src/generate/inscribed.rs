//! Balls of a union that extend outside the surface, at points of its primitives.
//!
//! The closest surface point is searched for again whenever the balls have moved, from the face that
//! was closest before. (Lists of the faces around each point take longer to search than the tree.)

use std::collections::BTreeSet;

use glam::DVec3;
use kdop::Workspace;
use surface::progress::{Interrupted, Progress};

use super::normal_equations::Residual;
use crate::batches::map_in_batches;
use crate::surface_distance::SurfaceDistance;
use crate::{Ball, MedialSurface};

/// Number of subdivisions of a primitive's sides: 15 points per slab.
const DIVISIONS: u32 = 4;

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
    /// The face that was closest to it at the last search.
    face: u32,
    closest: Option<SidedPoint>,
}

/// Surface point, with the side that the center of a ball was on: 1 inside, −1 outside.
#[derive(Clone, Copy)]
struct SidedPoint {
    point: DVec3,
    side: f64,
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
            let center = points[i].ball(medial).center;
            let foot = distance.nearest_from(center, points[i].face, workspace);
            let side = 1.0_f64.copysign(distance.depth(center, &foot, workspace));
            (foot.face, SidedPoint { point: foot.point, side })
        };
        let found =
            map_in_batches(points.len(), POINTS_PER_BATCH, progress, Workspace::default, search)?;

        // The points keep what the next search and the residuals need.
        for (point, (face, closest)) in self.points.iter_mut().zip(found) {
            (point.face, point.closest) = (face, Some(closest));
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
                    face: faces[primitive as usize],
                    closest: None,
                });
            }
        }
    }
    points
}
