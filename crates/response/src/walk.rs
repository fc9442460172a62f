//! Feet on a surface, found from where they were by walking over its faces.

use glam::DVec3;
use surface::{Positions, TriangleFeature, TriangleSurface, closest_on_triangle};

/// Distance, as a share of the face's extent, below which the direction from
/// the foot is rounding and the surface's own normal is taken. At 1e-9 the
/// direction is still good to 1e-6.
const AT_SURFACE: f64 = 1e-9;

/// Where a point stands over a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceFoot {
    /// Face that holds the foot.
    pub face: u32,
    /// The foot in weights of the face's corners.
    pub barycentric: [f64; 3],
    /// The foot itself, in the caller's length unit.
    pub point: DVec3,
    /// Unit normal there: along the line to the point, outward.
    pub normal: DVec3,
    /// Signed distance of the point, negative inside.
    pub height: f64,
    /// Faces looked at.
    pub visited: u32,
}

/// Walks from `start` to the foot of `p`: always to the neighboring face that
/// comes closest, until none comes closer.
///
/// The foot is closest among all faces that share a corner with its own. A part of the surface beyond a ridge, or one that lies against another,
/// may be closer still, and a walk that starts on the far side of a closed
/// surface may stay there: only a detection finds these. A point that moves by
/// less than the surface's features is followed right.
///
/// `None` where there is no face `start`.
///
/// ```
/// use glam::DVec3;
/// use response::walk_to_foot;
/// use surface::TriangleSurface;
///
/// let x = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)];
/// let square = TriangleSurface::new(4, vec![[0, 1, 2], [1, 3, 2]])?;
/// let p = DVec3::new(0.9, 0.8, 0.5);
/// let foot = walk_to_foot(&square, square.positions(&x)?, 0, p).expect("face 0 exists");
/// assert_eq!((foot.face, foot.height), (1, 0.5));
/// # Ok::<(), surface::SurfaceError>(())
/// ```
#[must_use]
pub fn walk_to_foot(
    surface: &TriangleSurface,
    x: Positions<'_>,
    start: u32,
    p: DVec3,
) -> Option<SurfaceFoot> {
    surface.faces().get(start as usize)?;
    let look = |face: u32| Seen::new(surface, x, face, p);
    let mut best = look(start);
    let mut visited = 1;
    loop {
        let mut closer = best;
        best.for_each_neighbor(surface, |face| {
            visited += 1;
            let seen = look(face);
            if seen.distance_squared < closer.distance_squared {
                closer = seen;
            }
        });
        if closer.face == best.face {
            return Some(best.foot(surface, x, p, visited));
        }
        best = closer;
    }
}

/// The closest point on one face.
#[derive(Clone, Copy)]
struct Seen {
    face: u32,
    barycentric: [f64; 3],
    point: DVec3,
    feature: TriangleFeature,
    distance_squared: f64,
}

impl Seen {
    fn new(surface: &TriangleSurface, x: Positions<'_>, face: u32, p: DVec3) -> Self {
        let closest = closest_on_triangle(p, x.corners(surface.faces()[face as usize]));
        Self {
            face,
            barycentric: closest.barycentric,
            point: closest.point,
            feature: closest.feature,
            distance_squared: closest.point.distance_squared(p),
        }
    }

    /// Faces that share a corner with this one. Those at the foot alone would
    /// not do: under a ridge, each side has a foot inside a face.
    fn for_each_neighbor(&self, surface: &TriangleSurface, mut visit: impl FnMut(u32)) {
        let faces = surface.faces();
        let corners = faces[self.face as usize];
        for (k, &corner) in corners.iter().enumerate() {
            for &face in surface.vertex_faces(corner) {
                let shared_before = corners[..k].iter().any(|c| faces[face as usize].contains(c));
                if face != self.face && !shared_before {
                    visit(face);
                }
            }
        }
    }

    fn foot(
        &self,
        surface: &TriangleSurface,
        x: Positions<'_>,
        p: DVec3,
        visited: u32,
    ) -> SurfaceFoot {
        let outward = self.pseudonormal(surface, x);
        let away = p - self.point;
        let side = if away.dot(outward) < 0.0 { -1.0 } else { 1.0 };
        let [a, b, c] = x.corners(surface.faces()[self.face as usize]);
        let extent = (b - a).length().max((c - a).length());
        let normal = if away.length() > AT_SURFACE * extent {
            side * away.normalize_or(outward)
        } else {
            outward
        };
        SurfaceFoot {
            face: self.face,
            barycentric: self.barycentric,
            point: self.point,
            normal,
            height: away.dot(normal),
            visited,
        }
    }

    /// Unit normal that tells inside from outside at the foot. Source: J. A.
    /// Bærentzen and H. Aanæs, "Signed distance computation using the angle
    /// weighted pseudonormal", IEEE TVCG 11(3), 2005.
    fn pseudonormal(&self, surface: &TriangleSurface, x: Positions<'_>) -> DVec3 {
        let normal = |face: u32| {
            let [a, b, c] = x.corners(surface.faces()[face as usize]);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let sum: DVec3 = match self.feature {
            TriangleFeature::Face => normal(self.face),
            TriangleFeature::Edge(k) => {
                edge_faces(surface, self.face, k).iter().map(|&face| normal(face)).sum()
            }
            TriangleFeature::Corner(k) => {
                let vertex = surface.faces()[self.face as usize][k];
                let faces = surface.vertex_faces(vertex).iter();
                faces.map(|&face| angle_at(surface, x, face, vertex) * normal(face)).sum()
            }
        };
        sum.try_normalize().or_else(|| normal(self.face).try_normalize()).unwrap_or(DVec3::Z)
    }
}

fn edge_faces(surface: &TriangleSurface, face: u32, k: usize) -> &[u32] {
    match surface.face_edges()[face as usize][k] {
        surface::NO_EDGE => &[],
        edge => surface.edge_faces(edge),
    }
}

fn angle_at(surface: &TriangleSurface, x: Positions<'_>, face: u32, vertex: u32) -> f64 {
    let corners = surface.faces()[face as usize];
    let k = corners.iter().position(|&corner| corner == vertex).unwrap_or(0);
    let at = |j: usize| x.at(corners[(k + j) % 3]);
    let (u, v) = (at(1) - at(0), at(2) - at(0));
    u.cross(v).length().atan2(u.dot(v))
}
