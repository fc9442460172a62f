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
//! order in the size of T where T is over `g`. Triangles are taken in the order of their bounds; each
//! raises the lower bound by the distance at its center and is divided, until the highest bound left
//! is within the tolerance of the lower one. A triangle that is over `g` in part is cut at an edge of
//! `g`: where surfaces nearly coincide, their depth is much less than a corner is beyond. Others are
//! quartered. A face near `c` is found by descent from neighbor to neighbor, and the nearest one
//! where it may be farther than the deepest point so far.
//!
//! Source: M. Tang, M. Lee and Y. J. Kim, "Interactive Hausdorff Distance Computation for General
//! Polygonal Models", ACM Transactions on Graphics 28(3), 2009, for the branch and bound. Differs in
//! the bound by one face's convex distance, in the cuts, and in the restriction to the inside.

use glam::DVec3;
use kdop::Workspace;
use proximity::{MaximumSearch, NearVertex, SurfaceTree, TriangleDivision};
use surface::closest_on_triangle;
use surface::progress::{Interrupted, Polls, Progress};
use surface::triangle::radius_about_center;

use crate::patches::{Clipper, FaceClip, FaceStretch, face_normal};

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
    /// Closest points and divisions of triangles at most. The bracket reached by then is returned, still certified.
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
    /// A face of the other surface near its center.
    near: u32,
    /// The distance of the center from that face.
    distance: f64,
}

/// Stands for no face.
const UNKNOWN: u32 = u32::MAX;

/// Closest points between two polls for interruption: some milliseconds at most, even where many
/// faces are equally far.
const POLLED_QUERIES: u32 = 8;

/// Faces between two polls: about a millisecond.
const POLLED_FACES: u32 = 1024;

/// Memory of depth searches, reused from search to search.
#[derive(Debug, Default)]
pub(crate) struct DepthMemory {
    traversal: Workspace,
    pieces: MaximumSearch<Piece>,
    /// One per inside vertex: a face of the other surface near it.
    nearest: Vec<u32>,
    /// Faces that a cut face is bounded by.
    near: Vec<u32>,
    whole_faces: Vec<u32>,
    stretches: Vec<FaceStretch>,
    clip: FaceClip,
    triangles: Vec<[DVec3; 3]>,
}

/// The search for the deepest point of one side.
struct Search<'a> {
    other: &'a SurfaceTree,
    /// Closest points of some vertices, ascending.
    known: &'a [NearVertex],
    traversal: &'a mut Workspace,
    pieces: &'a mut MaximumSearch<Piece>,
    deepest: Depth,
    /// Bound on the rounding of a distance.
    rounding: f64,
    queries: u32,
    progress: Progress<'a>,
    /// Polls among the queries.
    polls: Polls<'a>,
}

/// Brackets the depth of one body's surface inside the other; `None` where nothing of it is inside.
///
/// `known` has closest points of vertices, ascending, which are not computed again.
pub(crate) fn depth(
    clipper: &Clipper<'_>,
    other: &SurfaceTree,
    known: &[NearVertex],
    params: &DepthParams,
    memory: &mut DepthMemory,
    progress: Progress<'_>,
) -> Result<Option<Depth>, Interrupted> {
    let DepthMemory { traversal, pieces, nearest, near, whole_faces, stretches, clip, triangles } =
        memory;
    pieces.restart(params.tolerance, params.relative_tolerance);
    let size = size(clipper.body).max(size(other));
    let mut search = Search::new(other, known, size, traversal, pieces, progress);

    search.query_vertices(clipper, nearest)?;
    clipper.collect_whole_faces(whole_faces);
    search.add_whole_faces(clipper, whole_faces, nearest)?;
    clipper.collect_stretches(stretches);
    let mut polls = progress.every(POLLED_FACES);
    for group in stretches.chunk_by(|p, q| p.face == q.face) {
        polls.step()?;
        collect_near(clipper, group, nearest, near);
        if search.needs_clipping(clipper, group, near) {
            clipper.clip(group, clip);
            clip.triangulate(face_normal(clipper.body, group[0].face), triangles);
            for &triangle in &*triangles {
                search.add(triangle, group[0].face, near);
            }
        }
    }

    while search.queries < params.max_queries {
        let Some((bound, piece)) = search.pieces.next() else { break };
        search.split(bound, &piece)?;
    }
    Ok(search.finish())
}

/// Collects faces of the other body that the inside part of a cut face is bounded by, to begin with:
/// those near its corners inside, and those that cut it.
fn collect_near(
    clipper: &Clipper<'_>,
    stretches: &[FaceStretch],
    nearest: &[u32],
    near: &mut Vec<u32>,
) {
    /// Maximum number of these faces.
    const MAX_NEAR: usize = 6;

    near.clear();
    for corner in clipper.body.surface().faces()[stretches[0].face as usize] {
        let Some(place) = clipper.inside.place(corner) else { continue };
        if nearest[place as usize] != UNKNOWN {
            near.push(nearest[place as usize]);
        }
    }
    for stretch in stretches {
        near.push(stretch.crossed_by);
    }
    near.truncate(MAX_NEAR);
}

impl<'a> Search<'a> {
    /// Begins a search among pieces, none of which is there yet; `size` is the largest coordinate.
    fn new(
        other: &'a SurfaceTree,
        known: &'a [NearVertex],
        size: f64,
        traversal: &'a mut Workspace,
        pieces: &'a mut MaximumSearch<Piece>,
        progress: Progress<'a>,
    ) -> Self {
        /// Roundings of one coordinate that a distance between surfaces may be off by.
        const ROUNDINGS: f64 = 64.0;

        let deepest = Depth {
            lower: 0.0,
            upper: 0.0,
            point: DVec3::ZERO,
            face: UNKNOWN,
            foot: DVec3::ZERO,
            is_narrow: true,
        };
        let rounding = ROUNDINGS * f64::EPSILON * size;
        let polls = progress.every(POLLED_QUERIES);
        Self { other, known, traversal, pieces, deepest, rounding, queries: 0, progress, polls }
    }

    /// Computes the distance of inside vertices, those filled last first, which lie deepest in
    /// general. Writes a face near each; a vertex that is certainly less deep than another keeps
    /// the face of its neighbor, without a query.
    fn query_vertices(
        &mut self,
        clipper: &Clipper<'_>,
        nearest: &mut Vec<u32>,
    ) -> Result<(), Interrupted> {
        let surface = clipper.body.surface();
        let vertices = &clipper.inside.vertices;
        // A vertex next to one whose face is known starts from that face.
        nearest.clear();
        nearest.resize(vertices.len(), UNKNOWN);
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
                nearest[place] = self.query_vertex(vertex, point, face, hint)?;
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
        Ok(())
    }

    /// Adds the faces that are inside as a whole, each bounded by the faces near its corners.
    fn add_whole_faces(
        &mut self,
        clipper: &Clipper<'_>,
        faces: &[u32],
        nearest: &[u32],
    ) -> Result<(), Interrupted> {
        let mut polls = self.progress.every(POLLED_FACES);
        for &face in faces {
            polls.step()?;
            let corners = clipper.body.surface().faces()[face as usize];
            let mut near = [UNKNOWN; 3];
            for (near, corner) in near.iter_mut().zip(corners) {
                *near = nearest[clipper.inside.place(corner).unwrap_or(0) as usize];
            }
            self.add(clipper.body.corners(face), face, &near);
        }
        Ok(())
    }

    /// Returns true if the inside part of a cut face may be deepest.
    ///
    /// Most cut faces are shallow as a whole: they are not clipped.
    fn needs_clipping(
        &mut self,
        clipper: &Clipper<'_>,
        stretches: &[FaceStretch],
        near: &[u32],
    ) -> bool {
        let Some(point) = clipper.wanted_point(stretches) else { return false };
        if self.deepest.face == UNKNOWN {
            // Where the surfaces cross, a depth of 0 is attained.
            self.deepest = Depth { point, face: stretches[0].face, foot: point, ..self.deepest };
        }
        let (bound, _) = self.bound(clipper.body.corners(stretches[0].face), near);
        let is_shallow = bound <= self.pieces.sufficient();
        if is_shallow {
            self.pieces.leave_out(bound);
        }
        !is_shallow
    }

    /// Adds a triangle, bounded by the best of some faces.
    fn add(&mut self, corners: [DVec3; 3], face: u32, near: &[u32]) {
        let (bound, near) = self.bound(corners, near);
        self.add_near(bound, Piece { corners, face, near, distance: f64::INFINITY });
    }

    /// Adds a triangle with a bound, and a face from which one near its center is found, unless that bounds it well
    /// enough.
    fn add_near(&mut self, mut bound: f64, mut piece: Piece) {
        if bound > self.pieces.sufficient() {
            let (center, radius) = radius_about_center(piece.corners);
            let found = self.other.near_point(center, piece.near);
            bound = bound.min(found.distance + radius + self.rounding);
            if found.face != piece.near {
                bound = bound.min(self.upper_by(found.face, piece.corners));
            }
            (piece.near, piece.distance) = (found.face, found.distance);
        }
        self.pieces.add(bound, piece);
    }

    /// Bounds the depth of a triangle by the best of some faces, or the first that is good enough.
    fn bound(&self, corners: [DVec3; 3], near: &[u32]) -> (f64, u32) {
        let mut best = (f64::INFINITY, near[0]);
        for (number, &face) in near.iter().enumerate() {
            // Corners of a face often have one nearest face.
            if near[..number].contains(&face) {
                continue;
            }
            let upper = self.upper_by(face, corners);
            if upper < best.0 {
                best = (upper, face);
            }
            if upper <= self.pieces.sufficient() {
                break;
            }
        }
        best
    }

    /// Divides a triangle. The distance at its center is computed where it may be deepest.
    fn split(&mut self, mut bound: f64, piece: &Piece) -> Result<(), Interrupted> {
        self.count()?;
        let mut near = piece.near;
        if piece.distance > self.pieces.lower() {
            // The center is inside, so that its distance is attained.
            let (center, radius) = radius_about_center(piece.corners);
            let (found, distance) = self.query(center, piece.face, Some(near))?;
            bound = bound.min(distance + radius + self.rounding);
            near = found;
        }

        // One face bounds the whole or a part by the greatest distance of its corners, which parts share.
        let of_corners = piece.corners.map(|corner| self.squared_distance_to(near, corner));
        let farthest = max_of(&of_corners, [0, 1, 2]).sqrt();
        bound = bound.min(farthest + self.rounding);
        if bound <= self.pieces.sufficient() {
            self.pieces.leave_out(bound);
            return Ok(());
        }
        let face = self.other.corners(near);
        let division = TriangleDivision::at_edge(piece.corners, of_corners, face)
            .unwrap_or_else(|| TriangleDivision::in_quarters(piece.corners));
        let of_added = division.added().map(|point| self.squared_distance_to(near, point));
        let squared = TriangleDivision::joined(of_corners, of_added);
        let points = division.points(piece.corners);
        for part in division.parts() {
            let by_face = max_of(&squared, *part).sqrt() + self.rounding;
            let corners = part.map(|place| points[place]);
            self.add_near(by_face.min(bound), Piece { corners, near, ..*piece });
        }
        Ok(())
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
            greatest = greatest.max(self.squared_distance_to(near, corner));
        }
        greatest.sqrt() + self.rounding
    }

    fn distance_to(&self, near: u32, point: DVec3) -> f64 {
        self.squared_distance_to(near, point).sqrt()
    }

    fn squared_distance_to(&self, near: u32, point: DVec3) -> f64 {
        closest_on_triangle(point, self.other.corners(near)).point.distance_squared(point)
    }

    /// Returns the face nearest to an inside vertex, and records its distance.
    fn query_vertex(
        &mut self,
        vertex: u32,
        point: DVec3,
        face: u32,
        hint: Option<u32>,
    ) -> Result<u32, Interrupted> {
        let Ok(place) = self.known.binary_search_by_key(&vertex, |known| known.vertex) else {
            return Ok(self.query(point, face, hint)?.0);
        };
        let known = &self.known[place];
        self.record(point, face, known.foot, known.gap.abs());
        Ok(known.face)
    }

    /// Computes the distance of a point inside from the other surface; it bounds the depth below.
    fn query(
        &mut self,
        point: DVec3,
        face: u32,
        hint: Option<u32>,
    ) -> Result<(u32, f64), Interrupted> {
        self.count()?;
        let found = self.other.closest_point(point, f64::INFINITY, hint, self.traversal);
        let Some(found) = found else { return Ok((0, 0.0)) };
        self.record(point, face, found.foot.point, found.distance);
        Ok((found.face, found.distance))
    }

    /// Counts a query or a division, and polls from time to time.
    fn count(&mut self) -> Result<(), Interrupted> {
        self.queries += 1;
        self.polls.step()
    }

    /// Records the depth of a point.
    fn record(&mut self, point: DVec3, face: u32, foot: DVec3, distance: f64) {
        if distance >= self.pieces.lower() {
            self.deepest = Depth { point, face, foot, ..self.deepest };
            self.pieces.evaluated(distance);
        }
    }
}

/// Returns the largest of some values, at least 0.
fn max_of(values: &[f64], places: [usize; 3]) -> f64 {
    places.into_iter().map(|k| values[k]).fold(0.0, f64::max)
}

/// Returns the largest coordinate of a body, by its bounds.
fn size(body: &SurfaceTree) -> f64 {
    let bounds = body.tree().root();
    let mut size: f32 = 0.0;
    for axis in 0..3 {
        let [lower, upper] = bounds.interval(axis);
        size = size.max(lower.abs()).max(upper.abs());
    }
    f64::from(size)
}
