//! Closest-point walking: feet on a surface, followed from face to face.

use glam::DVec3;
use surface::{
    ClosestOnTriangle, Positions, Pseudonormals, TriangleSurface, closest_on_triangle, triangle,
};

/// Distance, relative to the face's extent, below which the direction from
/// the foot is rounding and the surface's own normal is used. At 1e-9 the
/// direction is still good to 1e-6.
const AT_SURFACE: f64 = 1e-9;

/// Foot of a point on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SurfaceFoot {
    /// Face that holds the foot.
    pub face: u32,
    /// Barycentric coordinates of the foot.
    pub barycentric: [f64; 3],
    /// The foot itself, in the caller's length unit.
    pub point: DVec3,
    /// Unit normal there: along the line to the point, outward.
    pub normal: DVec3,
    /// Signed distance of the point, negative inside.
    pub height: f64,
    /// Number of faces visited.
    pub visited: u32,
}

/// Walks from `start` to the foot of `p`: always to the neighboring face that
/// comes closest, until none comes closer.
///
/// The foot is closest among all faces that share a corner with its own. A part of the
/// surface beyond a ridge, or one that lies against another, may be closer still, and a
/// walk that starts on the far side of a closed surface may stay there: only a detection
/// finds these. A point that moves by less than the surface's features is followed
/// correctly.
///
/// `None` where there is no face `start`, and where `p` is not finite.
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
    surface.faces().get(start as usize).filter(|_| p.is_finite())?;
    let mut best = FaceFoot::new(surface, x, start, p);
    let mut visited = 1;
    loop {
        // Steepest descent: the closest of all neighbors.
        let mut closer = best;
        for face in neighbors(surface, best.face) {
            visited += 1;
            let foot = FaceFoot::new(surface, x, face, p);
            if foot.distance_squared < closer.distance_squared {
                closer = foot;
            }
        }
        if closer.face == best.face {
            return Some(best.surface_foot(surface, x, p, visited));
        }
        best = closer;
    }
}

/// Closest point of one face.
#[derive(Clone, Copy)]
struct FaceFoot {
    face: u32,
    closest: ClosestOnTriangle,
    distance_squared: f64,
}

impl FaceFoot {
    fn new(surface: &TriangleSurface, x: Positions<'_>, face: u32, p: DVec3) -> Self {
        let closest = closest_on_triangle(p, x.corners(surface.faces()[face as usize]));
        Self { face, closest, distance_squared: closest.point.distance_squared(p) }
    }

    fn surface_foot(
        &self,
        surface: &TriangleSurface,
        x: Positions<'_>,
        p: DVec3,
        visited: u32,
    ) -> SurfaceFoot {
        let ClosestOnTriangle { point, barycentric, feature } = self.closest;
        let [a, b, c] = x.corners(surface.faces()[self.face as usize]);

        // Outward at the foot; the face's own normal where the faces around it cancel.
        let mut outward = Pseudonormals::of_feature(surface, x, self.face, feature);
        if outward == DVec3::ZERO {
            outward = triangle::normal([a, b, c]).normalize_or(DVec3::Z);
        }

        // At the surface the direction from the foot is rounding.
        let away = p - point;
        let side = if away.dot(outward) < 0.0 { -1.0 } else { 1.0 };
        let extent = (b - a).length().max((c - a).length());
        let is_off_surface = away.length() > AT_SURFACE * extent;
        let normal = if is_off_surface { side * away.normalize_or(outward) } else { outward };
        let (face, height) = (self.face, away.dot(normal));
        SurfaceFoot { face, barycentric, point, normal, height, visited }
    }
}

/// Returns the faces that share a corner with a face, each once. Those at the foot alone
/// would not suffice: under a ridge, each side has a foot inside a face.
fn neighbors(surface: &TriangleSurface, face: u32) -> impl Iterator<Item = u32> {
    let corners = surface.faces()[face as usize];
    (0..3).flat_map(move |k| {
        let is_new = move |other: &u32| {
            let others = surface.faces()[*other as usize];
            *other != face && !corners[..k].iter().any(|corner| others.contains(corner))
        };
        surface.vertex_faces(corners[k]).iter().copied().filter(is_new)
    })
}
