//! Faces near the primitives of a medial surface, from which closest points are found faster.

use glam::DVec3;
use surface::{TriangleSurface, triangle};

use crate::{Ball, Links, MedialSurface};

/// For each primitive and each side of its sheet, a face of the surface that is near.
#[derive(Clone, Debug)]
pub(super) struct FaceHints(Vec<[Option<u32>; 2]>);

impl FaceHints {
    pub(super) fn new(medial: &MedialSurface, surface: &TriangleSurface, links: &Links) -> Self {
        // A face of some vertex that touches the primitive on that side.
        let mut hints = vec![[None; 2]; medial.primitives().len()];
        for (vertex, link) in (0_u32..).zip(links.links()) {
            if let Some(&face) = surface.vertex_faces(vertex).first() {
                hints[link.primitive as usize][usize::from(link.side > 0)] = Some(face);
            }
        }

        // The other side is near a side that no vertex touches.
        for [a, b] in &mut hints {
            (*a, *b) = (a.or(*b), b.or(*a));
        }
        Self(hints)
    }

    /// Returns a face near the border of a primitive in the direction of `normal`.
    pub(super) fn face(
        &self,
        medial: &MedialSurface,
        primitive: u32,
        normal: DVec3,
    ) -> Option<u32> {
        let centers = Ball::centers(&medial.primitive_balls(primitive));
        let side = triangle::normal(centers).dot(normal) > 0.0;
        self.0[primitive as usize][usize::from(side)]
    }
}
