//! Contact of a point or ball with a primitive of a medial surface.

use glam::DVec3;
use surface::{Contact, Stencil, triangle};

use crate::{Ball, Foot, FootRule, MedialSurface};

/// Point or ball in or near a medial surface, with the ball of a primitive that it is compared
/// with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointContact {
    /// The point.
    pub point: u32,
    /// The primitive.
    pub primitive: u32,
    /// The ball of the primitive, with its weights.
    pub foot: Foot,
    /// Unit vector from the center of that ball to the point.
    pub normal: DVec3,
    /// Sum of the radii of that ball and of the point.
    pub offset: f64,
    /// Height of the point over the center of the ball, less the offset.
    pub gap: f64,
}

/// Numbers of the first point and of the first ball among the caller's particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ParticleOffsets {
    /// Added to the numbers of points.
    pub first_point: u32,
    /// Added to the numbers of balls.
    pub first_ball: u32,
}

/// Point and primitive that may be in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct CandidatePair {
    /// The point.
    pub point: u32,
    /// The primitive.
    pub primitive: u32,
}

/// Point or ball whose contacts are searched for.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointQuery {
    pub(super) point: u32,
    pub(super) ball: Ball,
}

impl PointContact {
    /// Compares a point with a primitive, however far away.
    pub(super) fn new(
        query: &PointQuery,
        primitive: u32,
        medial: &MedialSurface,
        rule: FootRule,
    ) -> Self {
        let p = query.ball.center;
        let foot = medial.foot(p, primitive, rule);
        let balls = medial.primitive_balls(primitive);
        let normal = contact_normal(p, &foot, &balls);

        // The height over the foot is the distance.
        let height = (p - foot.ball.center).dot(normal);
        let offset = foot.ball.radius + query.ball.radius;
        Self { point: query.point, primitive, foot, normal, offset, gap: height - offset }
    }

    /// Builds the contact between the point and the balls of the primitive as particles.
    ///
    /// # Panics
    ///
    /// When `medial` has no such primitive.
    #[must_use]
    pub fn contact(&self, medial: &MedialSurface, particles: ParticleOffsets) -> Contact {
        let balls = medial.primitives()[self.primitive as usize];
        let face = balls.map(|ball| ball + particles.first_ball);
        let point = self.point + particles.first_point;
        Contact {
            stencil: Stencil::vertex_face(point, face, self.foot.weights),
            anchor: None,
            normal: self.normal,
            offset: self.offset,
            gap: self.gap,
            time: None,
        }
    }
}

/// Computes the unit normal of a contact: the direction from the foot to the point. Where they
/// coincide, every direction is as good: it is the normal of the sheet, or one across the cone.
pub(super) fn contact_normal(p: DVec3, foot: &Foot, balls: &[Ball; 3]) -> DVec3 {
    if let Some(normal) = foot.normal(p) {
        return normal;
    }
    let [a, b, c] = Ball::centers(balls);
    let sheet = triangle::unit_normal([a, b, c]);
    if sheet != DVec3::ZERO {
        sheet
    } else {
        (b - a).try_normalize().map_or(DVec3::Z, DVec3::any_orthonormal_vector)
    }
}
