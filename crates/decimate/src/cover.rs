//! How high a surface lies over a triangle that it covers.
//!
//! Take faces of a surface that look the same way as a triangle R, and project them
//! into its plane. Each point of R is covered by some number of them, which can only
//! change where an edge passes that is not shared by two of them. So where no such
//! edge passes through R, and its center is covered, all of it is: over every point
//! there is a point of the surface, no farther than its height. The heights of a face
//! are greatest at the corners of the part that lies over R.
//!
//! The faces are found by going on across every edge that passes through R. Where R
//! ends at a crease, edges without a face that looks the same way run along its border.
//! They are let pass, up to rounding: what is covered is closed, so the border is as
//! well.

use glam::{DVec2, DVec3};

use crate::triangles::{NOTHING, Target};

/// Room for one question after the other.
pub(crate) struct Cover {
    /// For each target face the last question in which it was met.
    met: Vec<u32>,
    question: u32,
    waiting: Vec<u32>,
    polygon: Vec<DVec3>,
    clipped: Vec<DVec3>,
}

impl Cover {
    pub(crate) fn new(faces: usize) -> Self {
        let [polygon, clipped] = [vec![], vec![]];
        Self { met: vec![0; faces], question: 0, waiting: vec![], polygon, clipped }
    }

    /// A distance from the target that no point of the triangle exceeds, from faces
    /// around those it starts at; `None` where they do not cover it for certain, or
    /// from no nearer than `useful`.
    pub(crate) fn bound(
        &mut self,
        target: &Target<'_>,
        corners: [DVec3; 3],
        start: [u32; 3],
        useful: f64,
    ) -> Option<f64> {
        let plane = Plane::of(corners)?;
        self.question += 1;
        self.waiting.clear();
        for face in start {
            let projected = target.triangles.corners(face).map(|p| plane.project(p));
            if faces_plane(projected) && plane.may_meet(projected) {
                self.meet(face);
            }
        }
        let (mut height, mut covers) = (0.0_f64, false);
        while let Some(face) = self.waiting.pop() {
            let projected = target.triangles.corners(face).map(|p| plane.project(p));
            if !faces_plane(projected) {
                return None;
            }
            covers |= contains(projected, plane.center);
            height = self.height_over(&plane, projected, height);
            if height >= useful {
                return None;
            }
            for k in 0..3 {
                if plane.edge_may_pass(projected[k], projected[(k + 1) % 3]) {
                    match target.across[face as usize][k] {
                        NOTHING => return None,
                        next => self.meet(next),
                    }
                }
            }
        }
        covers.then_some(height)
    }

    fn meet(&mut self, face: u32) {
        let met = &mut self.met[face as usize];
        if *met != self.question {
            *met = self.question;
            self.waiting.push(face);
        }
    }

    /// The greatest height of a face over the triangle, or `known` if that is more.
    fn height_over(&mut self, plane: &Plane, projected: [DVec3; 3], known: f64) -> f64 {
        let highest = |polygon: &[DVec3]| polygon.iter().map(|p| p.z.abs()).fold(0.0, f64::max);
        if highest(&projected) <= known {
            return known;
        }
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
        highest(&self.polygon).max(known)
    }
}

/// A triangle's plane: its corners counter-clockwise in two coordinates.
struct Plane {
    origin: DVec3,
    axes: [DVec3; 3],
    corners: [DVec2; 3],
    center: DVec2,
    /// Inward unit normals of the sides from each corner to the next.
    inward: [DVec2; 3],
    /// What rounding may move a projected point by.
    margin: f64,
}

/// Roundings between a position and its coordinate in a plane, with room to spare.
const ROUNDINGS: f64 = 64.0;

impl Plane {
    /// The plane of a triangle with area.
    fn of(corners: [DVec3; 3]) -> Option<Self> {
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).try_normalize()?;
        let along = (b - a).try_normalize()?;
        let axes = [along, normal.cross(along), normal];
        let flat = corners.map(|p| DVec2::new(axes[0].dot(p - a), axes[1].dot(p - a)));
        let side = |k: usize| (flat[(k + 1) % 3] - flat[k]).try_normalize();
        let inward = [side(0)?, side(1)?, side(2)?].map(DVec2::perp);
        let scale = a.abs().max_element() + a.distance(b).max(a.distance(c));
        let margin = ROUNDINGS * f64::EPSILON * scale;
        let center = (flat[0] + flat[1] + flat[2]) / 3.0;
        let known = (0..3).all(|k| inward[k].dot(center - flat[k]) > 2.0 * margin);
        known.then_some(Self { origin: a, axes, corners: flat, center, inward, margin })
    }

    /// Two coordinates in the plane, and the height over it.
    fn project(&self, p: DVec3) -> DVec3 {
        DVec3::from(self.axes.map(|axis| axis.dot(p - self.origin)))
    }

    /// Distance inside of a side's line.
    fn inside(&self, side: usize, p: DVec3) -> f64 {
        self.inward[side].dot(p.truncate() - self.corners[side])
    }

    /// Whether no point is farther inside of one side than `margin`.
    fn beside(&self, points: &[DVec3], margin: f64) -> bool {
        (0..3).any(|side| points.iter().all(|p| self.inside(side, *p) < margin))
    }

    /// Whether a triangle may touch this one.
    fn may_meet(&self, triangle: [DVec3; 3]) -> bool {
        let beyond = |k: usize| {
            let [_, most, length] = self.sides_of(triangle[k], triangle[(k + 1) % 3]);
            most < -self.margin * length
        };
        !self.beside(&triangle, -self.margin) && !(0..3).any(beyond)
    }

    /// Whether an edge may pass through the inside of this triangle.
    fn edge_may_pass(&self, from: DVec3, to: DVec3) -> bool {
        let [least, most, length] = self.sides_of(from, to);
        let margin = self.margin * length;
        least < -margin && most > margin && !self.beside(&[from, to], self.margin)
    }

    /// Least and greatest distance of the corners to the left of a line, times a
    /// length, which is the third.
    fn sides_of(&self, from: DVec3, to: DVec3) -> [f64; 3] {
        let from = from.truncate();
        let left = (to.truncate() - from).perp();
        let [a, b, c] = self.corners.map(|corner| left.dot(corner - from));
        // The sum is at least the length: a little more counts as touching.
        [a.min(b).min(c), a.max(b).max(c), left.x.abs() + left.y.abs()]
    }
}

/// Least cosine between a face and the plane that it is projected into: 87°.
///
/// Smaller, and rounding decides which way a face looks; larger, and sides of creases
/// that are no steeper count as holes.
const MIN_COSINE: f64 = 0.05;

/// Whether a face looks the way that the plane does.
fn faces_plane([a, b, c]: [DVec3; 3]) -> bool {
    let normal = (b - a).cross(c - a);
    normal.z > MIN_COSINE * normal.length()
}

fn contains(triangle: [DVec3; 3], p: DVec2) -> bool {
    (0..3).all(|k| {
        let (from, to) = (triangle[k].truncate(), triangle[(k + 1) % 3].truncate());
        (to - from).perp_dot(p - from) >= 0.0
    })
}
