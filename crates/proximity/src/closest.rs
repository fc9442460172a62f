//! Closest points of a surface.

use glam::DVec3;
use kdop::Workspace;
use surface::{ClosestOnTriangle, TriangleFeature, closest_on_triangle};

use crate::SurfaceTree;

/// Steps of a descent to a near face. Fewer find faces that are farther; more take longer where the surface is
/// farther.
const MAX_STEPS: u32 = 8;

/// Closest point of a surface to a query point.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ClosestPoint {
    /// Face that holds the point; where several do, the one of the lowest number.
    pub face: u32,
    /// The point on that face.
    pub foot: ClosestOnTriangle,
    /// Distance to the query point.
    pub distance: f64,
}

impl ClosestPoint {
    /// Returns true if this point is nearer, or as near and on a face of a lower number.
    #[must_use]
    pub fn is_before(&self, other: &Self) -> bool {
        (self.distance, self.face) < (other.distance, other.face)
    }
}

impl SurfaceTree {
    /// Finds the closest point of the surface within `max_distance` (may be infinite).
    ///
    /// A `hint` is a face that is likely near: it makes the search faster, and never changes its
    /// result.
    #[must_use]
    pub fn closest_point(
        &self,
        point: DVec3,
        max_distance: f64,
        hint: Option<u32>,
        workspace: &mut Workspace,
    ) -> Option<ClosestPoint> {
        // A hint within the distance is a first result, and shortens the search.
        let (mut best, mut limit) = (None, max_distance);
        if let Some(face) = hint {
            let found = self.closest_on_face(point, face);
            if found.distance <= max_distance {
                (best, limit) = (Some(found), found.distance);
            }
        }

        // Faces at exactly the limit are visited as well: of equals the first face is taken.
        self.tree().nearest_unordered(point, limit, workspace, |face| {
            let found = self.closest_on_face(point, face);
            let is_before = match &best {
                Some(best) => found.is_before(best),
                None => found.distance <= max_distance,
            };
            if is_before {
                (best, limit) = (Some(found), found.distance);
            }
            limit
        });
        best
    }

    /// Finds a near point of the surface from neighbor to neighbor, beginning with a face that may be near. Its
    /// distance is an upper bound on that of the closest point, found in less time.
    ///
    /// # Panics
    ///
    /// When `from` is not below the surface's face count.
    #[must_use]
    pub fn near_point(&self, point: DVec3, from: u32) -> ClosestPoint {
        let faces = self.surface().faces();
        let mut found = self.closest_on_face(point, from);
        for _ in 0..MAX_STEPS {
            // Through the edge or the corner that holds the foot.
            let corners = faces[found.face as usize];
            let (vertex, second) = match found.foot.feature {
                TriangleFeature::Face => break,
                TriangleFeature::Edge(k) => (corners[k], Some(corners[(k + 1) % 3])),
                TriangleFeature::Corner(k) => (corners[k], None),
            };
            let before = found.face;
            for &next in self.surface().vertex_faces(vertex) {
                let is_beyond = next != before
                    && second.is_none_or(|second| faces[next as usize].contains(&second));
                if is_beyond {
                    let other = self.closest_on_face(point, next);
                    if other.distance < found.distance {
                        found = other;
                    }
                }
            }
            if found.face == before {
                break;
            }
        }
        found
    }

    /// Computes the closest point of one face.
    ///
    /// # Panics
    ///
    /// When `face` is not below the surface's face count.
    #[must_use]
    #[inline]
    pub fn closest_on_face(&self, point: DVec3, face: u32) -> ClosestPoint {
        let foot = closest_on_triangle(point, self.corners(face));
        ClosestPoint { face, foot, distance: foot.point.distance(point) }
    }
}
