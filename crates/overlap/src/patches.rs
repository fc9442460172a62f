//! Faces of one body clipped to the inside of the other.
//!
//! The border of the part of a face inside the other body is a set of directed pieces between
//! named nodes, with one piece that begins at each node. Following them from node to node yields
//! the loops: outer ones counter-clockwise about the face's normal, holes clockwise.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use proximity::SurfaceTree;
use surface::triangle;

use crate::curve::Curve;
use crate::inside::Inside;
use crate::regions::{Node, Regions};

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

/// The piece that begins at each node of a face's border.
type Pieces = BTreeMap<Node, Node>;

impl Clipper<'_> {
    /// Returns the parts of all faces: of those that the curve cuts, ascending, then the whole ones.
    pub(crate) fn patches(&self) -> Vec<ClippedFace> {
        let mut patches = Vec::new();
        let stretches = self.stretches_by_face();
        for group in stretches.chunk_by(|p, q| p.face == q.face) {
            patches.extend(self.clip(group));
        }

        for face in self.whole_faces() {
            let first = self.body.surface().faces()[face as usize][0];
            let region = self.region_of(Node::Vertex(first));
            let loops = vec![self.body.corners(face).to_vec()];
            patches.push(ClippedFace { face, region, loops });
        }
        patches
    }

    /// Returns the stretches by the faces of this side, ascending.
    pub(crate) fn stretches_by_face(&self) -> Vec<FaceStretch> {
        let mut by_face = Vec::with_capacity(self.curve.stretches.len());
        for (number, stretch) in (0..).zip(&self.curve.stretches) {
            let (face, crossed_by) = (stretch.faces[self.side], stretch.faces[1 - self.side]);
            by_face.push(FaceStretch { face, number, crossed_by });
        }
        by_face.sort_unstable();
        by_face
    }

    /// Clips the face of some stretches, which are all that it has: one part per region.
    pub(crate) fn clip(&self, stretches: &[FaceStretch]) -> Vec<ClippedFace> {
        let mut pieces = Pieces::new();
        for stretch in stretches {
            let [begin, end] = self.curve.stretches[stretch.number as usize].ends;
            let [from, to] = if self.side == 0 { [begin, end] } else { [end, begin] };
            pieces.insert(Node::Passing(from), Node::Passing(to));
        }
        let face = stretches[0].face;
        self.add_edges(face, &mut pieces);

        let mut parts: Vec<ClippedFace> = Vec::new();
        while let Some((region, points)) = self.next_loop(&mut pieces) {
            if points.len() <= 2 || self.region.is_some_and(|wanted| wanted != region) {
                continue;
            }
            match parts.iter_mut().find(|part| part.region == region) {
                Some(part) => part.loops.push(points),
                None => parts.push(ClippedFace { face, region, loops: vec![points] }),
            }
        }
        parts
    }

    /// Returns true if an inside vertex is in the region that the parts are restricted to.
    #[inline]
    pub(crate) fn wants(&self, vertex: u32) -> bool {
        self.region.is_none_or(|wanted| wanted == self.region_of(Node::Vertex(vertex)))
    }

    /// Returns true if a stretch of a face is in the region that the parts are restricted to.
    pub(crate) fn wants_face(&self, stretches: &[FaceStretch]) -> bool {
        let Some(wanted) = self.region else { return true };
        for stretch in stretches {
            let [begin, _] = self.curve.stretches[stretch.number as usize].ends;
            if self.region_of(Node::Passing(begin)) == wanted {
                return true;
            }
        }
        false
    }

    fn region_of(&self, node: Node) -> u32 {
        self.regions.reported(self.side, node, self.inside)
    }

    /// Returns the faces that are inside as a whole, in the order of the fill.
    pub(crate) fn whole_faces(&self) -> Vec<u32> {
        let surface = self.body.surface();
        let mut whole = Vec::new();
        for found in &self.inside.vertices {
            if !self.wants(found.vertex) {
                continue;
            }
            for &face in surface.vertex_faces(found.vertex) {
                // Each face is taken at its first corner.
                let is_first = surface.faces()[face as usize][0] == found.vertex;
                if is_first && self.is_whole(face) {
                    whole.push(face);
                }
            }
        }
        whole
    }

    /// Returns true if all corners of a face are inside and none of its edges is cut.
    fn is_whole(&self, face: u32) -> bool {
        let surface = self.body.surface();
        let corners = surface.faces()[face as usize];
        let edges = surface.face_edges()[face as usize];
        corners.iter().all(|&corner| self.inside.place(corner).is_some())
            && edges.iter().all(|&edge| self.inside.cut(edge).is_none())
    }

    /// Adds the inside parts of a face's edges, as the face runs along them.
    fn add_edges(&self, face: u32, pieces: &mut Pieces) {
        let surface = self.body.surface();
        let corners = surface.faces()[face as usize];
        for (k, edge) in surface.face_edges()[face as usize].into_iter().enumerate() {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);

            // An edge that is not cut is inside as a whole or not at all.
            let Some(cut) = self.inside.cut(edge) else {
                if self.inside.place(from).is_some() && self.inside.place(to).is_some() {
                    pieces.insert(Node::Vertex(from), Node::Vertex(to));
                }
                continue;
            };

            // Parts run from the lower-numbered end; the face may run the other way.
            for part in self.regions.parts_of(self.side, cut) {
                let [start, end] =
                    if from < to { [part.from, part.to] } else { [part.to, part.from] };
                pieces.insert(start, end);
            }
        }
    }

    /// Takes the pieces of one loop, with its region; a piece that leads nowhere ends the loop.
    fn next_loop(&self, pieces: &mut Pieces) -> Option<(u32, Vec<DVec3>)> {
        let (start, mut at) = pieces.pop_first()?;
        let mut points = vec![self.position(start)];
        while at != start {
            points.push(self.position(at));
            match pieces.remove(&at) {
                Some(next) => at = next,
                None => break,
            }
        }
        debug_assert_eq!(at, start, "the border of a clipped face closes");
        Some((self.region_of(start), points))
    }

    fn position(&self, node: Node) -> DVec3 {
        match node {
            Node::Vertex(vertex) => self.body.position(vertex),
            Node::Passing(passing) => self.regions.position(passing),
        }
    }
}

impl ClippedFace {
    /// Splits the part into triangles, counter-clockwise like the loops.
    ///
    /// `normal` is the face's, of any length.
    #[must_use]
    pub fn triangles(&self, normal: DVec3) -> Vec<[DVec3; 3]> {
        if let [corners] = &self.loops[..]
            && let [a, b, c] = corners[..]
        {
            return vec![[a, b, c]];
        }

        // The plane of the face has two coordinates.
        let frame = Frame::new(normal);
        let mut loops: Vec<FlatLoop<'_>> = Vec::with_capacity(self.loops.len());
        for points in &self.loops {
            loops.push(FlatLoop::new(points, &frame));
        }

        // Each outer loop takes the holes that it is the smallest loop around.
        let mut triangles = Vec::new();
        for (number, outer) in loops.iter().enumerate() {
            let is_outer = outer.area > 0.0;
            if !is_outer {
                continue;
            }
            let mut holes: Vec<&FlatLoop<'_>> = Vec::new();
            for hole in &loops {
                if hole.area < 0.0 && smallest_around(&loops, hole.flat[0]) == Some(number) {
                    holes.push(hole);
                }
            }
            triangulate(outer, &holes, &mut triangles);
        }
        triangles
    }
}

/// A loop of a face's part, in space and in the plane of the face.
struct FlatLoop<'a> {
    points: &'a [DVec3],
    flat: Vec<DVec2>,
    /// Area of the polygon, negative for a hole.
    area: f64,
}

impl<'a> FlatLoop<'a> {
    fn new(points: &'a [DVec3], frame: &Frame) -> Self {
        let flat: Vec<DVec2> = points.iter().map(|&p| frame.project(p)).collect();
        let mut twice_area = 0.0;
        for ends in flat.windows(2) {
            twice_area += (ends[0] - flat[0]).perp_dot(ends[1] - flat[0]);
        }
        Self { points, flat, area: 0.5 * twice_area }
    }

    /// Returns true if a point is inside the polygon, by the parity of crossings.
    fn holds(&self, p: DVec2) -> bool {
        let mut inside = false;
        for (i, a) in self.flat.iter().enumerate() {
            let b = self.flat[(i + 1) % self.flat.len()];
            let passes_height = (a.y > p.y) != (b.y > p.y);
            if passes_height && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                inside = !inside;
            }
        }
        inside
    }
}

/// Returns the number of the smallest outer loop that holds a point.
fn smallest_around(loops: &[FlatLoop<'_>], point: DVec2) -> Option<usize> {
    let mut smallest: Option<usize> = None;
    for (i, outer) in loops.iter().enumerate() {
        let is_smaller = smallest.is_none_or(|j| outer.area < loops[j].area);
        if outer.area > 0.0 && is_smaller && outer.holds(point) {
            smallest = Some(i);
        }
    }
    smallest
}

/// Triangulates an outer loop with its holes, by ear clipping.
fn triangulate(outer: &FlatLoop<'_>, holes: &[&FlatLoop<'_>], out: &mut Vec<[DVec3; 3]>) {
    let mut points = outer.points.to_vec();
    let mut flat = outer.flat.clone();
    let mut hole_starts: Vec<u32> = Vec::new();
    for hole in holes {
        hole_starts.push(crate::curve::index(points.len()));
        points.extend(hole.points);
        flat.extend(&hole.flat);
    }

    let mut corners: Vec<u32> = Vec::new();
    let coordinates = flat.iter().map(|p| p.to_array());
    earcut::Earcut::new().earcut(coordinates, &hole_starts, &mut corners);
    for triangle in corners.chunks_exact(3) {
        let [a, b, c] = [triangle[0], triangle[1], triangle[2]];
        out.push([points[a as usize], points[b as usize], points[c as usize]]);
    }
}

/// Two axes across a normal.
struct Frame {
    x: DVec3,
    y: DVec3,
}

impl Frame {
    fn new(normal: DVec3) -> Self {
        let (x, y) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
        Self { x, y }
    }

    fn project(&self, p: DVec3) -> DVec2 {
        DVec2::new(self.x.dot(p), self.y.dot(p))
    }
}

/// Computes the normal of a body's face, not normalized.
pub(crate) fn face_normal(body: &SurfaceTree, face: u32) -> DVec3 {
    triangle::normal(body.corners(face))
}
