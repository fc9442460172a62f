//! Faces of one body clipped to the inside of the other.
//!
//! The border of the part of a face inside the other body is a set of directed pieces between
//! named nodes, with one piece that begins at each node. Following them from node to node yields
//! the loops: outer ones counter-clockwise about the face's normal, holes clockwise.

use std::ops::Range;

use glam::DVec3;
use proximity::SurfaceTree;
use surface::triangle;

use crate::curve::Curve;
use crate::inside::Inside;
use crate::regions::{Node, Regions};
use crate::triangulation::Triangulation;

/// The part of a face inside the other body that belongs to one region.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ClippedFace {
    /// The face.
    pub face: u32,
    /// The place of its region in [`Overlap::regions`](crate::Overlap::regions).
    pub region: u32,
    /// Polygons that border the part: outer loops counter-clockwise seen from outside the body,
    /// holes clockwise.
    pub loops: Vec<Vec<DVec3>>,
}

/// A stretch as a face of one side has it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct FaceStretch {
    pub(crate) face: u32,
    /// Its place on the curve.
    number: u32,
    /// The face of the other body.
    pub(crate) crossed_by: u32,
}

/// Input of the clipping of one body's faces.
pub(crate) struct Clipper<'a> {
    pub(crate) side: usize,
    pub(crate) body: &'a SurfaceTree,
    pub(crate) curve: &'a Curve,
    pub(crate) inside: &'a Inside,
    pub(crate) regions: &'a Regions,
    /// The region to which the parts are restricted, or none for all of them.
    pub(crate) region: Option<u32>,
}

/// Clipping of one face after another, in memory that is reused.
#[derive(Debug, Default)]
pub(crate) struct FaceClip {
    /// Pieces of the face's border, by the nodes that they begin at, one per node.
    pieces: Vec<Piece>,
    /// Loops of the face that was clipped last, part after part.
    loops: Vec<Loop>,
    /// Their points.
    points: Vec<DVec3>,
    triangulation: Triangulation,
}

/// Directed piece of a face's border.
#[derive(Clone, Copy, Debug)]
struct Piece {
    from: Node,
    to: Node,
    /// True once it is in a loop.
    is_taken: bool,
}

/// Closed polygon of a face's border.
#[derive(Clone, Debug)]
struct Loop {
    /// Number of the part of the face that it borders.
    part: usize,
    region: u32,
    /// Its points, among those of the face.
    points: Range<usize>,
}

impl Clipper<'_> {
    /// Returns the parts of all faces: of those that the curve cuts, ascending, then the whole ones.
    pub(crate) fn patches(&self) -> Vec<ClippedFace> {
        let (mut patches, mut clip) = (Vec::new(), FaceClip::default());
        let mut stretches = Vec::new();
        self.collect_stretches(&mut stretches);
        for group in stretches.chunk_by(|p, q| p.face == q.face) {
            self.clip(group, &mut clip);
            clip.push_parts(group[0].face, &mut patches);
        }

        let mut whole = Vec::new();
        self.collect_whole_faces(&mut whole);
        for face in whole {
            let first = self.body.surface().faces()[face as usize][0];
            let region = self.region_of(Node::Vertex(first));
            let loops = vec![self.body.corners(face).to_vec()];
            patches.push(ClippedFace { face, region, loops });
        }
        patches
    }

    /// Collects the stretches by the faces of this side, ascending, in place of earlier ones.
    pub(crate) fn collect_stretches(&self, by_face: &mut Vec<FaceStretch>) {
        by_face.clear();
        for (number, stretch) in (0..).zip(&self.curve.stretches) {
            let (face, crossed_by) = (stretch.faces[self.side], stretch.faces[1 - self.side]);
            by_face.push(FaceStretch { face, number, crossed_by });
        }
        by_face.sort_unstable();
    }

    /// Clips the face of some stretches, which are all that it has: one part per region.
    pub(crate) fn clip(&self, stretches: &[FaceStretch], clip: &mut FaceClip) {
        clip.pieces.clear();
        for stretch in stretches {
            let [begin, end] = self.curve.stretches[stretch.number as usize].ends;
            let [from, to] = if self.side == 0 { [begin, end] } else { [end, begin] };
            clip.add_piece(Node::Passing(from), Node::Passing(to));
        }
        self.add_edges(stretches[0].face, clip);
        clip.sort_pieces();

        clip.loops.clear();
        clip.points.clear();
        for place in 0..clip.pieces.len() {
            if !clip.pieces[place].is_taken {
                self.take_loop(place, clip);
            }
        }
        clip.loops.sort_by_key(|found| found.part);
    }

    /// Returns true if an inside vertex is in the region that the parts are restricted to.
    #[inline]
    pub(crate) fn wants(&self, vertex: u32) -> bool {
        self.region.is_none_or(|wanted| wanted == self.region_of(Node::Vertex(vertex)))
    }

    /// Returns the point at which a stretch of a face begins, if one is in the region that the parts
    /// are restricted to.
    pub(crate) fn wanted_point(&self, stretches: &[FaceStretch]) -> Option<DVec3> {
        for stretch in stretches {
            let [begin, _] = self.curve.stretches[stretch.number as usize].ends;
            let region = || self.region_of(Node::Passing(begin));
            if self.region.is_none_or(|wanted| wanted == region()) {
                return Some(self.regions.position(begin));
            }
        }
        None
    }

    fn region_of(&self, node: Node) -> u32 {
        self.regions.reported(self.side, node, self.inside)
    }

    /// Collects the faces that are inside as a whole, cluster after cluster, in place of earlier ones.
    pub(crate) fn collect_whole_faces(&self, whole: &mut Vec<u32>) {
        whole.clear();
        for &face in self.inside.faces() {
            let first = self.body.surface().faces()[face as usize][0];
            if self.wants(first) && self.is_whole(face) {
                whole.push(face);
            }
        }
    }

    /// Returns true if a face between inside vertices has a corner at each, and is not cut.
    fn is_whole(&self, face: u32) -> bool {
        let [a, b, c] = self.body.surface().faces()[face as usize];
        let is_cut = || self.curve.cut_faces[self.side].binary_search(&face).is_ok();
        a != b && b != c && c != a && !is_cut()
    }

    /// Adds the inside parts of a face's edges, as the face runs along them.
    fn add_edges(&self, face: u32, clip: &mut FaceClip) {
        let surface = self.body.surface();
        let corners = surface.faces()[face as usize];
        for (k, edge) in surface.face_edges()[face as usize].into_iter().enumerate() {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);

            // An edge that is not cut is inside as a whole or not at all.
            let Some(cut) = self.curve.cut_edges[self.side].place(edge) else {
                if self.inside.place(from).is_some() && self.inside.place(to).is_some() {
                    clip.add_piece(Node::Vertex(from), Node::Vertex(to));
                }
                continue;
            };

            // Parts run from the lower-numbered end; the face may run the other way.
            for part in self.regions.parts_of(self.side, cut) {
                let [start, end] =
                    if from < to { [part.from, part.to] } else { [part.to, part.from] };
                clip.add_piece(start, end);
            }
        }
    }

    /// Takes the pieces of the loop that one begins; a piece that leads nowhere ends the loop.
    fn take_loop(&self, first: usize, clip: &mut FaceClip) {
        let begin = clip.points.len();
        let start = clip.pieces[first].from;
        let mut next = Some(first);
        let mut at = start;
        while let Some(place) = next {
            clip.points.push(self.position(at));
            let piece = &mut clip.pieces[place];
            piece.is_taken = true;
            at = piece.to;
            if at == start {
                break;
            }
            next = clip.untaken(at);
            if next.is_none() {
                clip.points.push(self.position(at));
            }
        }
        debug_assert_eq!(at, start, "the border of a clipped face closes");

        // Loops without area, and those of other regions, are left out.
        let points = begin..clip.points.len();
        let region = self.region_of(start);
        if points.len() <= 2 || self.region.is_some_and(|wanted| wanted != region) {
            clip.points.truncate(begin);
            return;
        }
        let known = clip.loops.iter().find(|known| known.region == region);
        let part = known.map_or(clip.loops.len(), |known| known.part);
        clip.loops.push(Loop { part, region, points });
    }

    fn position(&self, node: Node) -> DVec3 {
        match node {
            Node::Vertex(vertex) => self.body.position(vertex),
            Node::Passing(passing) => self.regions.position(passing),
        }
    }
}

impl FaceClip {
    fn add_piece(&mut self, from: Node, to: Node) {
        self.pieces.push(Piece { from, to, is_taken: false });
    }

    /// Sorts the pieces by the nodes that they begin at: several at a point of an edge of four faces.
    fn sort_pieces(&mut self) {
        self.pieces.sort_by_key(|piece| piece.from);
    }

    /// Finds a piece that begins at a node and is in no loop.
    fn untaken(&self, from: Node) -> Option<usize> {
        let first = self.pieces.partition_point(|piece| piece.from < from);
        let at_node = self.pieces[first..].iter().take_while(|piece| piece.from == from);
        at_node.zip(first..).find(|(piece, _)| !piece.is_taken).map(|(_, place)| place)
    }

    /// Appends the parts of the face that was clipped last.
    fn push_parts(&self, face: u32, parts: &mut Vec<ClippedFace>) {
        for part in self.loops.chunk_by(|p, q| p.part == q.part) {
            let mut loops = Vec::with_capacity(part.len());
            for border in part {
                loops.push(self.points[border.points.clone()].to_vec());
            }
            parts.push(ClippedFace { face, region: part[0].region, loops });
        }
    }

    /// Splits the parts of the face that was clipped last into triangles, in place of earlier ones.
    pub(crate) fn triangulate(&mut self, normal: DVec3, triangles: &mut Vec<[DVec3; 3]>) {
        let Self { loops, points, triangulation, .. } = self;
        triangles.clear();
        for part in loops.chunk_by(|p, q| p.part == q.part) {
            let borders = part.iter().map(|border| &points[border.points.clone()]);
            triangulation.add(borders, normal, triangles);
        }
    }
}

impl ClippedFace {
    /// Splits the part into triangles, counter-clockwise like the loops.
    ///
    /// `normal` is the face's, of any length.
    #[must_use]
    pub fn triangles(&self, normal: DVec3) -> Vec<[DVec3; 3]> {
        let mut triangles = Vec::new();
        let borders = self.loops.iter().map(Vec::as_slice);
        Triangulation::default().add(borders, normal, &mut triangles);
        triangles
    }
}

/// Computes the normal of a body's face, not normalized.
pub(crate) fn face_normal(body: &SurfaceTree, face: u32) -> DVec3 {
    triangle::normal(body.corners(face))
}
