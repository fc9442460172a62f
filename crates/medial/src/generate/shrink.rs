//! Maximal balls at the vertices of a surface, by the shrinking ball algorithm.
//!
//! Source: J. Ma, S. W. Bae and S. Choi, "3D Medial Axis Point Approximation Using Nearest Neighbors
//! and the Normal Field", The Visual Computer 28(1), 2012: a ball that touches a surface point
//! shrinks until it is empty.
//!
//! Differs in taking the closest point of the faces, not of a point cloud, and in the treatment of
//! noise. R. Peters, *Geographical Point Cloud Modelling with the 3D Medial Axis Transform*, PhD
//! thesis, TU Delft, 2018, stops shrinking when the next point appears beside the vertex under a
//! small angle; a ball that is still too large then stays so. Here such points are skipped, and the
//! ball shrinks to the other points in it.

use std::borrow::Cow;
use std::collections::VecDeque;

use glam::DVec3;
use kdop::Workspace;
use surface::Aabb;
use surface::progress::{Interrupted, Progress};

use super::seeds::{Seeds, ring};
use crate::batches::map_in_batches;
use crate::surface_distance::{SurfaceDistance, SurfaceFoot};
use crate::{Ball, index};

/// Maximal ball that touches a surface vertex from inside.
#[derive(Clone, Copy, Debug)]
pub(super) struct MaximalBall {
    pub(super) ball: Ball,
    /// The other point that it touches; the vertex itself where there is none.
    pub(super) opposite: DVec3,
    /// Normal of the surface there.
    pub(super) opposite_normal: DVec3,
    pub(super) opposite_face: Option<u32>,
}

/// Share of the radius by which a point may be inside a ball that counts as empty: 1 µm for a ball
/// of 1 cm.
///
/// Ten times smaller costs another query per vertex and moves no center visibly.
const EMPTY: f64 = 1e-4;

/// Cosine of the angle, seen from the center, within which surface points count as noise beside the
/// vertex: 20°.
///
/// At 10° ripples of the mesh have balls of their own, which never join into a sheet; at 40° balls
/// outgrow ends and rims that have no second point to stop them.
const NOISE_COSINE: f64 = 0.939_692_620_785_908_4;

/// Maximum number of queries per vertex.
///
/// Balls halve their way down; a vertex that needs more has a corner that keeps producing nearer
/// points, and its ball is small by then.
const MAX_QUERIES: usize = 40;

/// Share of the largest possible radius at which a ball is a point: at a sharp corner it would
/// shrink until only rounding is left.
const POINT: f64 = 1e-7;

/// Interval of vertices that are tried from the largest possible radius, which gives the start of
/// the others: queries far from the surface are the most expensive.
const TRIAL_INTERVAL: usize = 64;

/// Factor on the radius of a neighbor to start from.
///
/// If that ball is empty, it grows again; a much larger start takes as many queries to shrink.
const NEIGHBOR_FACTOR: f64 = 1.2;

/// Number of vertices per batch: microseconds, but tens of milliseconds where all faces are equally
/// far from the center of a ball.
const VERTICES_PER_BATCH: usize = 1;

/// Vertex with the radii that its ball is searched between.
struct Trial {
    p: DVec3,
    /// Normal of the surface there.
    normal: DVec3,
    start: f64,
    largest: f64,
}

/// Computes the ball of each seed.
pub(super) fn maximal_balls(
    distance: &SurfaceDistance<'_>,
    seeds: &Seeds,
    progress: Progress<'_>,
) -> Result<Vec<MaximalBall>, Interrupted> {
    // A few trials give the radius to start from.
    let (vertices, normals) = (&seeds.vertices, ball_normals(distance));
    let largest = largest_radius(distance);
    let few: Vec<u32> = vertices.iter().copied().step_by(TRIAL_INTERVAL).collect();
    let trials = shrink_all(distance, &normals, &few, largest, progress.part(0.0, 0.1))?;
    let mut radii: Vec<f64> = trials.iter().map(|trial| trial.ball.radius).collect();
    radii.sort_by(f64::total_cmp);
    let start = radii.get(9 * radii.len() / 10).map_or(largest, |&radius| 1.5 * radius);
    shrink_all(distance, &normals, vertices, start, progress.part(0.1, 1.0))
}

/// Computes the balls of vertices from one radius.
fn shrink_all(
    distance: &SurfaceDistance<'_>,
    normals: &[DVec3],
    vertices: &[u32],
    start: f64,
    progress: Progress<'_>,
) -> Result<Vec<MaximalBall>, Interrupted> {
    let largest = largest_radius(distance);
    let shrink = |workspace: &mut Workspace, i: usize| {
        let p = distance.x.at(vertices[i]);
        let trial = Trial { p, normal: normals[vertices[i] as usize], start, largest };
        trial.shrink(distance, workspace)
    };
    map_in_batches(vertices.len(), VERTICES_PER_BATCH, progress, Workspace::default, shrink)
}

/// Computes the ball of each vertex, from those of the `seeds` next to them.
pub(super) fn maximal_balls_between(
    distance: &SurfaceDistance<'_>,
    seeds: &Seeds,
    at_seeds: &[MaximalBall],
    progress: Progress<'_>,
) -> Result<Vec<MaximalBall>, Interrupted> {
    let (largest, normals) = (largest_radius(distance), ball_normals(distance));
    let ball = |workspace: &mut Workspace, vertex: usize| {
        let seed = seeds.owners[vertex] as usize;
        if seeds.vertices[seed] as usize == vertex {
            return at_seeds[seed];
        }
        let start = NEIGHBOR_FACTOR * at_seeds[seed].ball.radius;
        let p = distance.x.at(index(vertex));
        Trial { p, normal: normals[vertex], start, largest }.shrink(distance, workspace)
    };
    map_in_batches(seeds.owners.len(), VERTICES_PER_BATCH, progress, Workspace::default, ball)
}

/// Returns half of the diagonal of the box around the surface.
fn largest_radius(distance: &SurfaceDistance<'_>) -> f64 {
    0.5 * Aabb::of_points(distance.x.as_slice().iter().copied()).diagonal()
}

/// Returns the normals that balls touch vertices along: those of the vertices. Where the faces of one
/// have no area, or cancel, it takes the normal of the nearest vertex along edges that has one.
fn ball_normals<'a>(distance: &'a SurfaceDistance<'_>) -> Cow<'a, [DVec3]> {
    let normals = distance.normals.vertices();
    if normals.iter().all(|&normal| normal != DVec3::ZERO) {
        return Cow::Borrowed(normals);
    }

    // Breadth first, from all vertices that have one.
    let mut normals = normals.to_vec();
    let has_normal = |vertex: &u32| distance.normals.vertices()[*vertex as usize] != DVec3::ZERO;
    let mut reached: VecDeque<u32> = (0..index(normals.len())).filter(has_normal).collect();
    while let Some(vertex) = reached.pop_front() {
        for other in ring(distance.surface, vertex) {
            if normals[other as usize] == DVec3::ZERO {
                normals[other as usize] = normals[vertex as usize];
                reached.push_back(other);
            }
        }
    }
    Cow::Owned(normals)
}

impl Trial {
    /// Returns the ball of a radius that touches the vertex.
    fn touching(&self, radius: f64) -> Ball {
        Ball::new(self.p - radius * self.normal, radius)
    }

    /// Shrinks the ball, which is first doubled up to the largest radius while it is empty; a point
    /// where no vertex has a normal.
    fn shrink(&self, distance: &SurfaceDistance<'_>, workspace: &mut Workspace) -> MaximalBall {
        let mut found = MaximalBall {
            ball: self.touching(if self.normal == DVec3::ZERO { 0.0 } else { self.start }),
            opposite: self.p,
            opposite_normal: self.normal,
            opposite_face: None,
        };
        for _ in 0..MAX_QUERIES {
            let Ball { center, radius } = found.ball;
            if radius <= POINT * self.largest {
                break;
            }
            match self.point_inside(distance, found.ball, workspace) {
                // The ball that touches both the vertex and the point in it.
                Some(foot) => {
                    let to_foot = self.p - foot.point;
                    let radius = to_foot.length_squared() / (2.0 * self.normal.dot(to_foot));
                    let ball = self.touching(radius);
                    found = MaximalBall {
                        ball,
                        opposite: foot.point,
                        opposite_normal: opposite_normal(distance, &foot, ball),
                        opposite_face: Some(foot.face),
                    };
                }
                // An empty ball that has touched no other point may be too small.
                None if found.opposite_face.is_none()
                    && radius < self.largest
                    && center != self.p =>
                {
                    found.ball = self.touching((2.0 * radius).min(self.largest));
                }
                None => break,
            }
        }
        found
    }

    /// Finds the closest surface point inside the ball that is not noise beside the vertex.
    ///
    /// A point of the other side is not noise, however small its angle: the center of a ball that is
    /// still too large may be beyond it.
    fn point_inside(
        &self,
        distance: &SurfaceDistance<'_>,
        ball: Ball,
        workspace: &mut Workspace,
    ) -> Option<SurfaceFoot> {
        let to_vertex = (self.p - ball.center).normalize_or_zero();
        let is_counted = |foot: &SurfaceFoot| {
            let is_opposite = distance.normals.faces()[foot.face as usize].dot(self.normal) < 0.0;
            let height = (foot.point - ball.center).dot(to_vertex);
            is_opposite || height < NOISE_COSINE * foot.distance
        };
        let within = ball.radius * (1.0 - EMPTY);
        distance.nearest_where(ball.center, within, workspace, is_counted)
    }
}

/// Returns the normal of the face that a ball touches, or that of the ball there where the face has no
/// area.
fn opposite_normal(distance: &SurfaceDistance<'_>, foot: &SurfaceFoot, ball: Ball) -> DVec3 {
    let normal = distance.normals.faces()[foot.face as usize];
    if normal == DVec3::ZERO { (foot.point - ball.center).normalize_or_zero() } else { normal }
}
