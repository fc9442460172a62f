//! Closest points of a closed surface, and the signed distance to it.

use glam::DVec3;
use kdop::{Axis, Dop18, Leaves, Tree, Workspace};
use surface::progress::{Interrupted, Progress};
use surface::{
    Meeting, Positions, Pseudonormals, TriangleFeature, TriangleSurface, closest_on_triangle,
    ray_crosses_triangle, triangle, triangles_meet,
};

use crate::{Ball, MedialError};

/// Closed surface with its normals and the tree over its faces.
pub(crate) struct SurfaceDistance<'a> {
    pub(crate) surface: &'a TriangleSurface,
    pub(crate) x: Positions<'a>,
    pub(crate) normals: Pseudonormals,
    tree: Tree,
    /// Ball around each face.
    balls: Vec<Ball>,
    /// Per vertex, true if one of its faces is so flat that its normal is rounding.
    is_at_needle: Vec<bool>,
}

/// Height of a face, relative to the size of the coordinates, up to which it is a needle: the
/// normal of a higher one is good to a millionth.
const NEEDLE_HEIGHT: f64 = 1e-10;

/// Closest point of a surface to another point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfaceFoot {
    pub(crate) point: DVec3,
    pub(crate) face: u32,
    pub(crate) feature: TriangleFeature,
    pub(crate) distance: f64,
}

impl<'a> SurfaceDistance<'a> {
    pub(crate) fn new(surface: &'a TriangleSurface, x: Positions<'a>) -> Result<Self, MedialError> {
        let tree = Tree::build(Leaves::Triangles(surface.faces()), x.as_slice())?;
        let balls = surface.faces().iter().map(|&face| ball_around(x.corners(face))).collect();
        let (normals, is_at_needle) = (Pseudonormals::new(surface, x), at_needles(surface, x));
        Ok(Self { surface, x, normals, tree, balls, is_at_needle })
    }

    /// Finds the closest point of the surface nearer than `max_distance`.
    pub(crate) fn nearest(
        &self,
        p: DVec3,
        max_distance: f64,
        workspace: &mut Workspace,
    ) -> Option<SurfaceFoot> {
        self.nearest_where(p, max_distance, workspace, |_| true)
    }

    /// Finds the closest point of the surface, faster where the face `guess` is near it.
    pub(crate) fn nearest_from(
        &self,
        p: DVec3,
        guess: u32,
        workspace: &mut Workspace,
    ) -> SurfaceFoot {
        let guessed = self.on_face(p, guess);
        self.nearest(p, guessed.distance, workspace).unwrap_or(guessed)
    }

    /// Finds the closest point nearer than `max_distance` among those of faces that are accepted.
    pub(crate) fn nearest_where(
        &self,
        p: DVec3,
        max_distance: f64,
        workspace: &mut Workspace,
        accept: impl Fn(&SurfaceFoot) -> bool,
    ) -> Option<SurfaceFoot> {
        // The limit falls with each nearer face, and culls the rest of the tree.
        let mut best: Option<SurfaceFoot> = None;
        let mut limit = max_distance;
        self.tree.nearest_unordered(p, max_distance, workspace, |face| {
            let found = self.on_face(p, face);
            // Of equally near faces, the first one counts.
            let is_nearer = match &best {
                Some(best) => (found.distance, face) < (best.distance, best.face),
                None => found.distance < max_distance,
            };
            if is_nearer && accept(&found) {
                limit = found.distance;
                best = Some(found);
            }
            limit
        });
        best
    }

    /// Collects every face that comes within `radius` of `p`, and some beyond.
    pub(crate) fn faces_within(
        &self,
        p: DVec3,
        radius: f64,
        workspace: &mut Workspace,
    ) -> Vec<u32> {
        let mut faces = Vec::new();
        if radius >= 0.0 {
            let around = Dop18::from_points(&[p]).inflated(radius);
            self.tree.query(&around, workspace, |face| faces.push(face));
        }
        faces
    }

    /// Returns true if a face is certainly farther from `p` than a distance, by the ball around it.
    #[inline]
    pub(crate) fn is_farther(&self, p: DVec3, face: u32, distance: f64) -> bool {
        let ball = &self.balls[face as usize];
        let reach = distance + ball.radius;
        p.distance_squared(ball.center) > reach * reach
    }

    /// Computes the closest point of one face.
    pub(crate) fn on_face(&self, p: DVec3, face: u32) -> SurfaceFoot {
        let foot = closest_on_triangle(p, self.corners(face));
        let distance = foot.point.distance(p);
        SurfaceFoot { point: foot.point, face, feature: foot.feature, distance }
    }

    /// Computes the distance to the surface, positive inside, from the closest point.
    pub(crate) fn depth(&self, p: DVec3, foot: &SurfaceFoot, workspace: &mut Workspace) -> f64 {
        // Beside needles, normals do not tell the side.
        let corners = self.surface.faces()[foot.face as usize];
        let is_outside = if corners.iter().any(|&vertex| self.is_at_needle[vertex as usize]) {
            !self.encloses(p, workspace)
        } else {
            let normal = self.normals.at(self.surface, foot.face, foot.feature);
            (p - foot.point).dot(normal) > 0.0
        };
        if is_outside { -foot.distance } else { foot.distance }
    }

    /// Returns true if the surface encloses a point, by the exact crossings of a ray along x.
    fn encloses(&self, p: DVec3, workspace: &mut Workspace) -> bool {
        let mut winding = 0;
        self.tree.ray(p, Axis::X, workspace, |face| {
            winding += ray_crosses_triangle(p, self.corners(face)).unwrap_or(0);
        });
        winding > 0
    }

    /// Checks that the surface does not cross itself.
    pub(crate) fn check_crossings(&self, progress: Progress<'_>) -> Result<(), MedialError> {
        /// Pairs of faces between two polls for interruption: a millisecond.
        const POLL_INTERVAL: u32 = 4096;

        let (mut crossings, mut polls) = (Vec::new(), progress.every(POLL_INTERVAL));
        self.tree.try_self_pairs(0.0, &mut Workspace::default(), |a, b| {
            polls.step()?;
            if triangles_meet(self.corners(a), self.corners(b)) == Meeting::Crossing {
                crossings.push([a, b]);
            }
            Ok::<_, Interrupted>(())
        })?;
        match crossings.iter().min() {
            Some(&[first, second]) => {
                Err(MedialError::SelfCrossing { count: crossings.len(), first, second })
            }
            None => Ok(()),
        }
    }

    /// Returns the corners of a face.
    #[inline]
    pub(crate) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.x.corners(self.surface.faces()[face as usize])
    }
}

/// Returns true if a face is so flat that its normal is rounding.
pub(crate) fn is_needle([a, b, c]: [DVec3; 3]) -> bool {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    let size = a.abs().max(b.abs()).max(c.abs()).max_element();
    triangle::normal([a, b, c]).length() <= NEEDLE_HEIGHT * size * longest
}

/// Finds the vertices of faces whose normals are rounding.
fn at_needles(surface: &TriangleSurface, x: Positions<'_>) -> Vec<bool> {
    let mut is_at_needle = vec![false; surface.vertex_count()];
    for &face in surface.faces() {
        if is_needle(x.corners(face)) {
            for vertex in face {
                is_at_needle[vertex as usize] = true;
            }
        }
    }
    is_at_needle
}

/// Returns a ball around a triangle, with room for rounding.
fn ball_around(corners: [DVec3; 3]) -> Ball {
    /// Share of the size of the coordinates by which the ball is larger.
    const ROUNDING: f64 = 1e-12;

    let center = corners.iter().sum::<DVec3>() / 3.0;
    let (mut radius, mut size) = (0.0_f64, 0.0_f64);
    for corner in corners {
        radius = radius.max(corner.distance(center));
        size = size.max(corner.abs().max_element());
    }
    Ball::new(center, radius + ROUNDING * size)
}
