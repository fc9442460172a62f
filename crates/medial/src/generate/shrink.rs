//! The maximal ball at each vertex of a surface.
//!
//! Source: J. Ma, S. W. Bae and S. Choi, "3D Medial Axis Point Approximation
//! Using Nearest Neighbors and the Normal Field", The Visual Computer 28(1),
//! 2012: a ball that touches a surface point shrinks until nothing else is in
//! it.
//!
//! Differs in asking for the closest point of the faces, not of a point cloud,
//! and in the treatment of noise. R. Peters, *Geographical Point Cloud Modelling
//! with the 3D Medial Axis Transform*, PhD thesis, TU Delft, 2018, stops
//! shrinking when the next point is seen beside the vertex under a small angle;
//! a ball that is still too large then stays so. Here such points are passed
//! over, and the ball shrinks to what else enters it.

use glam::DVec3;
use kdop::Workspace;

use super::seeds::Seeds;
use crate::surface_distance::{Nearest, SurfaceDistance};
use crate::{Ball, index, parallel};

/// The maximal ball that touches a surface vertex from inside.
#[derive(Clone, Copy, Debug)]
pub(super) struct MaximalBall {
    pub(super) ball: Ball,
    /// The other point it touches, with the surface's normal there; the vertex
    /// itself where the ball did not find one.
    pub(super) opposite: DVec3,
    pub(super) opposite_normal: DVec3,
    pub(super) opposite_face: Option<u32>,
}

/// Share of the radius by which a ball may still be entered when it counts as
/// empty: 1 µm for a ball of 1 cm. Ten times smaller costs another query a
/// vertex and moves no center visibly.
const EMPTY: f64 = 1e-4;

/// Cosine of the angle, seen from the center, within which surface points are
/// taken for noise beside the vertex: 20°. At 10° ripples of the mesh make balls
/// of their own, which never join into a sheet; at 40° balls outgrow ends and
/// rims that have no second point to stop them.
const NOISE_COSINE: f64 = 0.939_692_620_785_908_4;

/// Balls halve their way down; a vertex that needs more queries has a corner
/// that keeps producing nearer points, and its ball is small by then.
const MAX_QUERIES: usize = 40;

/// Share of the largest radius possible at which a ball is a point: at a sharp
/// corner it would shrink until only rounding is left of it.
const POINT: f64 = 1e-7;

/// One vertex in so many is tried from the largest radius possible, to learn
/// where to start at the others: queries far from the surface cost the most.
const PROBE_EVERY: usize = 64;

/// What the radius next to a vertex is multiplied with to start from there. If
/// nothing enters that ball, it grows again; if it starts much larger, it takes as
/// many queries to shrink.
const NEXT: f64 = 1.2;

/// One ball for each of the seeds' vertices.
pub(super) fn maximal_balls(distance: &SurfaceDistance<'_>, seeds: &Seeds) -> Vec<MaximalBall> {
    let vertices = &seeds.vertices;
    let largest = largest(distance);
    let probes = vertices.len().div_ceil(PROBE_EVERY);
    let mut radii = parallel::map(probes, Workspace::default, |workspace, probe| {
        shrink(distance, vertices[probe * PROBE_EVERY], [largest; 2], workspace).ball.radius
    });
    radii.sort_by(f64::total_cmp);
    let start = radii.get(9 * probes / 10).map_or(largest, |&radius| 1.5 * radius);
    parallel::map(vertices.len(), Workspace::default, |workspace, i| {
        shrink(distance, vertices[i], [start, largest], workspace)
    })
}

/// One ball for each vertex, from those at the `seeds` next to them.
pub(super) fn maximal_balls_between(
    distance: &SurfaceDistance<'_>,
    seeds: &Seeds,
    at_seeds: &[MaximalBall],
) -> Vec<MaximalBall> {
    let largest = largest(distance);
    parallel::map(seeds.owners.len(), Workspace::default, |workspace, vertex| {
        let seed = seeds.owners[vertex] as usize;
        let vertex = index(vertex);
        if seeds.vertices[seed] == vertex {
            return at_seeds[seed];
        }
        shrink(distance, vertex, [NEXT * at_seeds[seed].ball.radius, largest], workspace)
    })
}

/// Half of the diagonal of the box around the surface.
fn largest(distance: &SurfaceDistance<'_>) -> f64 {
    let [low, high] = bounds(distance.x.as_slice());
    0.5 * low.distance(high)
}

/// The ball at one vertex, tried first with radius `start`, which is doubled up
/// to `largest` while nothing enters the ball.
fn shrink(
    distance: &SurfaceDistance<'_>,
    vertex: u32,
    [start, largest]: [f64; 2],
    workspace: &mut Workspace,
) -> MaximalBall {
    let p = distance.x.at(vertex);
    let normal = distance.normals.vertices()[vertex as usize];
    let touching = |radius: f64| Ball::new(p - radius * normal, radius);
    let mut found = MaximalBall {
        ball: touching(start),
        opposite: p,
        opposite_normal: normal,
        opposite_face: None,
    };
    for _ in 0..MAX_QUERIES {
        let Ball { center, radius } = found.ball;
        if radius <= POINT * largest {
            break;
        }
        match entering(distance, (p, normal), found.ball, workspace) {
            Some(q) => {
                let to_q = p - q.point;
                let radius = to_q.length_squared() / (2.0 * normal.dot(to_q));
                found = MaximalBall {
                    ball: touching(radius),
                    opposite: q.point,
                    opposite_normal: distance.normals.faces()[q.face as usize],
                    opposite_face: Some(q.face),
                };
            }
            None if found.opposite_face.is_none() && radius < largest && center != p => {
                found.ball = touching((2.0 * radius).min(largest));
            }
            None => break,
        }
    }
    found
}

/// The closest surface point inside the ball that is not noise beside `p`, where
/// the surface's normal is `normal`.
///
/// A point of the other side is none, however small its angle: the center of a
/// ball that is still too large may be beyond it.
fn entering(
    distance: &SurfaceDistance<'_>,
    (p, normal): (DVec3, DVec3),
    ball: Ball,
    workspace: &mut Workspace,
) -> Option<Nearest> {
    let to_p = (p - ball.center).normalize_or_zero();
    let beside = |q: &Nearest| (q.point - ball.center).dot(to_p) >= NOISE_COSINE * q.distance;
    let opposite = |q: &Nearest| distance.normals.faces()[q.face as usize].dot(normal) < 0.0;
    let within = ball.radius * (1.0 - EMPTY);
    distance.nearest_where(ball.center, within, workspace, |q| opposite(q) || !beside(q))
}

fn bounds(x: &[DVec3]) -> [DVec3; 2] {
    x.iter()
        .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], &p| [low.min(p), high.max(p)])
}
