//! Contacts of bodies with themselves: parts of one surface that are inside each other come apart as
//! two bodies do.
//!
//! A vertex is inside another part of its body where the winding number is positive just in front of
//! its own faces. It leaves by the closest face whose normal opposes its own, which is right where
//! parts are in each other by less than they are thick. Edges that cross without a vertex inside come
//! apart as those of two bodies.

use glam::DVec3;
use kdop::{Axis, Workspace};
use proximity::{ClosestPoint, ContactSurface, NearVertex, SurfaceTree, contact};
use scene::Body;
use surface::progress::{Interrupted, Progress};
use surface::{Contact, ray_crosses_triangle, triangle};

use crate::edge_contacts::self_edge_contacts;
use crate::tissue::Tissue;

/// Distance in front of a vertex at which its winding number is computed \[mean edge\]. Below, own
/// faces count by rounding; above, parts that are as near count as crossing.
const FRONT: f64 = 1e-3;

/// Surface that is compared with itself.
pub(crate) struct SelfSurface<'a> {
    tissue: &'a Tissue,
    tree: &'a SurfaceTree,
    /// Outward unit normals, |V|.
    normals: Vec<DVec3>,
    /// 1 where faces are oriented outward, −1 where inward.
    orientation: f64,
}

impl<'a> SelfSurface<'a> {
    pub(crate) fn new(tissue: &'a Tissue, tree: &'a SurfaceTree) -> Self {
        let normals = tissue.outward_normals(tree.positions().as_slice());
        Self { tissue, tree, normals, orientation: tissue.orientation() }
    }

    /// Makes the contacts of a body with itself within a margin: of vertices, then of edges.
    pub(crate) fn contacts(
        &self,
        body: &Body,
        margin: f64,
        progress: Progress<'_>,
    ) -> Result<Vec<Contact>, Interrupted> {
        let (is_inside, mut contacts) = (self.inside(), Vec::new());
        self.add_contacts(&body.contact_surface(), &is_inside, margin, &mut contacts);
        let crossing = self.tree.self_crossings(&mut Workspace::default(), progress)?;
        contacts.extend(self_edge_contacts(body, is_inside, &crossing));
        Ok(contacts)
    }

    /// Marks the vertices that are inside another part of the body.
    pub(crate) fn inside(&self) -> Vec<bool> {
        let workspace = &mut Workspace::default();
        let vertices = (0..).take(self.normals.len());
        vertices.map(|vertex| self.is_inside(vertex, workspace)).collect()
    }

    /// Adds the contacts of vertices that are inside another part of the body, or in front of one
    /// by up to a margin.
    fn add_contacts(
        &self,
        own: &ContactSurface<'_>,
        is_inside: &[bool],
        margin: f64,
        contacts: &mut Vec<Contact>,
    ) {
        let workspace = &mut Workspace::default();
        for (vertex, &is_inside) in (0..).zip(is_inside) {
            let reach = if is_inside { f64::INFINITY } else { margin };
            if let Some(near) = self.opposite(vertex, is_inside, reach, workspace) {
                contacts.push(contact(own, own, &near));
            }
        }
    }

    fn is_inside(&self, vertex: u32, workspace: &mut Workspace) -> bool {
        let step = FRONT * self.tissue.mean_edge * self.normals[vertex as usize];
        let front = self.tree.position(vertex) + step;
        let mut winding_number = 0;
        self.tree.tree().ray(front, Axis::X, workspace, |face| {
            winding_number += ray_crosses_triangle(front, self.tree.corners(face)).unwrap_or(0);
        });
        self.orientation * f64::from(winding_number) > 0.0
    }

    /// Finds the closest face within reach whose normal opposes that of a vertex, and that the
    /// vertex is behind if it is inside, else in front of.
    fn opposite(
        &self,
        vertex: u32,
        is_inside: bool,
        reach: f64,
        workspace: &mut Workspace,
    ) -> Option<NearVertex> {
        let (x, side) = (self.tree.position(vertex), -self.normals[vertex as usize]);
        let mut nearest: Option<ClosestPoint> = None;
        self.tree.tree().nearest(x, reach, workspace, |face, _| {
            let found = self.tree.closest_on_face(x, face);
            let is_nearer = match &nearest {
                Some(nearest) => found.is_before(nearest),
                None => found.distance <= reach,
            };
            let is_behind = (x - found.foot.point).dot(self.face_normal(face)) < 0.0;
            let is_other = !self.tissue.corners(face).contains(&vertex);
            let is_opposite = is_other && is_behind == is_inside;
            if is_nearer && is_opposite && self.tissue.agrees(self.face_normal(face), side) {
                nearest = Some(found);
            }
            nearest.map_or(reach, |nearest| nearest.distance)
        });

        // The way to the face or from it, or its normal where the way is along it.
        let ClosestPoint { face, foot, .. } = nearest?;
        let way = if is_inside { foot.point - x } else { x - foot.point }.normalize_or_zero();
        let face_normal = self.face_normal(face);
        let normal = if self.tissue.agrees(way, face_normal) { way } else { face_normal };
        let gap = (x - foot.point).dot(normal);
        let barycentric = foot.barycentric;
        Some(NearVertex { vertex, gap, foot: foot.point, face, barycentric, normal })
    }

    fn face_normal(&self, face: u32) -> DVec3 {
        self.orientation * triangle::unit_normal(self.tree.corners(face))
    }
}
