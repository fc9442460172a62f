//! Closest points of a closed surface, and the signed distance to it.

use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use surface::{
    Meeting, Positions, Pseudonormals, TriangleFeature, TriangleSurface, closest_on_triangle,
    triangles_meet,
};

use crate::MedialError;

/// A closed surface with what its distance needs.
pub(crate) struct SurfaceDistance<'a> {
    pub(crate) surface: &'a TriangleSurface,
    pub(crate) x: Positions<'a>,
    pub(crate) normals: Pseudonormals,
    tree: Tree,
}

/// The point of a surface nearest to another.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    pub(crate) point: DVec3,
    pub(crate) face: u32,
    pub(crate) feature: TriangleFeature,
    pub(crate) distance: f64,
}

impl<'a> SurfaceDistance<'a> {
    pub(crate) fn new(surface: &'a TriangleSurface, x: Positions<'a>) -> Result<Self, MedialError> {
        let tree = Tree::build(Leaves::Triangles(surface.faces()), x.as_slice())?;
        Ok(Self { surface, x, normals: Pseudonormals::new(surface, x), tree })
    }

    /// The nearest point of the surface, if one is nearer than `within`.
    pub(crate) fn nearest(
        &self,
        p: DVec3,
        within: f64,
        workspace: &mut Workspace,
    ) -> Option<Nearest> {
        self.nearest_where(p, within, workspace, |_| true)
    }

    /// As [`Self::nearest`], among the faces whose closest point is accepted.
    pub(crate) fn nearest_where(
        &self,
        p: DVec3,
        within: f64,
        workspace: &mut Workspace,
        accept: impl Fn(&Nearest) -> bool,
    ) -> Option<Nearest> {
        let mut best: Option<Nearest> = None;
        let mut limit = within;
        self.tree.nearest(p, within, workspace, |face, _| {
            let foot = closest_on_triangle(p, self.corners(face));
            let distance = foot.point.distance(p);
            if distance < limit {
                let found = Nearest { point: foot.point, face, feature: foot.feature, distance };
                if accept(&found) {
                    limit = distance;
                    best = Some(found);
                }
            }
            limit
        });
        best
    }

    /// Depth of `p`, and the faces not more than `beyond` farther than the
    /// nearest: for each the unit vector from it to `p`, and its distance.
    pub(crate) fn depth_and_facing(
        &self,
        p: DVec3,
        beyond: f64,
        workspace: &mut Workspace,
    ) -> (f64, Vec<(DVec3, f64)>) {
        let mut best: Option<Nearest> = None;
        let mut limit = f64::INFINITY;
        let mut facing = Vec::new();
        self.tree.nearest(p, limit, workspace, |face, _| {
            let foot = closest_on_triangle(p, self.corners(face));
            let distance = foot.point.distance(p);
            if best.is_none_or(|best| distance < best.distance) {
                best = Some(Nearest { point: foot.point, face, feature: foot.feature, distance });
                limit = distance + beyond;
            }
            if distance <= limit {
                facing.push(((p - foot.point).normalize_or_zero(), distance));
            }
            limit
        });
        facing.retain(|&(_, distance)| distance <= limit);
        let depth = best.map_or(f64::NEG_INFINITY, |nearest| self.depth_of(p, &nearest).0);
        (depth, facing)
    }

    /// Distance to the surface, positive inside, with its gradient (unit, or
    /// zero on the surface itself), from the nearest point.
    pub(crate) fn depth_of(&self, p: DVec3, nearest: &Nearest) -> (f64, DVec3) {
        let inward = p - nearest.point;
        let normal = self.normals.at(self.surface, nearest.face, nearest.feature);
        let sign = if inward.dot(normal) > 0.0 { -1.0 } else { 1.0 };
        let gradient = inward.try_normalize().unwrap_or(DVec3::ZERO);
        (sign * nearest.distance, sign * gradient)
    }

    /// Refuses a surface that crosses itself.
    pub(crate) fn check_crossings(&self) -> Result<(), MedialError> {
        let mut crossings = Vec::new();
        self.tree.self_pairs(0.0, &mut Workspace::default(), |a, b| {
            if triangles_meet(self.corners(a), self.corners(b)) == Meeting::Crossing {
                crossings.push((a, b));
            }
        });
        match crossings.iter().min() {
            Some(&(first, second)) => {
                Err(MedialError::SelfCrossing { count: crossings.len(), first, second })
            }
            None => Ok(()),
        }
    }

    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.x.corners(self.surface.faces()[face as usize])
    }
}
