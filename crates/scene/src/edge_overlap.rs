//! Overlaps by edges alone: regions in which no vertex of either body is inside the other.

use glam::DVec3;
use kdop::Workspace;
use overlap::Depth;
use proximity::{ContactSurface, SurfaceTree};
use surface::{Barycentric, Contact, ContactSide, Term, closest_on_triangle};

use crate::depth_bracket::DepthBracket;
use crate::{BodyId, PairId};

/// Deepest point of a region in which no vertex is inside.
///
/// `foot.at = point.at + depth.lower * normal`, up to rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct EdgeOverlap {
    /// Place of the region in the list of [measured](crate::PairOverlap::measures) ones.
    pub region: u32,
    /// The body that is deeper inside the other.
    pub body: BodyId,
    /// Its deepest point.
    pub point: FacePoint,
    /// The point of the other body's surface nearest to it.
    pub foot: FacePoint,
    /// Unit normal; points out of the other body.
    pub normal: DVec3,
    /// Depth of the region.
    pub depth: DepthBracket,
}

/// Point of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FacePoint {
    /// Position.
    pub at: DVec3,
    /// The face.
    pub face: u32,
    /// The position in weights of the face's corners.
    pub barycentric: Barycentric,
}

impl EdgeOverlap {
    /// Takes the deeper side of a region; `None` where both are 0 deep.
    pub(crate) fn new(
        region: u32,
        pair: PairId,
        bodies: [&SurfaceTree; 2],
        depths: [Option<Depth>; 2],
    ) -> Option<Self> {
        let [a, b] = depths.map(attained_depth);
        let side = usize::from(b > a);
        let Depth { lower, upper, point, face, .. } = depths[side]?;

        let (own, other) = (bodies[side], bodies[1 - side]);
        let found = other.closest_point(point, f64::INFINITY, None, &mut Workspace::default())?;
        let normal = (found.foot.point - point).try_normalize()?;
        let barycentric = closest_on_triangle(point, own.corners(face)).barycentric;
        Some(Self {
            region,
            body: pair.bodies()[side],
            point: FacePoint { at: point, face, barycentric },
            foot: FacePoint {
                at: found.foot.point,
                face: found.face,
                barycentric: found.foot.barycentric,
            },
            normal,
            depth: DepthBracket { lower, upper },
        })
    }

    /// Makes the contact of the deepest point with its foot; `own` holds the point.
    ///
    /// A rigid side is the anchor; of two, the one that holds the foot.
    pub(crate) fn contact(&self, own: &ContactSurface<'_>, other: &ContactSurface<'_>) -> Contact {
        let (of_point, of_foot) = (self.point.terms(own), self.foot.terms(other));
        let is_anchor = own.is_rigid && !other.is_rigid;
        let point = self.point.contact_side(is_anchor, &of_point);
        let foot = self.foot.contact_side(other.is_rigid, &of_foot);
        let contact = Contact::between(point, foot, self.normal, -self.depth.lower);

        let position = |particle| self.position_of(particle, own, other);
        let rounding = 1e-12 * self.size(own, other);
        debug_assert!(contact.identity_error(position) <= rounding, "{contact:?}");
        contact
    }

    /// Returns the position of a particle of one of both faces.
    fn position_of(
        &self,
        particle: u32,
        own: &ContactSurface<'_>,
        other: &ContactSurface<'_>,
    ) -> DVec3 {
        for (surface, face) in [(own, self.point.face), (other, self.foot.face)] {
            for corner in surface.surface.faces()[face as usize] {
                if surface.particles.particle(corner) == particle {
                    return surface.positions.at(corner);
                }
            }
        }
        DVec3::NAN
    }

    /// Returns the largest coordinate of both faces.
    fn size(&self, own: &ContactSurface<'_>, other: &ContactSurface<'_>) -> f64 {
        let mut size: f64 = 0.0;
        for (surface, face) in [(own, self.point.face), (other, self.foot.face)] {
            for corner in surface.positions.corners(surface.surface.faces()[face as usize]) {
                size = size.max(corner.abs().max_element());
            }
        }
        size
    }
}

impl FacePoint {
    /// Returns the particles of the face, without those of weight 0.
    fn terms(&self, surface: &ContactSurface<'_>) -> Vec<Term> {
        let corners = surface.surface.faces()[self.face as usize];
        let mut terms = Vec::new();
        for (corner, weight) in corners.into_iter().zip(self.barycentric) {
            if weight != 0.0 {
                terms.push(Term { particle: surface.particles.particle(corner), weight });
            }
        }
        terms
    }

    fn contact_side<'t>(&self, is_anchor: bool, terms: &'t [Term]) -> ContactSide<'t> {
        if is_anchor { ContactSide::at_rest(self.at) } else { ContactSide::Particles(terms) }
    }
}

/// Returns the depth that a side attains; 0 for a side that is not inside the other.
fn attained_depth(depth: Option<Depth>) -> f64 {
    depth.map_or(0.0, |depth| depth.lower)
}
