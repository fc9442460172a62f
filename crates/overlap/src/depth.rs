//! Greatest depth of one surface inside another, certified by branch and bound.
//!
//! The depth of A in B is the greatest distance from B's surface of any point of A's surface inside
//! B: a directed Hausdorff distance, restricted to a region. For any one face `g` of B the distance
//! to `g` is convex, so that over a triangle it is at most its greatest value at the corners:
//!
//! ```text
//! depth(T) ≤ min( max_i dist(t_i, g),  dist(c, B) + max_i |t_i − c| )
//! ```
//!
//! with `c` the center of T. For the face `g` nearest to `c` the first bound is exact to second
//! order in the size of T. Triangles are taken in the order of their bounds; each raises the lower
//! bound by the distance at its center and is split in four, until the highest bound left is within
//! the tolerance of the lower one.
//!
//! Source: M. Tang, M. Lee and Y. J. Kim, "Interactive Hausdorff Distance Computation for General
//! Polygonal Models", ACM Transactions on Graphics 28(3), 2009, for the branch and bound. Differs in
//! the bound by one face's convex distance, and in the restriction to the inside.

use glam::DVec3;
use kdop::Workspace;
use proximity::{MaximumSearch, SurfaceTree};
use surface::closest_on_triangle;
use surface::triangle::{quarters, radius_about_center};

use crate::patches::{Clipper, face_normal};

/// Width and effort of a certified depth.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DepthParams {
    /// Width of the bracket relative to the depth, `>= 0`. Smaller costs more: 1e-4 some 1.3 times
    /// as much as 1e-2.
    pub relative_tolerance: f64,
    /// Width of the bracket that is always narrow enough, `>= 0`, in the length unit. It ends the
    /// search where surfaces coincide up to noise, whose depth is nearly 0 everywhere.
    pub tolerance: f64,
    /// Closest points to compute at most. The bracket reached by then is returned, still certified.
    pub max_queries: u32,
}

/// Certified bracket on the greatest depth of one surface inside the other.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Depth {
    /// A depth that is attained, at `point`.
    pub lower: f64,
    /// A depth that no point of the surface exceeds.
    pub upper: f64,
    /// The deepest point found, on `face`.
    pub point: DVec3,
    /// The face of the surface that holds it.
    pub face: u32,
    /// The nearest point of the other surface. The way there is the shortest one out of the other
    /// body for this point alone; it is not a way out for the body.
    pub foot: DVec3,
    /// False if the query limit ended the search before the bracket was as narrow as asked.
    pub is_narrow: bool,
}

impl DepthParams {
    /// Returns parameters for a bracket of 1 % of the depth, with a floor.
    #[must_use]
    pub fn with_floor(tolerance: f64) -> Self {
        Self { relative_tolerance: 0.01, tolerance, max_queries: 1_000_000 }
    }
}

/// Triangle of the surface inside the other body.
#[derive(Clone, Copy, Debug)]
struct Piece {
    corners: [DVec3; 3],
    /// The face that holds it.
    face: u32,
    /// The face of the other surface that gave its bound.
    near: u32,
}

/// Stands for no face.
const UNKNOWN: u32 = u32::MAX;

/// The search for the deepest point of one side.
struct Search<'a> {
    other: &'a SurfaceTree,
    traversal: &'a mut Workspace,
    pieces: MaximumSearch<Piece>,
    deepest: Depth,
    /// Bound on the rounding of a distance.
    rounding: f64,
    queries: u32,
}

/// Brackets the depth of one body's surface inside the other; `None` where nothing of it is inside.
pub(crate) fn depth(
    clipper: &Clipper<'_>,
    other: &SurfaceTree,
    params: &DepthParams,
    traversal: &mut Workspace,
    queries: &mut u32,
) -> Option<Depth> {
    let mut search = Search::new(clipper.body, other, params, traversal);
    let nearest = search.query_vertices(clipper);
    search.add_whole_faces(clipper, &nearest);
    search.add_cut_faces(clipper, &nearest);

    while search.queries < params.max_queries {
        let Some((bound, piece)) = search.pieces.next() else { break };
        search.split(bound, &piece);
    }
    *queries += search.queries;
    search.finish()
}

impl<'a> Search<'a> {
    fn new(
        body: &SurfaceTree,
        other: &'a SurfaceTree,
        params: &DepthParams,
        traversal: &'a mut Workspace,
    ) -> Self {
        /// Roundings of one coordinate that a distance between surfaces may be off by.
        const ROUNDINGS: f64 = 64.0;

        let size = size(body).max(size(other));
        let deepest = Depth {
            lower: 0.0,
            upper: 0.0,
            point: DVec3::ZERO,
            face: 0,
            foot: DVec3::ZERO,
            is_narrow: true,
        };
        Self {
            other,
            traversal,
            pieces: MaximumSearch::new(params.tolerance, f64::INFINITY)
                .with_relative_slack(params.relative_tolerance),
            deepest,
            rounding: ROUNDINGS * f64::EPSILON * size,
            queries: 0,
        }
    }

    /// Computes the distance of inside vertices, those filled last first, which lie deepest in
    /// general. Returns a face near each; a vertex that is certainly less deep than another keeps
    /// the face of its neighbor, without a query.
    fn query_vertices(&mut self, clipper: &Clipper<'_>) -> Vec<u32> {
        let surface = clipper.body.surface();
        let vertices = &clipper.inside.vertices;
        // A vertex next to one whose face is known starts from that face.
        let mut nearest = vec![UNKNOWN; vertices.len()];
        for place in (0..vertices.len()).rev() {
            let vertex = vertices[place].vertex;
            if !clipper.wants(vertex) {
                continue;
            }
            let point = clipper.body.position(vertex);
            let hint = (nearest[place] != UNKNOWN).then_some(nearest[place]);
            let is_shallow =
                hint.is_some_and(|near| self.distance_to(near, point) <= self.pieces.lower());
            if !is_shallow {
                let face = surface.vertex_faces(vertex)[0];
                nearest[place] = self.query(point, face, hint).0;
            }

            // The neighbors that are still to come take the face as a hint.
            let found = nearest[place];
            for &face in surface.vertex_faces(vertex) {
                for corner in surface.faces()[face as usize] {
                    if let Some(next) = clipper.inside.place(corner)
                        && nearest[next as usize] == UNKNOWN
                    {
                        nearest[next as usize] = found;
                    }
                }
            }
        }
        nearest
    }

    /// Adds the faces that are inside as a whole, each bounded by the faces near its corners.
    fn add_whole_faces(&mut self, clipper: &Clipper<'_>, nearest: &[u32]) {
        for face in clipper.whole_faces() {
            let corners = clipper.body.surface().faces()[face as usize];
            let mut near = [UNKNOWN; 3];
            for (near, corner) in near.iter_mut().zip(corners) {
                *near = nearest[clipper.inside.place(corner).unwrap_or(0) as usize];
            }
            self.add(clipper.body.corners(face), face, &near);
        }
    }

    /// Adds the inside parts of the faces that the curve cuts.
    ///
    /// Most of these faces are shallow as a whole: they are not clipped.
    fn add_cut_faces(&mut self, clipper: &Clipper<'_>, nearest: &[u32]) {
        /// Faces of the other body that a triangle is bounded by, to begin with.
        const MAX_NEAR: usize = 6;

        let stretches = clipper.stretches_by_face();
        let mut near: Vec<u32> = Vec::new();
        for group in stretches.chunk_by(|p, q| p.face == q.face) {
            if !clipper.wants_face(group) {
                continue;
            }
            let face = group[0].face;
            let corners = clipper.body.surface().faces()[face as usize];
            near.clear();
            for corner in corners {
                let Some(place) = clipper.inside.place(corner) else { continue };
                if nearest[place as usize] != UNKNOWN {
                    near.push(nearest[place as usize]);
                }
            }
            for stretch in group {
                near.push(stretch.crossed_by);
            }
            near.truncate(MAX_NEAR);

            let (bound, _) = self.bound(clipper.body.corners(face), &near);
            if bound <= self.pieces.sufficient() {
                self.pieces.leave_out(bound);
                continue;
            }
            let normal = face_normal(clipper.body, face);
            for part in clipper.clip(group) {
                for triangle in part.triangles(normal) {
                    self.add(triangle, face, &near);
                }
            }
        }
    }

    /// Adds a triangle, bounded by the best of some faces.
    fn add(&mut self, corners: [DVec3; 3], face: u32, near: &[u32]) {
        let (bound, near) = self.bound(corners, near);
        self.pieces.add(bound, Piece { corners, face, near });
    }

    /// Bounds the depth of a triangle by the best of some faces, or the first that is good enough.
    fn bound(&self, corners: [DVec3; 3], near: &[u32]) -> (f64, u32) {
        let mut best = (f64::INFINITY, near[0]);
        for &near in near {
            let upper = self.upper_by(near, corners);
            if upper < best.0 {
                best = (upper, near);
            }
            if upper <= self.pieces.sufficient() {
                break;
            }
        }
        best
    }

    /// Computes the distance at a triangle's center, and splits the triangle in four.
    fn split(&mut self, bound: f64, piece: &Piece) {
        // The center is inside, so that its distance is attained.
        let (center, radius) = radius_about_center(piece.corners);
        let (near, distance) = self.query(center, piece.face, Some(piece.near));
        let by_center = distance + radius + self.rounding;

        // The parts are bounded by the faces nearest to both centers.
        for corners in quarters(piece.corners) {
            let by_faces = self.upper_by(near, corners).min(self.upper_by(piece.near, corners));
            let upper = by_faces.min(by_center).min(bound);
            self.pieces.add(upper, Piece { corners, near, ..*piece });
        }
    }

    fn finish(self) -> Option<Depth> {
        let bounds = self.pieces.bounds();
        let is_narrow = self.pieces.remaining() <= self.pieces.sufficient();
        let (lower, upper) = (bounds.lower, bounds.upper);
        (upper > 0.0).then_some(Depth { lower, upper, is_narrow, ..self.deepest })
    }

    /// Bounds the depth of a triangle by the distance of its corners from one face.
    fn upper_by(&self, near: u32, corners: [DVec3; 3]) -> f64 {
        let mut greatest: f64 = 0.0;
        for corner in corners {
            greatest = greatest.max(self.distance_to(near, corner));
        }
        greatest + self.rounding
    }

    fn distance_to(&self, near: u32, point: DVec3) -> f64 {
        closest_on_triangle(point, self.other.corners(near)).point.distance(point)
    }

    /// Computes the distance of a point inside from the other surface; it bounds the depth below.
    fn query(&mut self, point: DVec3, face: u32, hint: Option<u32>) -> (u32, f64) {
        self.queries += 1;
        let found = self.other.closest_point(point, f64::INFINITY, hint, self.traversal);
        let Some(found) = found else { return (0, 0.0) };
        if found.distance >= self.pieces.lower() {
            let foot = found.foot.point;
            self.deepest = Depth { point, face, foot, ..self.deepest };
            self.pieces.evaluated(found.distance);
        }
        (found.face, found.distance)
    }
}

/// Returns the largest coordinate of a body.
fn size(body: &SurfaceTree) -> f64 {
    let mut size: f64 = 0.0;
    for position in body.positions().as_slice() {
        size = size.max(position.abs().max_element());
    }
    size
}
