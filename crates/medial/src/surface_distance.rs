//! Closest points of a closed surface, and the signed distance to it.

use glam::DVec3;
use kdop::{Dop18, Leaves, Tree, Workspace};
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

    /// The nearest point of the surface, sooner where `guess` is a face near it.
    pub(crate) fn nearest_from(
        &self,
        p: DVec3,
        guess: u32,
        workspace: &mut Workspace,
    ) -> Option<Nearest> {
        let guessed = self.on_face(p, guess);
        Some(self.nearest(p, guessed.distance, workspace).unwrap_or(guessed))
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
            let found = self.on_face(p, face);
            if found.distance < limit && accept(&found) {
                limit = found.distance;
                best = Some(found);
            }
            limit
        });
        best
    }

    /// Visits every face that comes within `radius` of `p`, and some beyond.
    pub(crate) fn near(
        &self,
        p: DVec3,
        radius: f64,
        workspace: &mut Workspace,
        visit: impl FnMut(u32),
    ) {
        if radius >= 0.0 {
            self.tree.query(&Dop18::from_points(&[p]).inflated(radius), workspace, visit);
        }
    }

    /// The nearest point of one face.
    pub(crate) fn on_face(&self, p: DVec3, face: u32) -> Nearest {
        let foot = closest_on_triangle(p, self.corners(face));
        let distance = foot.point.distance(p);
        Nearest { point: foot.point, face, feature: foot.feature, distance }
    }

    /// Distance to the surface, positive inside, from the nearest point.
    pub(crate) fn depth_of(&self, p: DVec3, nearest: &Nearest) -> f64 {
        let normal = self.normals.at(self.surface, nearest.face, nearest.feature);
        let sign = if (p - nearest.point).dot(normal) > 0.0 { -1.0 } else { 1.0 };
        sign * nearest.distance
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
