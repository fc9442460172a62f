//! Distance by which balls extend outside a surface: the maximum of `r − D(c)` over all balls of the
//! union, with D the depth of a center. No point of a ball is farther outside than that.
//!
//! A patch of balls has two bounds. The slope of D is 1. And D is the minimum of the distances to
//! the faces, each of which is convex in c, so that its tangent at one center bounds it at the
//! others. Of these, only faces matter that can be nearest anywhere on the patch, and from which a
//! ball could extend farther outside than the largest distance evaluated so far. A patch hands them
//! on to its quarters.

use std::rc::Rc;

use glam::DVec3;
use kdop::Workspace;
use proximity::MaximumSearch;
use surface::DirectedHausdorff;
use surface::progress::{Interrupted, Progress};

use super::{MAX_PIECES, search, split_all};
use crate::surface_distance::SurfaceDistance;
use crate::{Ball, MedialSurface};

/// Patch of the balls between three.
struct Patch {
    balls: [Ball; 3],
    /// Depth of the center in the middle.
    depth: f64,
    /// The faces that matter, once they are listed.
    faces: Option<Rc<[u32]>>,
}

/// Face near the middle of a patch.
struct NearFace {
    face: u32,
    /// Unit vector from the face to the middle.
    outward: DVec3,
    /// Distance of the middle from the face.
    distance: f64,
}

/// Bounds of patches, which are added to a search.
struct Bounding<'a> {
    surface: &'a SurfaceDistance<'a>,
    near_faces: Vec<NearFace>,
    workspace: Workspace,
}

pub(super) fn medial_to_surface(
    medial: &MedialSurface,
    surface: &SurfaceDistance<'_>,
    progress: Progress<'_>,
) -> Result<DirectedHausdorff, Interrupted> {
    let workspace = Workspace::default();
    let mut bounding = Bounding { surface, near_faces: Vec::new(), workspace };
    let mut search = search(medial);
    for (primitive, _) in (0_u32..).zip(medial.primitives()) {
        bounding.add_by_slope(&mut search, medial.primitive_balls(primitive));
    }
    split_all(&mut search, MAX_PIECES, progress, |search, patch| bounding.split(search, patch))
}

impl Bounding<'_> {
    /// Adds the quarters of a patch, or the patch itself with its faces.
    fn split(&mut self, search: &mut MaximumSearch<Patch>, patch: Patch) {
        let Patch { balls, depth, faces } = patch;
        match faces {
            Some(faces) => {
                for quarter in quarters(balls) {
                    self.add_by_tangents(search, quarter, &faces);
                }
            }
            // A part of the patch may be outside, where tangents give no bound.
            None if depth <= spread(&balls) => {
                for quarter in quarters(balls) {
                    self.add_by_slope(search, quarter);
                }
            }
            None => {
                let faces = self.faces_that_matter(search, &balls, depth);
                self.add_by_tangents(search, balls, &faces);
            }
        }
    }

    /// Adds a patch with the bound by the slope of the depth.
    fn add_by_slope(&mut self, search: &mut MaximumSearch<Patch>, balls: [Ball; 3]) {
        let middle = middle(&balls);
        let nearest = self.surface.nearest(middle.center, f64::INFINITY, &mut self.workspace);
        let depth = nearest.map_or(f64::NEG_INFINITY, |foot| {
            self.surface.depth(middle.center, &foot, &mut self.workspace)
        });
        search.evaluated(middle.radius - depth);
        search.add(max_distance(&balls, middle) - depth, Patch { balls, depth, faces: None });
    }

    /// Collects the faces that matter to a patch that is inside.
    fn faces_that_matter(
        &mut self,
        search: &MaximumSearch<Patch>,
        balls: &[Ball; 3],
        depth: f64,
    ) -> Vec<u32> {
        let middle = middle(balls);
        let radius = (depth + 2.0 * spread(balls)).min(relevant_distance(search, balls, middle));
        self.surface.faces_within(middle.center, radius, &mut self.workspace)
    }

    /// Adds a patch that is inside, and to which no faces matter but `faces`.
    fn add_by_tangents(
        &mut self,
        search: &mut MaximumSearch<Patch>,
        balls: [Ball; 3],
        faces: &[u32],
    ) {
        // The depth in the middle, and the faces that can be nearest on the patch.
        let middle = middle(&balls);
        let limit = relevant_distance(search, &balls, middle);
        let depth = self.find_near_faces(middle.center, faces, limit, 2.0 * spread(&balls));

        // No ball extends farther than beyond one of these faces.
        let mut bound = middle.radius - depth;
        search.evaluated(bound);
        for near in &self.near_faces {
            bound = bound.max(tangent_bound(near, &balls, middle));
        }
        if bound > search.sufficient() {
            let faces = self.near_faces.iter().map(|near| near.face).collect();
            search.add(bound, Patch { balls, depth, faces: Some(faces) });
        }
    }

    /// Lists those of `faces` that are within `limit` of `p` and at most `excess` farther than the
    /// nearest; returns the distance of the nearest of all, or infinity.
    fn find_near_faces(&mut self, p: DVec3, faces: &[u32], limit: f64, excess: f64) -> f64 {
        // The limit falls as nearer faces are found.
        self.near_faces.clear();
        let mut limit = limit;
        let mut min_distance = f64::INFINITY;
        for &face in faces {
            if self.surface.is_farther(p, face, limit.max(min_distance)) {
                continue;
            }
            let found = self.surface.on_face(p, face);
            min_distance = min_distance.min(found.distance);
            limit = limit.min(found.distance + excess);
            if found.distance <= limit {
                let outward = (p - found.point).normalize_or_zero();
                self.near_faces.push(NearFace { face, outward, distance: found.distance });
            }
        }
        self.near_faces.retain(|near| near.distance <= limit);
        min_distance
    }
}

/// Computes a bound on the distance by which a patch extends beyond a face: at the corners, by the
/// tangent of the distance at the middle.
fn tangent_bound(near: &NearFace, balls: &[Ball; 3], middle: Ball) -> f64 {
    let mut bound = f64::NEG_INFINITY;
    for ball in balls {
        let rise = near.outward.dot(ball.center - middle.center);
        bound = bound.max(ball.radius - near.distance - rise);
    }
    bound
}

/// Returns the distance from the middle beyond which a face does not matter: no ball of the patch
/// can extend farther outside it than is sufficient already.
fn relevant_distance(search: &MaximumSearch<Patch>, balls: &[Ball; 3], middle: Ball) -> f64 {
    max_distance(balls, middle) - search.sufficient()
}

/// Computes the maximum distance of a point of the balls from the middle.
fn max_distance(balls: &[Ball; 3], middle: Ball) -> f64 {
    let mut max = 0.0_f64;
    for ball in balls {
        max = max.max(ball.radius + ball.center.distance(middle.center));
    }
    max
}

/// Returns the ball in the middle of three.
fn middle(balls: &[Ball; 3]) -> Ball {
    Ball::interpolate(balls, [1.0 / 3.0; 3])
}

/// Computes the maximum distance of the centers from that in the middle.
fn spread(balls: &[Ball; 3]) -> f64 {
    let middle = middle(balls).center;
    balls.iter().map(|ball| ball.center.distance(middle)).fold(0.0, f64::max)
}

/// Divides a patch at the middles of its sides.
fn quarters([a, b, c]: [Ball; 3]) -> [[Ball; 3]; 4] {
    let [ab, bc, ca] = [a.midpoint(b), b.midpoint(c), c.midpoint(a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}
