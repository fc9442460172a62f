//! Struts: rays through a body by which its thickness is known and kept.

use glam::DVec3;
use kdop::{Dop18, Workspace};
use proximity::SurfaceTree;
use surface::triangle;

use crate::tissue::{Strut, Tissue};

/// Share of the way to the middle of its face that a point on an edge is moved, to be within the face. Far below, rays
/// from there run along other faces by rounding; above, they begin elsewhere.
const OFF_EDGES: f64 = 1e-3;

impl Strut {
    /// Returns the length at rest.
    pub(crate) fn length(&self) -> f64 {
        self.stiffness.sqrt().recip()
    }

    /// Interpolates a value of the vertices at the opposite point.
    pub(crate) fn interpolate(&self, value: impl Fn(u32) -> DVec3) -> DVec3 {
        self.corners.iter().zip(self.weights).map(|(&corner, weight)| weight * value(corner)).sum()
    }
}

impl Tissue {
    /// Returns the strut of a vertex, where [`Self::find_strut`] found one.
    pub(crate) fn strut(&self, vertex: u32) -> Option<&Strut> {
        self.struts[vertex as usize].as_ref()?.as_ref()
    }

    /// Finds the strut of a vertex, unless that was done before.
    pub(crate) fn find_strut(
        &mut self,
        tree: &SurfaceTree,
        vertex: u32,
        max_length: f64,
        workspace: &mut Workspace,
    ) {
        if self.struts[vertex as usize].is_some() {
            return;
        }
        let inward = -self.rest_normals[vertex as usize];
        let from = tree.position(vertex);
        // A ray from inside another part of the body would leave by that, and tie both together.
        let is_astray = self.is_inside_itself.get(vertex as usize).is_some_and(|inside| *inside);
        let own = |face| self.has_corner(face, vertex);
        let strut = match is_astray {
            true => None,
            false => self.find_exit(tree, from, own, inward, max_length, workspace),
        };
        self.struts[vertex as usize] = Some(strut);
    }

    /// Computes how thick the body at rest is under a vertex; `None` where it is open.
    pub(crate) fn thickness_at(
        &self,
        at_rest: &SurfaceTree,
        vertex: u32,
        workspace: &mut Workspace,
    ) -> Option<f64> {
        let inward = -self.rest_normals[vertex as usize];
        let (from, far) = (at_rest.position(vertex), f64::MAX.sqrt());
        let own = |face| self.has_corner(face, vertex);
        Some(self.find_exit(at_rest, from, own, inward, far, workspace)?.length())
    }

    /// Computes how thick the body at rest is under a point of a face, given by the weights of its corners,
    /// across that face; `None` where it is open.
    pub(crate) fn thickness_across(
        &self,
        at_rest: &SurfaceTree,
        face: u32,
        weights: [f64; 3],
        workspace: &mut Workspace,
    ) -> Option<f64> {
        // A ray from a corner would run along the faces beside it.
        let corners = at_rest.corners(face);
        let mut from = DVec3::ZERO;
        for (corner, weight) in corners.into_iter().zip(weights) {
            from += (weight + OFF_EDGES * (1.0 / 3.0 - weight)) * corner;
        }
        let inward = -self.orientation() * triangle::unit_normal(corners);
        let far = f64::MAX.sqrt();
        Some(self.find_exit(at_rest, from, |_| false, inward, far, workspace)?.length())
    }

    /// Returns true if a vertex is a corner of a face.
    fn has_corner(&self, face: u32, vertex: u32) -> bool {
        self.corners(face).contains(&vertex)
    }

    /// Finds the nearest face at which a ray leaves the body within `max_length`, of those that are not `closed`;
    /// `tree` is that of the body.
    pub(crate) fn find_exit(
        &self,
        tree: &SurfaceTree,
        origin: DVec3,
        closed: impl Fn(u32) -> bool,
        direction: DVec3,
        max_length: f64,
        workspace: &mut Workspace,
    ) -> Option<Strut> {
        // Of the faces that the ray may pass, the nearest one.
        let bounds = Dop18::from_points(&[origin, origin + max_length * direction]);
        let mut nearest = (max_length, u32::MAX);
        let mut strut = None;
        tree.tree().query(&bounds, workspace, |face| {
            let corners = tree.surface().faces()[face as usize];
            let exit = exit(origin, direction, self.orientation(), tree.corners(face));
            let Some((distance, weights)) = exit else { return };
            if (distance, face) < nearest && !closed(face) {
                nearest = (distance, face);
                strut = Some(Strut { corners, weights, stiffness: (distance * distance).recip() });
            }
        });
        strut
    }
}

/// Computes the distance at which a ray passes a triangle from behind, and the weights of its
/// corners there. The triangle's normal points outward by the sign of `orientation`.
fn exit(
    origin: DVec3,
    direction: DVec3,
    orientation: f64,
    [a, b, c]: [DVec3; 3],
) -> Option<(f64, [f64; 3])> {
    let (ab, ac, to) = (b - a, c - a, origin - a);
    let normal = ab.cross(ac);
    let slope = direction.dot(normal);
    if orientation * slope <= 0.0 {
        return None;
    }

    // Barycentric coordinates by Cramer's rule, which also gives the distance.
    let v = to.cross(ac).dot(direction) / slope;
    let w = ab.cross(to).dot(direction) / slope;
    let distance = -to.dot(normal) / slope;
    let is_hit = distance > 0.0 && v >= 0.0 && w >= 0.0 && v + w <= 1.0;
    is_hit.then_some((distance, [1.0 - v - w, v, w]))
}
