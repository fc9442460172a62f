//! Depth of the surfaces of a pair, in certified brackets.
//!
//! Depth is the greatest distance of a point of one surface inside the other body from the other
//! surface, the larger of both directions: a directed Hausdorff distance, restricted to a region.
//! Unlike the depth of vertices it depends on the shape alone, so that it changes by no more than
//! two surfaces deviate.
//!
//! A branch and bound search takes the faces that have points inside: those at inside vertices, and
//! those that meet the other surface, of which the polygon around the inside part counts. Detection
//! has projected the inside vertices already, whose depths `d` bound the result below. A triangle
//! with corners `t`, center `c` and longest edge `L` has no point deeper than each of
//!
//! ```text
//! max_i d_i + L/√3            every point is within L/√3 of a corner; outside, d is 0
//! max_i dist(t_i, g)          the distance from any one face g is convex
//! max_i dist(t_i, s)          as is that from a segment s where faces cross
//! dist(c, g) + max_i |t_i − c|
//! max_i |t_i − c| − dist(c)   where c is outside
//! ```
//!
//! since the way from a point inside to one outside leaves the body. A good face `g` is found by
//! descent from neighbor to neighbor, for a tenth of the time of the closest point. That is
//! computed only where it may be farther than the deepest point so far. Both directions share one
//! lower bound: where one is deeper, the other is bounded by it and no further.
//!
//! # Coarse surfaces
//!
//! Where surfaces within α and β stand for those of the bodies, a depth `d` among them is one of at
//! most `d + α + β` of the bodies, and of at least `d − α − β`. At a vertex, which a coarse surface
//! shares with its body, that is `d − β`, with the deviation of the other one alone.
//!
//! The search ends where the bracket on the depth of the bodies is no wider than twice the tolerance:
//! some depth in it is within the tolerance of both ends. That of the deepest point is returned where
//! it is, since it is mostly right, and else the next one that is.

use glam::DVec3;
use kdop::Workspace;
use proximity::{MaximumSearch, NearVertex, PairProximity, SurfaceTree, TriangleDivision};
use scene::DepthBracket;
use surface::closest_on_triangle;
use surface::triangle::{self, radius_about_center};

use crate::OperationCounts;
use crate::cut_face::CutFace;
use crate::rounding::rounding;

/// Triangles that a search splits, some seconds: reached where whole surfaces are equally deep.
const MAX_SPLITS: u32 = 4_000_000;

/// Share of the width of a bracket that the rounding of polygons may take.
const ERROR_SHARE: f64 = 1e-3;

/// Search for depths, in memory that is reused from frame to frame.
#[derive(Debug, Default)]
pub(crate) struct SurfaceDepth {
    workspace: Workspace,
    /// Per vertex of each body: 1 + its place among the near vertices where it is inside, or 0.
    /// Zero between searches.
    places: [Vec<u32>; 2],
    cut_faces: Vec<u32>,
    cut_face: CutFace,
    pieces: MaximumSearch<Piece>,
}

/// Surfaces of a pair as they are compared, and how much these deviate from the bodies' own.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Compared<'a> {
    pub(crate) bodies: [&'a SurfaceTree; 2],
    pub(crate) deviations: [f64; 2],
}

/// Depth of a pair.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FoundDepth {
    /// Depth within the tolerance of that of the bodies' own surfaces: of the deepest point, or more.
    pub(crate) depth: f64,
    /// Bracket on the depth of the bodies' own surfaces.
    pub(crate) bracket: DepthBracket,
}

/// Triangle that may hold the deepest point.
#[derive(Clone, Copy, Debug)]
struct Piece {
    corners: [DVec3; 3],
    /// Squared distances of the corners from the near face.
    squared: [f64; 3],
    /// Place of its body in the pair.
    side: usize,
    /// Face of the other body near its center.
    near: Near,
    /// True if all of it is inside the other body.
    is_inside: bool,
}

/// Face near a point, and its distance.
#[derive(Clone, Copy, Debug)]
struct Near {
    face: u32,
    distance: f64,
}

/// Search for the deepest point of a pair.
struct Search<'a> {
    found: &'a PairProximity,
    bodies: [&'a SurfaceTree; 2],
    places: &'a [Vec<u32>; 2],
    workspace: &'a mut Workspace,
    cut_face: &'a mut CutFace,
    pieces: &'a mut MaximumSearch<Piece>,
    /// Sum of the deviations of both surfaces.
    deviation: f64,
    /// Depth of the deepest point of the compared surfaces so far.
    deepest: f64,
    /// Bound on the rounding of a distance.
    rounding: f64,
    /// Distance by which inside points may be off the pieces, and the largest allowed one.
    error: f64,
    max_error: f64,
    clipped: u32,
    splits: u32,
    queries: u32,
}

impl SurfaceDepth {
    /// Finds the depth of two bodies whose proximity was computed, within a tolerance that is larger
    /// than their deviations.
    ///
    /// A body without an inside has no depth in it.
    pub(crate) fn find(
        &mut self,
        found: &PairProximity,
        compared: Compared<'_>,
        tolerance: f64,
        operations: &mut OperationCounts,
    ) -> FoundDepth {
        // Nothing meets and nothing is inside.
        let Compared { bodies, deviations } = compared;
        let deviation = deviations[0] + deviations[1];
        if found.meeting_faces().is_empty() && !found.overlaps() {
            let bracket = DepthBracket { lower: 0.0, upper: deviation };
            return FoundDepth { depth: 0.0, bracket };
        }

        // Among the compared surfaces a bracket is as wide as the tolerance, or as deviations leave.
        // Surfaces that only touch are to be told apart from those that are deeper than the tolerance.
        let rest = tolerance - deviation;
        let width = if found.overlaps() { tolerance + deviation.min(rest) } else { rest };
        self.mark_inside(found, bodies);
        let Self { workspace, places, cut_faces, cut_face, pieces } = self;
        let max_error = ERROR_SHARE * width;
        pieces.restart(width - max_error, 0.0);
        let rounding = rounding(bodies);
        let mut search = Search {
            found,
            bodies,
            places,
            workspace,
            cut_face,
            pieces,
            deviation,
            deepest: 0.0,
            rounding,
            error: 0.0,
            max_error,
            clipped: 0,
            splits: 0,
            queries: 0,
        };
        search.run(deviations, cut_faces);

        let Search { clipped, splits, queries, error, deepest, .. } = search;
        operations.clipped_faces += f64::from(clipped);
        operations.split_pieces += f64::from(splits);
        operations.depth_queries += f64::from(queries);
        let bounds = search.pieces.bounds();
        self.unmark_inside(found);
        let upper = bounds.upper.max(deepest) + error + deviation;
        let bracket = DepthBracket { lower: bounds.lower, upper };
        FoundDepth { depth: deepest.max(upper - tolerance), bracket }
    }

    /// Notes the places of inside vertices among the near ones.
    fn mark_inside(&mut self, found: &PairProximity, bodies: [&SurfaceTree; 2]) {
        for (side, places) in self.places.iter_mut().enumerate() {
            let vertex_count = bodies[side].surface().vertex_count();
            if places.len() < vertex_count {
                places.resize(vertex_count, 0);
            }
            for (place, near) in (1..).zip(found.sides()[side].near()) {
                if is_inside(near) {
                    places[near.vertex as usize] = place;
                }
            }
        }
    }

    fn unmark_inside(&mut self, found: &PairProximity) {
        for (side, places) in self.places.iter_mut().enumerate() {
            for near in inside(found, side) {
                places[near.vertex as usize] = 0;
            }
        }
    }
}

impl<'a> Search<'a> {
    /// Searches the faces of both sides.
    fn run(&mut self, deviations: [f64; 2], cut_faces: &mut Vec<u32>) {
        let (found, bodies) = (self.found, self.bodies);
        let sides = [0, 1].into_iter().filter(|&side| bodies[1 - side].has_inside().is_ok());

        // Vertices of both sides first, so that most faces are bounded by them.
        for side in sides.clone() {
            for near in inside(found, side) {
                self.deepest = self.deepest.max(-near.gap);
                self.pieces.evaluated(-near.gap - deviations[1 - side]);
            }
        }
        for side in sides {
            self.add_faces(side, cut_faces);
        }
        while self.splits < MAX_SPLITS {
            let Some((bound, piece)) = self.pieces.next() else { break };
            self.split(bound, piece);
        }
    }

    /// Returns true if a point at a distance from the other surface may raise the lower bound.
    fn may_be_deepest(&self, distance: f64) -> bool {
        distance - self.deviation > self.pieces.lower()
    }

    /// Adds the faces of one side that have points inside, each once.
    fn add_faces(&mut self, side: usize, cut_faces: &mut Vec<u32>) {
        // A face with inside corners comes with the first of them.
        let (found, own) = (self.found, self.bodies[side]);
        for near in inside(found, side) {
            for &face in own.surface().vertex_faces(near.vertex) {
                let corners = self.inside_corners(side, face);
                let first = corners.iter().flatten().next();
                if first.is_some_and(|first| first.vertex == near.vertex) {
                    self.add_face(side, face, corners);
                }
            }
        }

        // Faces without any are inside where they meet the other surface.
        cut_faces.clear();
        cut_faces.extend(found.meeting_faces().iter().map(|faces| faces[side]));
        cut_faces.sort_unstable();
        cut_faces.dedup();
        for &face in &*cut_faces {
            if self.inside_corners(side, face).iter().all(Option::is_none) {
                self.add_face(side, face, [None; 3]);
            }
        }
    }

    /// Returns the corners of a face that are inside the other body.
    fn inside_corners(&self, side: usize, face: u32) -> [Option<&'a NearVertex>; 3] {
        let near = self.found.sides()[side].near();
        self.bodies[side].surface().faces()[face as usize].map(|vertex| {
            let place = self.places[side][vertex as usize].checked_sub(1)?;
            Some(&near[place as usize])
        })
    }

    /// Adds a face, unless the depths of its corners bound it well enough.
    fn add_face(&mut self, side: usize, face: u32, inside: [Option<&NearVertex>; 3]) {
        let (own, other) = (self.bodies[side], self.bodies[1 - side]);
        let corners = own.corners(face);
        let mut deepest: f64 = 0.0;
        for near in inside.into_iter().flatten() {
            deepest = deepest.max(-near.gap);
        }
        let by_corners = deepest + max_distance_to_corner(corners) + self.rounding;
        if by_corners <= self.pieces.sufficient() {
            self.pieces.leave_out(by_corners);
            return;
        }

        // A face that crosses none is inside as a whole; others may be near one face as a whole.
        let crossed = self.found.sides()[side].near_faces().row(face);
        let nearest = inside.iter().flatten().map(|near| near.face);
        let Some(near) = nearest.chain(crossed.iter().copied()).next() else { return };
        let piece = self.piece(corners, side, near, crossed.is_empty());
        let bound = by_corners.min(self.by_near_face(&piece));
        if crossed.is_empty() || bound <= self.pieces.sufficient() {
            self.add(bound, piece);
            return;
        }

        // Of the rest, the polygon around what is inside.
        self.clipped += u32::try_from(crossed.len()).unwrap_or(u32::MAX);
        let faces = crossed.iter().map(|&face| (face, other.corners(face)));
        let is_inside = inside.map(|near| near.is_some());
        self.error = self.error.max(self.cut_face.find(corners, is_inside, faces, self.max_error));
        let by_corners = deepest + self.cut_face.max_distance() + self.rounding;
        let by_crossing = self.cut_face.max_distance_to_crossing() + self.rounding;
        let by_polygon = by_corners.min(by_crossing);
        if by_polygon <= self.pieces.sufficient() {
            self.pieces.leave_out(by_polygon);
            return;
        }
        let bound = bound.min(by_polygon);
        for number in 0..self.cut_face.divide(triangle::normal(corners)) {
            let (corners, crossing) = self.cut_face.triangle(number);
            self.add(bound, self.piece(corners, side, crossing.unwrap_or(near), false));
        }
    }

    /// Adds a triangle with a bound, unless faces near its center bound it well enough.
    fn add(&mut self, bound: f64, mut piece: Piece) {
        // The face that is known bounds many triangles, in less than the time of a descent.
        let mut bound = bound.min(self.by_near_face(&piece));
        if bound > self.pieces.sufficient() {
            let (center, radius) = radius_about_center(piece.corners);
            let known = piece.near.face;
            let near = self.bodies[1 - piece.side].near_point(center, known);
            piece.near = Near { face: near.face, distance: near.distance };
            bound = bound.min(piece.near.distance + radius + self.rounding);
            if piece.near.face != known {
                self.measure_corners(&mut piece);
                bound = bound.min(self.by_near_face(&piece));
            }
        }
        self.pieces.add(bound, piece);
    }

    /// Computes the distance of a triangle's center where it may be the deepest point, and divides
    /// the triangle.
    fn split(&mut self, mut bound: f64, mut piece: Piece) {
        self.splits += 1;
        if self.may_be_deepest(piece.near.distance) {
            bound = self.evaluate(bound, &mut piece);
            if bound <= self.pieces.sufficient() {
                self.pieces.leave_out(bound);
                return;
            }
        }
        let division = self.division(&piece);
        let of_added = division.added().map(|x| self.squared_from(piece.side, piece.near.face, x));
        let squared = TriangleDivision::joined(piece.squared, of_added);
        let points = division.points(piece.corners);
        for part in division.parts() {
            let corners = part.map(|number| points[number]);
            let squared = part.map(|number| squared[number]);
            self.add(bound, Piece { corners, squared, ..piece });
        }
    }

    /// Divides a triangle at an edge of its near face, or in two. Parts keep that face, from which the points between
    /// are yet to be measured.
    fn division(&self, piece: &Piece) -> TriangleDivision {
        let face = self.bodies[1 - piece.side].corners(piece.near.face);
        TriangleDivision::at_edge(piece.corners, piece.squared, face)
            .unwrap_or_else(|| TriangleDivision::in_halves(piece.corners))
    }

    /// Computes the distance of a triangle's center, and returns the bound on the triangle.
    fn evaluate(&mut self, bound: f64, piece: &mut Piece) -> f64 {
        let other = self.bodies[1 - piece.side];
        let (center, radius) = radius_about_center(piece.corners);
        let hint = Some(piece.near.face);
        let closest = other.closest_point(center, f64::INFINITY, hint, self.workspace);
        let Some(closest) = closest else { return bound };
        self.queries += 1;
        let distance = closest.distance;
        piece.near = Near { face: closest.face, distance };
        self.measure_corners(piece);
        if !self.may_be_deepest(distance) {
            return bound.min(distance + radius + self.rounding);
        }

        // A center inside attains its distance; from one outside, the body begins at its distance.
        if piece.is_inside || other.contains(center, self.workspace) {
            self.deepest = self.deepest.max(distance);
            self.pieces.evaluated(distance - self.deviation);
            piece.is_inside |= distance > radius + self.rounding;
            bound.min(distance + radius + self.rounding)
        } else {
            bound.min((radius - distance).max(0.0) + self.rounding)
        }
    }

    /// Returns a triangle, with a face that may be near its center.
    fn piece(&self, corners: [DVec3; 3], side: usize, near: u32, is_inside: bool) -> Piece {
        let near = Near { face: near, distance: f64::INFINITY };
        let mut piece = Piece { corners, squared: [0.0; 3], side, near, is_inside };
        self.measure_corners(&mut piece);
        piece
    }

    /// Computes the distances of a triangle's corners from its near face.
    fn measure_corners(&self, piece: &mut Piece) {
        let Piece { corners, side, near, .. } = *piece;
        piece.squared = corners.map(|corner| self.squared_from(side, near.face, corner));
    }

    /// Returns true if the distances of a triangle's corners are those from its near face.
    fn is_measured(&self, piece: &Piece) -> bool {
        let mut measured = *piece;
        self.measure_corners(&mut measured);
        measured.squared.map(f64::to_bits) == piece.squared.map(f64::to_bits)
    }

    /// Computes the squared distance of a point of one side from a face of the other.
    fn squared_from(&self, side: usize, face: u32, point: DVec3) -> f64 {
        let corners = self.bodies[1 - side].corners(face);
        closest_on_triangle(point, corners).point.distance_squared(point)
    }

    /// Bounds the depth of a triangle by the distances of its corners from its near face.
    fn by_near_face(&self, piece: &Piece) -> f64 {
        debug_assert!(self.is_measured(piece), "{piece:?}");
        let [a, b, c] = piece.squared;
        a.max(b).max(c).sqrt() + self.rounding
    }
}

/// Returns the vertices of one side inside the other body, ascending.
fn inside(found: &PairProximity, side: usize) -> impl Iterator<Item = &NearVertex> {
    found.sides()[side].near().iter().filter(|near| is_inside(near))
}

/// Returns true for a vertex inside, however little.
fn is_inside(near: &NearVertex) -> bool {
    near.gap.is_sign_negative()
}

/// Bounds the distance of a point of a triangle from the nearest corner: longest edge over √3.
fn max_distance_to_corner([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a));
    (longest / 3.0).sqrt()
}

#[cfg(test)]
mod tests;
