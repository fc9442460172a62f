//! Vertices projected to the closest point of another surface.

use glam::DVec3;
use kdop::Workspace;
use surface::progress::{Interrupted, Progress};
use surface::{Barycentric, TriangleSurface, triangle};

use crate::rounding::distance_rounding;
use crate::{ClosestPoint, FaceBox, FaceBoxes, NearFaces, SurfaceTree};

/// Vertex that is inside another surface or within the margin of it, and its closest point
/// there, the foot.
///
/// A vertex beyond the margin by no more than rounding may be one of these, with a gap above the margin.
///
/// `position = foot + gap * normal`, up to rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct NearVertex {
    /// The vertex.
    pub vertex: u32,
    /// Signed distance to the other surface, negative inside. Positive throughout where the
    /// other surface has no inside.
    pub gap: f64,
    /// The closest point.
    pub foot: DVec3,
    /// Face of the other surface that holds the foot; where several do, the one of the lowest
    /// number.
    pub face: u32,
    /// The foot in weights of that face's corners.
    pub barycentric: Barycentric,
    /// Unit normal; points out of the other surface at the foot, or to the vertex where that has
    /// no inside.
    pub normal: DVec3,
}

/// Vertices of one surface whose faces come near the other, each with the nearest of the faces
/// that do.
///
/// Of all faces at a vertex the first represents it: what is within the margin of a vertex is
/// within the margin of each of them.
#[derive(Debug, Default)]
pub(crate) struct Candidates {
    vertices: Vec<u32>,
    /// Per vertex, distance and number of the nearest face so far; none between projections.
    nearest: Vec<Nearest>,
    /// Vertices for which these are set.
    touched: Vec<u32>,
    /// Boxes of the faces of the other surface.
    boxes: FaceBoxes,
    /// Distance within which faces are offered.
    margin: f64,
    /// Computed distance up to which vertices are reported: the margin and the rounding of a
    /// distance.
    limit: f64,
}

/// Nearest of some faces.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
struct Nearest {
    distance: f64,
    face: u32,
}

impl Nearest {
    const NONE: Self = Self { distance: f64::INFINITY, face: u32::MAX };

    fn hint(self) -> Option<u32> {
        (self != Self::NONE).then_some(self.face)
    }
}

impl Candidates {
    /// Finds the vertices of `p` within `margin` of a face of `q`, in place of earlier ones.
    ///
    /// `near_faces` has the faces of `q` that may be within the margin of each face of `p`.
    pub(crate) fn find(
        &mut self,
        p: &SurfaceTree,
        near_faces: &NearFaces,
        q: &SurfaceTree,
        margin: f64,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        /// Faces between two polls for interruption: a millisecond, or some where many are near.
        const POLL_INTERVAL: u32 = 256;

        // Only what the last projection has set is reset: most of a surface is far.
        let surface = p.surface();
        self.margin = margin;
        self.limit = margin + distance_rounding([p, q]);
        self.vertices.clear();
        for vertex in self.touched.drain(..) {
            self.nearest[vertex as usize] = Nearest::NONE;
        }
        if self.nearest.len() < surface.vertex_count() {
            self.nearest.resize(surface.vertex_count(), Nearest::NONE);
        }
        self.boxes.reset(q);

        let mut polls = progress.every(POLL_INTERVAL);
        for (face, near_faces) in near_faces.iter() {
            polls.step()?;
            let corners = &surface.faces()[face as usize];

            // What is near one corner is likely to be near the others.
            let mut hint = corners.iter().find_map(|&v| self.nearest[v as usize].hint());
            for &vertex in corners {
                if surface.vertex_faces(vertex).first() == Some(&face) {
                    let nearest = self.find_nearest(p.position(vertex), near_faces, hint, q);
                    if nearest != Nearest::NONE {
                        self.vertices.push(vertex);
                        self.touched.push(vertex);
                        self.nearest[vertex as usize] = nearest;
                        hint = Some(nearest.face);
                    }
                }
            }
        }
        Ok(())
    }

    /// Finds the nearest of some faces within the margin of a point, if there is one.
    ///
    /// A `hint` within the margin is one of the faces: it shortens the search.
    fn find_nearest(
        &mut self,
        point: DVec3,
        faces: &[u32],
        hint: Option<u32>,
        q: &SurfaceTree,
    ) -> Nearest {
        let at = |face: u32| Nearest { distance: q.closest_on_face(point, face).distance, face };
        let hinted = hint.map(at).filter(|found| found.distance <= self.margin);
        let mut nearest = hinted.unwrap_or(Nearest::NONE);
        let mut reach = FaceBox::squared_reach(point, nearest.distance.min(self.margin));

        for &face in faces {
            // Most faces are farther by their box than the nearest so far, or the margin.
            if self.boxes.get(q, face).distance_squared(point) > reach {
                continue;
            }
            // Of equally near faces the first counts.
            let found = at(face);
            if found < nearest {
                nearest = found;
                reach = FaceBox::squared_reach(point, nearest.distance.min(self.margin));
            }
        }
        nearest
    }

    /// Projects the vertices of `p` that are inside `q` (ascending), and the candidates within
    /// the margin, to the surface of `q`.
    pub(crate) fn project(
        &mut self,
        p: &SurfaceTree,
        inside: &[u32],
        q: &SurfaceTree,
        workspace: &mut Workspace,
        out: &mut Vec<NearVertex>,
        progress: Progress<'_>,
    ) -> Result<(), Interrupted> {
        /// Vertices between two polls for interruption: some milliseconds, even where many faces are
        /// equally near.
        const POLL_INTERVAL: u32 = 16;

        // Candidates and inside vertices, ascending, each once.
        self.vertices.extend_from_slice(inside);
        self.vertices.sort_unstable();
        self.vertices.dedup();

        // Neighbors have near feet: each face that is found is the hint of the vertices around.
        out.clear();
        let mut inside = inside.iter().peekable();
        let mut polls = progress.every(POLL_INTERVAL);
        for i in 0..self.vertices.len() {
            polls.step()?;
            let vertex = self.vertices[i];
            let is_inside = inside.next_if_eq(&&vertex).is_some();
            let position = p.position(vertex);
            if let Some(found) = self.closest(vertex, position, is_inside, q, workspace) {
                self.spread_hint(p.surface(), vertex, found.face);
                out.push(NearVertex::new(vertex, position, is_inside, q, &found));
            }
        }
        Ok(())
    }

    /// Finds the closest point of one candidate: of an inside vertex however far, of others
    /// within the margin, up to the rounding of its distance.
    fn closest(
        &self,
        vertex: u32,
        position: DVec3,
        is_inside: bool,
        q: &SurfaceTree,
        workspace: &mut Workspace,
    ) -> Option<ClosestPoint> {
        let (nearest, margin) = (self.nearest[vertex as usize], self.margin);

        // With a margin all faces within it were offered; without one, only those that meet. A face
        // that is not offered may be nearer than one beyond the margin.
        let limit = if is_inside { margin } else { self.limit };
        if margin > 0.0 && nearest.distance <= limit {
            return Some(q.closest_on_face(position, nearest.face));
        }
        if margin > 0.0 && !is_inside {
            return None;
        }
        let max_distance = if is_inside { f64::INFINITY } else { limit };
        q.closest_point(position, max_distance, nearest.hint(), workspace)
    }

    /// Makes the face found for a vertex the hint of the adjacent ones that have none.
    fn spread_hint(&mut self, surface: &TriangleSurface, vertex: u32, found: u32) {
        for &face in surface.vertex_faces(vertex) {
            for corner in surface.faces()[face as usize] {
                let nearest = &mut self.nearest[corner as usize];
                if nearest.hint().is_none() {
                    nearest.face = found;
                    self.touched.push(corner);
                }
            }
        }
    }
}

impl NearVertex {
    fn new(
        vertex: u32,
        position: DVec3,
        is_inside: bool,
        q: &SurfaceTree,
        found: &ClosestPoint,
    ) -> Self {
        let foot = found.foot.point;
        let side = if is_inside { -1.0 } else { 1.0 };
        let offset = position - foot;

        // The offset has no direction where the vertex is on the surface: the face has.
        let face_normal = q.orientation() * triangle::normal(q.corners(found.face));
        let face_normal = face_normal.normalize_or(DVec3::Z);
        let scale = position.abs().max(foot.abs()).max_element();
        Self {
            vertex,
            gap: side * offset.length(),
            foot,
            face: found.face,
            barycentric: found.foot.barycentric,
            normal: direction_or(side * offset, scale, face_normal),
        }
    }
}

/// Returns the unit vector along `v`, or `fallback` where `v` is lost in the rounding of
/// coordinates of size `scale`.
fn direction_or(v: DVec3, scale: f64, fallback: DVec3) -> DVec3 {
    /// Multiple of the rounding of one coordinate below which the difference of two points has
    /// no reliable direction: the foot is computed with some ten roundings. Smaller would return
    /// noise as a normal; larger would replace good directions of tiny gaps by face normals.
    const ROUNDINGS: f64 = 64.0;
    let length = v.length();
    if length > ROUNDINGS * f64::EPSILON * scale { v / length } else { fallback }
}
