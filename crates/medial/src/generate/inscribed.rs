//! Balls of a union that reach out of the surface, at points of its primitives.
//!
//! The nearest surface point is searched for anew whenever the balls have moved.
//! Where they moved little, the faces around were listed, and one of these is still
//! the nearest.

use std::collections::BTreeSet;

use glam::DVec3;
use kdop::Workspace;

use super::normal_equations::Residual;
use crate::surface_distance::{Nearest, SurfaceDistance};
use crate::{Ball, MedialSurface, parallel};

/// Subdivisions of a primitive's sides: 15 points a slab.
const DIVISIONS: u32 = 4;

/// Share of a ball's radius that a move may have for the faces around it to be
/// listed: lists for longer moves take longer to look through than the tree.
const SHORT_MOVE: f64 = 0.1;

/// How far a list reaches, in moves of the ball: as many of them it is good for.
const LIST_REACH: f64 = 2.0;

/// Points of the primitives, and the surface points that entered their balls when
/// they were last searched for.
pub(super) struct Inscribed {
    points: Vec<Point>,
    entered: Vec<Option<Entered>>,
    /// Of each of the squares in the sum over all points.
    pub(super) importance: f64,
}

/// A point of a primitive.
struct Point {
    primitive: u32,
    weights: [f64; 3],
    /// Where its ball was last, and the face that was nearest then.
    center: DVec3,
    face: u32,
    list: Option<List>,
}

/// All faces that are not more than `radius` from `center`.
struct List {
    center: DVec3,
    radius: f64,
    faces: Vec<u32>,
}

/// A surface point in the ball at a point, with the side of the surface that the
/// ball's center was on: 1 inside, −1 outside.
#[derive(Clone, Copy)]
struct Entered {
    point: DVec3,
    side: f64,
}

impl Inscribed {
    /// None, if they are of no importance. `beside` tells a face for each primitive,
    /// from where the search is short if it is near.
    pub(super) fn new(medial: &MedialSurface, importance_of_all: f64, beside: &[u32]) -> Self {
        let points = if importance_of_all > 0.0 { points(medial, beside) } else { Vec::new() };
        let importance = importance_of_all / crate::real(points.len().max(1));
        Self { entered: vec![None; points.len()], points, importance }
    }

    /// Searches for the surface points that enter the balls now.
    pub(super) fn search(&mut self, medial: &MedialSurface, distance: &SurfaceDistance<'_>) {
        let points = &self.points;
        let found = parallel::map(points.len(), Workspace::default, |workspace, i| {
            let (point, center) = (&points[i], points[i].ball(medial).center);
            match point.list.as_ref().and_then(|list| list.nearest(distance, center)) {
                Some(nearest) => (center, Some(nearest), None),
                None => {
                    let nearest = distance.nearest_from(center, point.face, workspace);
                    let list = nearest.and_then(|nearest| {
                        let moved = center.distance(point.center);
                        List::around(distance, center, nearest.distance, moved, workspace)
                    });
                    (center, nearest, Some(list))
                }
            }
        });
        for ((point, entered), (center, nearest, list)) in
            self.points.iter_mut().zip(&mut self.entered).zip(found)
        {
            *entered = nearest.map(|nearest| Entered {
                point: nearest.point,
                side: 1.0_f64.copysign(distance.depth_of(center, &nearest)),
            });
            point.center = center;
            point.face = nearest.map_or(0, |nearest| nearest.face);
            if let Some(list) = list {
                point.list = list;
            }
        }
    }

    /// Residuals of the balls that reach out beyond the surface points found last.
    pub(super) fn residuals(&self, medial: &MedialSurface) -> impl Iterator<Item = Residual> {
        let entered = self.points.iter().zip(&self.entered);
        entered.filter_map(|(point, entered)| {
            reaching_out(point, point.ball(medial), (*entered)?, self.importance)
        })
    }
}

impl Point {
    fn ball(&self, medial: &MedialSurface) -> Ball {
        Ball::interpolate(&medial.primitive_balls(self.primitive), self.weights)
    }
}

impl List {
    /// Lists the faces around a center at this `depth` that `moved` so far, if that
    /// is not far.
    fn around(
        distance: &SurfaceDistance<'_>,
        center: DVec3,
        depth: f64,
        moved: f64,
        workspace: &mut Workspace,
    ) -> Option<Self> {
        if moved > SHORT_MOVE * depth {
            return None;
        }
        let radius = depth + LIST_REACH * moved;
        let mut faces = Vec::new();
        distance.near(center, radius, workspace, |face| faces.push(face));
        Some(Self { center, radius, faces })
    }

    /// The nearest point of the surface, if it is sure to be on a face of the list.
    fn nearest(&self, distance: &SurfaceDistance<'_>, p: DVec3) -> Option<Nearest> {
        let sure = self.radius - p.distance(self.center);
        let on_faces = self.faces.iter().map(|&face| distance.on_face(p, face));
        let nearest = on_faces.min_by(|a, b| a.distance.total_cmp(&b.distance))?;
        (nearest.distance <= sure).then_some(nearest)
    }
}

fn reaching_out(point: &Point, ball: Ball, entered: Entered, importance: f64) -> Option<Residual> {
    let away = ball.center - entered.point;
    let depth = entered.side * away.length();
    let gradient = entered.side * away.normalize_or_zero();
    (ball.radius > depth).then_some(Residual {
        primitive: point.primitive,
        weights: point.weights,
        gradient: (-gradient).extend(1.0),
        value: ball.radius - depth,
        importance,
    })
}

/// Points at regular weights of every primitive; those on a shared ball or edge
/// once.
fn points(medial: &MedialSurface, beside: &[u32]) -> Vec<Point> {
    let mut seen = BTreeSet::new();
    let mut points = Vec::new();
    for (primitive, &[a, b, c]) in (0_u32..).zip(medial.primitives()) {
        for i in 0..=DIVISIONS {
            for j in 0..=DIVISIONS - i {
                let parts = [(a, DIVISIONS - i - j), (b, i), (c, j)];
                let mut key =
                    parts.map(|(ball, part)| if part == 0 { (0, 0) } else { (ball, part) });
                key.sort_unstable();
                if seen.insert(key) {
                    let weights = parts.map(|(_, part)| f64::from(part) / f64::from(DIVISIONS));
                    let (center, face) = (DVec3::INFINITY, beside[primitive as usize]);
                    points.push(Point { primitive, weights, center, face, list: None });
                }
            }
        }
    }
    points
}
