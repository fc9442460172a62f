//! Mutual closest pairs: points outside a body that can touch it next.
//!
//! A point need not be closest to the point that is closest to it. Vertices of a flat bone just
//! ahead of a sliding body are near its front edge: the normals of these contacts lie along the way, and
//! would stop the motion, though nothing is in the way. A contact outside counts where faces at
//! the point look at the body, and
//!
//! - either the point is an extremum of its surface toward the body: so is the tip of a spike,
//!   however sharp it is, and whatever it leans;
//! - or these faces look straight enough, and the closest point is on no ridge, whose normals
//!   lean over. So are the points of a body that is round or dented, of which one after the other
//!   touches as it deforms.
//!
//! Contacts that touch, or are inside, all count.
//!
//! Source: D. E. Johnson and E. Cohen, "Spatialized normal cone hierarchies", Symposium on
//! Interactive 3D Graphics 2001, for pairs of points that are mutually closest by the normals at
//! both.

use glam::DVec3;
use proximity::{NearVertex, SurfaceTree};
use surface::{Barycentric, Positions, TriangleSurface, triangle};

use crate::Body;

/// Cosine of the largest angle between the faces beside an edge that is no ridge: 30°. Below,
/// the facets of round bodies are ridges; above, contacts lean over by more.
pub(crate) const RIDGE_COSINE: f64 = 0.866;

/// Cosine between the normal of a face and the direction to a body that it looks at: 84°. Larger, the
/// vertices of a soft body that comes down beside its dent are found late; smaller, normals that lie
/// along a flat body count.
const MIN_FACING: f64 = 0.1;

/// Sine of the angle by which the surface around an extremum may rise: about 1°. A contact of a
/// flat vertex leans over by no more; rounding and noise of flat surfaces are smaller.
const FLAT_SINE: f64 = 0.02;

/// Weight of a corner up to which a point is on the border of its face: rounding of a point that is
/// carried.
pub(crate) const ON_BORDER: f64 = 1e-9;

/// Gaps up to which contacts act.
#[derive(Clone, Copy)]
pub(crate) struct ActingGaps {
    /// Of points that can touch next.
    pub(crate) margin: f64,
    /// Of all points: what corrections and rounding leave of a touch.
    pub(crate) touch: f64,
}

/// Surface in a state, without its tree.
#[derive(Clone, Copy)]
pub(crate) struct SurfaceState<'a> {
    pub(crate) surface: &'a TriangleSurface,
    pub(crate) x: Positions<'a>,
    /// True for bones, whose faces look outward; those of open surfaces have no outer side, and soft
    /// bodies may be folded over by a contact.
    has_sides: bool,
    /// Sign by which normals of faces point outward.
    orientation: f64,
}

/// Point of a surface that may touch another one: a vertex, or a point of an edge.
#[derive(Clone, Copy)]
pub(crate) struct OuterPoint<'a> {
    of: SurfaceState<'a>,
    /// Faces that hold it.
    faces: &'a [u32],
    p: DVec3,
}

impl<'a> SurfaceState<'a> {
    pub(crate) fn of_tree(tree: &'a SurfaceTree, is_rigid: bool) -> Self {
        let has_sides = is_rigid && tree.has_inside().is_ok();
        let orientation = if tree.is_inside_out() { -1.0 } else { 1.0 };
        Self { surface: tree.surface(), x: tree.positions(), has_sides, orientation }
    }

    pub(crate) fn of_body(body: &'a Body) -> Self {
        let has_sides = body.is_rigid() && body.has_inside().is_ok();
        let (surface, x) = (body.surface(), body.checked_positions());
        Self { surface, x, has_sides, orientation: body.orientation() }
    }

    /// Returns a vertex.
    pub(crate) fn vertex(self, vertex: u32) -> OuterPoint<'a> {
        OuterPoint { of: self, faces: self.surface.vertex_faces(vertex), p: self.x.at(vertex) }
    }

    /// Returns a point of an edge.
    pub(crate) fn point_of_edge(self, edge: u32, p: DVec3) -> OuterPoint<'a> {
        OuterPoint { of: self, faces: self.surface.edge_faces(edge), p }
    }

    /// Computes the outer unit normal of a face; zero where it has collapsed.
    pub(crate) fn normal(&self, face: u32) -> DVec3 {
        let corners = self.x.corners(self.surface.faces()[face as usize]);
        self.orientation * triangle::normal(corners).normalize_or_zero()
    }

    /// Computes the cosine between the outer normal of a face and a direction; a face that has no
    /// outer side for sure looks both ways.
    fn facing(&self, face: u32, direction: DVec3) -> f64 {
        let cosine = self.normal(face).dot(direction);
        if self.has_sides { cosine } else { cosine.abs() }
    }

    /// Returns true if a face that holds a point, by all of the corners `held`, leans from a normal
    /// there by more than that of a ridge.
    pub(crate) fn is_ridge(&self, held: &[u32], normal: DVec3) -> bool {
        // One face, two at an edge, all around a vertex.
        let Some(&first) = held.first() else { return false };
        for &face in self.surface.vertex_faces(first) {
            let corners = self.surface.faces()[face as usize];
            let holds_all = held.iter().all(|corner| corners.contains(corner));
            if holds_all && self.facing(face, normal) < RIDGE_COSINE {
                return true;
            }
        }
        false
    }

    /// Returns true if the point of a face with these weights is on a ridge.
    pub(crate) fn is_ridge_at(&self, face: u32, weights: Barycentric, normal: DVec3) -> bool {
        let (mut held, mut count) = ([0; 3], 0);
        for (corner, weight) in self.surface.faces()[face as usize].into_iter().zip(weights) {
            if weight > ON_BORDER {
                held[count] = corner;
                count += 1;
            }
        }
        self.is_ridge(&held[..count], normal)
    }
}

impl OuterPoint<'_> {
    /// Returns true if a point outside a body can touch it next, along `normal`, which points out
    /// of that body.
    pub(crate) fn may_touch(&self, normal: DVec3, is_on_ridge: impl FnOnce() -> bool) -> bool {
        let mut facing = f64::NEG_INFINITY;
        for &face in self.faces {
            facing = facing.max(self.of.facing(face, -normal));
        }
        // A sheet that stands on its edge, or faces that have collapsed, look aside: 0.
        facing >= 0.0 && (self.is_extremum(-normal) || (facing >= MIN_FACING && !is_on_ridge()))
    }

    /// Returns true if no corner of the faces around is farther in a direction.
    fn is_extremum(&self, direction: DVec3) -> bool {
        for &face in self.faces {
            for corner in self.of.x.corners(self.of.surface.faces()[face as usize]) {
                let way = corner - self.p;
                if way.dot(direction) > FLAT_SINE * way.length() {
                    return false;
                }
            }
        }
        true
    }
}

/// Returns true if a near vertex touches the other surface, or can touch it next.
pub(crate) fn may_touch(
    of: SurfaceState<'_>,
    on: SurfaceState<'_>,
    near: &NearVertex,
    gaps: ActingGaps,
) -> bool {
    let is_on_ridge = || on.is_ridge_at(near.face, near.barycentric, near.normal);
    near.gap <= gaps.touch || of.vertex(near.vertex).may_touch(near.normal, is_on_ridge)
}
