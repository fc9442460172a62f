//! Height of a surface over a triangle that it covers.
//!
//! Take faces of a surface that face the same way as a triangle R, and project them into its
//! plane. The number of them that cover a point of R changes only across edges that are not
//! shared by two of them. So where no such edge passes through R, and its center is covered,
//! all of it is: over every point there is a point of the surface, no farther than its height.
//! The heights of a face are largest at the corners of the part that lies over R.
//!
//! The faces are found by continuing across every edge that passes through R. Where R ends at
//! a crease, edges without a face that faces the same way run along its border. They are
//! accepted, up to rounding: what is covered is closed, so the border is covered as well.

use glam::{DVec2, DVec3};
use surface::triangle;

use crate::target::{NO_FACE, Target};

/// Reusable memory of height queries.
#[derive(Default)]
pub(crate) struct Cover {
    /// Per target face, the stamp of the last query that visited it.
    visited: Vec<u32>,
    stamp: u32,
    /// Faces that the query has yet to project.
    pending: Vec<u32>,
    polygon: Vec<DVec3>,
    clipped: Vec<DVec3>,
}

impl Cover {
    pub(crate) fn new(faces: usize) -> Self {
        Self { visited: vec![0; faces], ..Self::default() }
    }

    /// Computes a distance from the target that no point of the triangle exceeds, from the
    /// faces around `start`.
    ///
    /// Returns `None` where those do not certainly cover it, or are not nearer than `limit`.
    pub(crate) fn height(
        &mut self,
        target: &Target<'_>,
        corners: [DVec3; 3],
        start: [u32; 3],
        limit: f64,
    ) -> Option<f64> {
        // Start from the faces that meet the triangle.
        let plane = Plane::of(corners)?;
        self.stamp += 1;
        self.pending.clear();
        for face in start {
            let projected = plane.project(target.tree.corners(face));
            if is_upward(projected) && plane.may_meet(projected) {
                self.visit(face);
            }
        }

        let (mut height, mut covers_center) = (0.0_f64, false);
        while let Some(face) = self.pending.pop() {
            let projected = plane.project(target.tree.corners(face));
            if !is_upward(projected) {
                return None;
            }
            covers_center |= contains(projected, plane.center);
            height = self.height_over(&plane, projected, height);
            if height >= limit {
                return None;
            }

            // Continue across edges that may pass through the triangle.
            for k in 0..3 {
                if plane.edge_may_pass(projected[k], projected[(k + 1) % 3]) {
                    match target.adjacent[face as usize][k] {
                        NO_FACE => return None,
                        next => self.visit(next),
                    }
                }
            }
        }
        covers_center.then_some(height)
    }

    /// Puts a face on the list, once.
    fn visit(&mut self, face: u32) {
        let visited = &mut self.visited[face as usize];
        if *visited != self.stamp {
            *visited = self.stamp;
            self.pending.push(face);
        }
    }

    /// Returns the largest height of a face over the triangle, or `floor` where that is
    /// larger.
    fn height_over(&mut self, plane: &Plane, projected: [DVec3; 3], floor: f64) -> f64 {
        if max_height(&projected) <= floor {
            return floor;
        }

        // Clip the face at the lines of the triangle's sides (Sutherland and Hodgman).
        self.polygon.clear();
        self.polygon.extend(projected);
        for side in 0..3 {
            self.clipped.clear();
            let next = self.polygon.iter().cycle().skip(1);
            for (&from, &to) in self.polygon.iter().zip(next) {
                let (d, e) = (plane.inside(side, from), plane.inside(side, to));
                if d >= 0.0 {
                    self.clipped.push(from);
                }
                if (d < 0.0) != (e < 0.0) {
                    self.clipped.push(from + (to - from) * (d / (d - e)));
                }
            }
            std::mem::swap(&mut self.polygon, &mut self.clipped);
        }
        max_height(&self.polygon).max(floor)
    }
}

/// Returns the largest distance of projected points from the plane; 0 without points.
fn max_height(projected: &[DVec3]) -> f64 {
    projected.iter().map(|p| p.z.abs()).fold(0.0, f64::max)
}

/// Plane of a triangle, with its corners counter-clockwise in two coordinates.
struct Plane {
    origin: DVec3,
    axes: [DVec3; 3],
    corners: [DVec2; 3],
    center: DVec2,
    /// Inward unit normals of the sides from each corner to the next.
    inward: [DVec2; 3],
    /// Distance by which rounding may move a projected point.
    rounding: f64,
}

/// Number of roundings between a position and its coordinate in a plane, with a safety factor.
const ROUNDINGS: f64 = 64.0;

impl Plane {
    /// Returns the plane of a triangle; `None` without an area well above rounding.
    fn of(corners: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let normal = triangle::normal(corners).try_normalize()?;
        let along = (b - a).try_normalize()?;
        let axes = [along, normal.cross(along), normal];
        let flat = corners.map(|p| DVec2::new(axes[0].dot(p - a), axes[1].dot(p - a)));
        let [p, q, r] = flat;
        let [along_a, along_b, along_c] = [q - p, r - q, p - r].map(DVec2::try_normalize);
        let inward = [along_a?, along_b?, along_c?].map(DVec2::perp);

        // The center must be inside beyond doubt.
        let scale = a.abs().max_element() + a.distance(b).max(a.distance(c));
        let rounding = ROUNDINGS * f64::EPSILON * scale;
        let center = (p + q + r) / 3.0;
        let is_wide = (0..3).all(|k| inward[k].dot(center - flat[k]) > 2.0 * rounding);
        is_wide.then_some(Self { origin: a, axes, corners: flat, center, inward, rounding })
    }

    /// Computes, per point, two coordinates in the plane and the height over it.
    fn project(&self, points: [DVec3; 3]) -> [DVec3; 3] {
        let [u, v, normal] = self.axes;
        points.map(|p| {
            let d = p - self.origin;
            DVec3::new(u.dot(d), v.dot(d), normal.dot(d))
        })
    }

    /// Returns the distance of a projected point from a side's line, positive inside.
    fn inside(&self, side: usize, p: DVec3) -> f64 {
        self.inward[side].dot(p.truncate() - self.corners[side])
    }

    /// Returns true if all points are less than `margin` inside of one side.
    fn is_beside(&self, points: &[DVec3], margin: f64) -> bool {
        (0..3).any(|side| points.iter().all(|p| self.inside(side, *p) < margin))
    }

    /// Returns true if a projected triangle may touch this one, by separating sides.
    fn may_meet(&self, triangle: [DVec3; 3]) -> bool {
        if self.is_beside(&triangle, -self.rounding) {
            return false;
        }
        let [a, b, c] = triangle;
        for (from, to) in [(a, b), (b, c), (c, a)] {
            let left = self.left_of(from, to);
            if left.max < -self.rounding * left.length {
                return false;
            }
        }
        true
    }

    /// Returns true if a projected edge may pass through the interior of this triangle.
    fn edge_may_pass(&self, from: DVec3, to: DVec3) -> bool {
        let left = self.left_of(from, to);
        let rounding = self.rounding * left.length;
        let has_both_sides = left.min < -rounding && left.max > rounding;
        has_both_sides && !self.is_beside(&[from, to], self.rounding)
    }

    /// Computes the distances of the corners to the left of a line, scaled by a length.
    fn left_of(&self, from: DVec3, to: DVec3) -> LeftOf {
        let from = from.truncate();
        let left = (to.truncate() - from).perp();
        let [a, b, c] = self.corners.map(|corner| left.dot(corner - from));
        // The sum is at least the length: a little more counts as touching.
        let length = left.x.abs() + left.y.abs();
        LeftOf { min: a.min(b).min(c), max: a.max(b).max(c), length }
    }
}

/// Smallest and largest distance of corners to the left of a line, times `length`.
struct LeftOf {
    min: f64,
    max: f64,
    length: f64,
}

/// Smallest cosine between a face and the plane that it is projected into: 87°.
///
/// Smaller, and rounding decides which way a face points; larger, and sides of creases that
/// are less steep count as holes.
const MIN_COSINE: f64 = 0.05;

/// Returns true if a projected face points the same way as the plane.
fn is_upward(corners: [DVec3; 3]) -> bool {
    let normal = triangle::normal(corners);
    normal.z > MIN_COSINE * normal.length()
}

/// Returns true if a projected counter-clockwise triangle contains a point of the plane.
fn contains(triangle: [DVec3; 3], p: DVec2) -> bool {
    let [a, b, c] = triangle.map(DVec3::truncate);
    is_left_of(a, b, p) && is_left_of(b, c, p) && is_left_of(c, a, p)
}

/// Returns true if a point is on the line from one point to another, or to the left of it.
fn is_left_of(from: DVec2, to: DVec2, p: DVec2) -> bool {
    (to - from).perp_dot(p - from) >= 0.0
}
