//! How far balls reach out of a surface: the largest `r − D(c)` over all balls of
//! the union, with D the depth of a center. No point of a ball is farther outside
//! than that.
//!
//! Two bounds on a patch of balls. The slope of D is 1. And D is the least distance
//! to any face, each of which is convex in c, so that its tangent at one center
//! bounds it at the others; of these, only faces matter that can be nearest anywhere
//! on the patch, and from which a ball could reach out farther than is known to
//! happen elsewhere. A patch hands them on to its quarters.

use std::rc::Rc;

use glam::DVec3;
use kdop::Workspace;
use surface::DirectedHausdorff;

use super::largest::{Largest, least_slack};
use crate::surface_distance::SurfaceDistance;
use crate::{Ball, MedialSurface};

/// Balls between three.
struct Patch {
    balls: [Ball; 3],
    /// Depth of the center in the middle.
    depth: f64,
    /// The faces that matter, where they are known.
    faces: Option<Rc<[u32]>>,
}

pub(super) fn medial_to_surface(
    medial: &MedialSurface,
    distance: &SurfaceDistance<'_>,
) -> DirectedHausdorff {
    let mut bounding = Bounding { distance, facing: Vec::new(), workspace: Workspace::default() };
    let mut search = Largest::new(least_slack(medial));
    for (primitive, _) in (0_u32..).zip(medial.primitives()) {
        bounding.by_slope(&mut search, medial.primitive_balls(primitive));
    }
    search.run(|search, Patch { balls, depth, faces }| match faces {
        Some(faces) => {
            let quarters = quarters(balls).into_iter();
            quarters.for_each(|balls| bounding.by_tangents(search, balls, &faces));
        }
        // Not all of it may be inside: tangents tell nothing.
        None if depth <= around(&balls).1 => {
            quarters(balls).into_iter().for_each(|balls| bounding.by_slope(search, balls));
        }
        None => {
            let faces = bounding.faces(search, &balls, depth);
            bounding.by_tangents(search, balls, &faces);
        }
    })
}

fn quarters([a, b, c]: [Ball; 3]) -> [[Ball; 3]; 4] {
    let middle =
        |a: Ball, b: Ball| Ball::new(a.center.midpoint(b.center), a.radius.midpoint(b.radius));
    let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// A face seen from the middle of a patch.
struct Facing {
    face: u32,
    /// Unit vector from the face to the middle.
    away: DVec3,
    gap: f64,
}

/// Bounds patches and adds them to a search.
struct Bounding<'a> {
    distance: &'a SurfaceDistance<'a>,
    facing: Vec<Facing>,
    workspace: Workspace,
}

impl Bounding<'_> {
    fn by_slope(&mut self, search: &mut Largest<Patch>, balls: [Ball; 3]) {
        let (middle, _) = around(&balls);
        let nearest = self.distance.nearest(middle.center, f64::INFINITY, &mut self.workspace);
        let depth =
            nearest.map_or(f64::NEG_INFINITY, |q| self.distance.depth_of(middle.center, &q));
        let bound = farthest(&balls, middle) - depth;
        search.add(middle.radius - depth, bound, || Patch { balls, depth, faces: None });
    }

    /// The faces that matter to a patch that is inside.
    fn faces(&mut self, search: &Largest<Patch>, balls: &[Ball; 3], depth: f64) -> Vec<u32> {
        let (middle, spread) = around(balls);
        let limit = limit(search, balls, middle, depth + 2.0 * spread);
        let mut faces = Vec::new();
        self.distance.near(middle.center, limit, &mut self.workspace, |face| faces.push(face));
        faces
    }

    /// Adds a patch that is inside, and to which no other faces matter than `faces`.
    fn by_tangents(&mut self, search: &mut Largest<Patch>, balls: [Ball; 3], faces: &[u32]) {
        let (middle, spread) = around(&balls);
        let facing = &mut self.facing;
        let most = limit(search, &balls, middle, f64::INFINITY);
        let depth = face_all(self.distance, middle.center, faces, [most, 2.0 * spread], facing);
        let tangent = |facing: &Facing| {
            let at = |ball: &Ball| {
                ball.radius - facing.gap - facing.away.dot(ball.center - middle.center)
            };
            at(&balls[0]).max(at(&balls[1])).max(at(&balls[2]))
        };
        let seen = middle.radius - depth;
        let bound = facing.iter().map(tangent).fold(seen, f64::max);
        let faces = || Some(facing.iter().map(|f| f.face).collect());
        search.add(seen, bound, || Patch { balls, depth, faces: faces() });
    }
}

/// Distance from the middle beyond which a face does not matter: from farther
/// away, no ball of the patch can reach out by more than is known to happen, and at
/// more than `most` it is not the nearest.
fn limit(search: &Largest<Patch>, balls: &[Ball; 3], middle: Ball, most: f64) -> f64 {
    most.min(farthest(balls, middle) - search.enough())
}

/// Largest distance from the middle of a point of a ball.
fn farthest(balls: &[Ball; 3], middle: Ball) -> f64 {
    let at = |ball: &Ball| ball.radius + ball.center.distance(middle.center);
    at(&balls[0]).max(at(&balls[1])).max(at(&balls[2]))
}

/// The ball in the middle of three, and the distance that their centers keep to it.
fn around(balls: &[Ball; 3]) -> (Ball, f64) {
    let middle = Ball::interpolate(balls, [1.0 / 3.0; 3]);
    let spread = balls.iter().map(|b| b.center.distance(middle.center)).fold(0.0, f64::max);
    (middle, spread)
}

/// Distance of `p` from the nearest of `faces`, or infinity; `facing` is then those
/// of them that are within `limit` and not more than `beyond` farther than that.
fn face_all(
    distance: &SurfaceDistance<'_>,
    p: DVec3,
    faces: &[u32],
    [mut limit, beyond]: [f64; 2],
    facing: &mut Vec<Facing>,
) -> f64 {
    facing.clear();
    let mut least = f64::INFINITY;
    for &face in faces {
        let found = distance.on_face(p, face);
        least = least.min(found.distance);
        limit = limit.min(found.distance + beyond);
        if found.distance <= limit {
            let away = (p - found.point).normalize_or_zero();
            facing.push(Facing { face, away, gap: found.distance });
        }
    }
    facing.retain(|facing| facing.gap <= limit);
    least
}
