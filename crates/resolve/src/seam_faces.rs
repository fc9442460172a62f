//! Faces at seams, by which nothing leaves a body: behind them is the one it is tied to.

use glam::DVec3;
use kdop::Workspace;
use proximity::{ClosestPoint, NearVertex};
use scene::{BodyId, PairReport, Scene};
use surface::triangle;

use crate::seams::{Seams, place};
use crate::tissue::{Tissue, corners_at, fitted_tree};

/// Cosine of the angle between two faces at a seam, to one side of it and the other, above which they do not face
/// each other.
const MAX_FACING: f64 = -0.9;

/// Faces of which another body has the same corners, on the other side.
#[derive(Debug, Default)]
pub(crate) struct SeamFaces {
    /// The other body of each face, by bodies; empty for bodies without any.
    behind: Vec<Vec<Option<BodyId>>>,
}

impl SeamFaces {
    /// Finds the faces at seams, as the scene is. The trees of all bodies are up to date.
    pub(crate) fn new(scene: &Scene, seams: &Seams) -> Self {
        let mut behind = vec![Vec::new(); scene.bodies().len()];
        if seams.is_empty() {
            return Self::default();
        }
        for (id, own) in scene.ids().zip(&mut behind) {
            let body = scene.body(id);
            let first = body.particles().start;
            for (number, face) in (0..).zip(body.surface().faces()) {
                let points = face.map(|corner| seams.point_of(first + corner));
                let [Some(p), Some(q), Some(r)] = points else { continue };
                if let Some(other) = body_behind(scene, seams, id, number, [p, q, r]) {
                    own.resize(body.surface().faces().len(), None);
                    own[number as usize] = Some(other);
                }
            }
        }
        Self { behind }
    }

    /// Returns true if there is none.
    pub(crate) fn is_empty(&self) -> bool {
        self.behind.is_empty()
    }

    /// Returns true if a face of a body has a body behind it other than `entered`.
    pub(crate) fn closes(&self, body: BodyId, face: u32, entered: BodyId) -> bool {
        let own = self.behind.get(body.index());
        let behind = own.and_then(|own| own.get(face as usize)).copied().flatten();
        behind.is_some_and(|behind| behind != entered)
    }

    /// Returns true if all faces at a vertex of a body have bodies behind them other than the second.
    fn is_inner(&self, scene: &Scene, [own, other]: [BodyId; 2], vertex: u32) -> bool {
        if self.behind[own.index()].is_empty() {
            return false;
        }
        let mut faces = scene.body(own).surface().vertex_faces(vertex).iter();
        faces.all(|face| self.closes(own, *face, other))
    }

    /// Turns the outward normals of vertices at `x` that are of faces at seams to those of their other faces.
    pub(crate) fn turn_normals(&self, tissue: &Tissue, x: &[DVec3], normals: &mut [DVec3]) {
        let Some(behind) = self.behind.get(tissue.id.index()) else { return };
        for (face, _) in (0..).zip(behind).filter(|(_, behind)| behind.is_some()) {
            for vertex in tissue.corners(face) {
                let mut sum = DVec3::ZERO;
                for &face in tissue.surface.vertex_faces(vertex) {
                    if behind[face as usize].is_none() {
                        sum += triangle::normal(corners_at(tissue.corners(face), x));
                    }
                }
                if let Some(normal) = sum.try_normalize() {
                    normals[vertex as usize] = tissue.orientation() * normal;
                }
            }
        }
    }

    /// Takes the vertices of both bodies of a pair to the nearest faces by which they can leave the other one, and
    /// faces at seams out of those that cross. Vertices outside that are near a seam alone are left out.
    pub(crate) fn open(&self, scene: &Scene, report: &mut PairReport, margin: f64) {
        if self.is_empty() {
            return;
        }
        let [a, b] = report.pair.bodies();
        let workspace = &mut Workspace::default();
        for (pair, side) in [([a, b], &mut report.a_against_b), ([b, a], &mut report.b_against_a)] {
            let mut open = Vec::with_capacity(side.near.len());
            for near in std::mem::take(&mut side.near) {
                if self.is_inner(scene, pair, near.vertex) {
                    continue;
                }
                if self.closes(pair[1], near.face, pair[0]) {
                    open.extend(self.opened(scene, pair, &near, margin, workspace));
                } else {
                    open.push(near);
                }
            }
            side.near = open;
        }

        let is_open = |face_a, face_b| !self.closes(a, face_a, b) && !self.closes(b, face_b, a);
        report.crossing_faces.retain(|[face_a, face_b]| is_open(*face_a, *face_b));
        let near = report.a_against_b.near.iter().chain(&report.b_against_a.near);
        report.max_vertex_depth = near.fold(0.0, |depth: f64, near| depth.max(-near.gap));
    }

    /// Takes a vertex of one body to the nearest face of another by which it can leave that one; `None` where it is
    /// outside, and none is within the margin. A vertex in a body without such faces stays as it is.
    fn opened(
        &self,
        scene: &Scene,
        [own, other]: [BodyId; 2],
        near: &NearVertex,
        margin: f64,
        workspace: &mut Workspace,
    ) -> Option<NearVertex> {
        let is_inside = near.gap < 0.0;
        let position = scene.body(own).positions()[near.vertex as usize];
        let tree = fitted_tree(scene.body(other));
        let reach = if is_inside { f64::INFINITY } else { margin };
        let mut nearest: Option<ClosestPoint> = None;
        tree.tree().nearest(position, reach, workspace, |face, _| {
            if !self.closes(other, face, own) {
                let found = tree.closest_on_face(position, face);
                let is_nearer = nearest.is_none_or(|nearest| found.is_before(&nearest));
                if is_nearer && found.distance <= reach {
                    nearest = Some(found);
                }
            }
            nearest.map_or(reach, |nearest| nearest.distance)
        });

        let Some(ClosestPoint { face, foot, distance, .. }) = nearest else {
            return is_inside.then_some(*near);
        };
        let outward = if is_inside { foot.point - position } else { position - foot.point };
        let gap = if is_inside { -distance } else { distance };
        let normal = outward.try_normalize().unwrap_or(near.normal);
        let (foot, barycentric) = (foot.point, foot.barycentric);
        Some(NearVertex { vertex: near.vertex, gap, foot, face, barycentric, normal })
    }
}

/// Returns the body that has a face against a face of another, by the points of the seam at its corners.
fn body_behind(
    scene: &Scene,
    seams: &Seams,
    body: BodyId,
    face: u32,
    points: [usize; 3],
) -> Option<BodyId> {
    let vertices = |point: usize| seams.points()[point].iter().map(|p| place(scene, *p));
    let normal = triangle::unit_normal(scene.body(body).corners(face));
    let is_inside_out = scene.body(body).is_inside_out();
    for (number, vertex) in vertices(points[0]) {
        let other = &scene.bodies()[number];
        let has = |point: usize| vertices(point).any(|(body, _)| body == number);
        if number == body.index() || !has(points[1]) || !has(points[2]) {
            continue;
        }

        // Diagonals of quadrilaterals may differ: any face against this one, with all corners at the seam.
        let first = other.particles().start;
        for &face in other.surface().vertex_faces(vertex) {
            let corners = other.surface().faces()[face as usize];
            let is_at_seam = corners.iter().all(|v| seams.point_of(first + v).is_some());
            let facing = normal.dot(triangle::unit_normal(other.corners(face)));
            let facing = if is_inside_out == other.is_inside_out() { facing } else { -facing };
            if is_at_seam && facing < MAX_FACING {
                return scene.ids().nth(number);
            }
        }
    }
    None
}
