//! Relative state of one contact: the motion of P̄ relative to P, and the depth in the
//! proximity region.
//!
//! Source: B. Gilles, PhD thesis, 2007, section 4.7.2, "Collision response".
//! Names there and here: P_c, V_c, A_c are [`RelativeMotion`]'s fields; g is
//! [`kept`](RelativeState::kept), d_max [`proximity`](Margins::proximity),
//! λ [`proximity_factor`](RelativeState::proximity_factor).

use glam::DVec3;
use surface::Contact;

use crate::{ResponseError, check};

/// Distances that a response keeps, in the caller's length unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Margins {
    clearance: f64,
    proximity: f64,
}

#[cfg(feature = "serde")]
check::deserialize_checked!(
    Margins { clearance: f64, proximity: f64 },
    Self::new(clearance, proximity)
);

impl Margins {
    /// Returns margins of `clearance >= 0`, kept free beyond the contact's own offset, and
    /// `proximity > 0`, the source's d_max: the distance outside of the clearance at which
    /// the response sets in.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] outside these ranges.
    pub fn new(clearance: f64, proximity: f64) -> Result<Self, ResponseError> {
        Ok(Self {
            clearance: check::not_negative("clearance", clearance)?,
            proximity: check::positive("proximity distance", proximity)?,
        })
    }

    /// Returns the distance kept free beyond the contact's own offset.
    #[must_use]
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// Returns the proximity distance, the source's d_max.
    #[must_use]
    pub fn proximity(&self) -> f64 {
        self.proximity
    }

    /// Computes λ at a depth, in `0.0..=1.0`: 1 in collision, falling to 0 at the rim of
    /// the proximity region.
    #[inline]
    pub(crate) fn proximity_factor(&self, depth: f64) -> f64 {
        (1.0 + depth / self.proximity).clamp(0.0, 1.0)
    }
}

/// Relative motion P_c, V_c and A_c: position, velocity and acceleration of P̄ minus those
/// of P.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RelativeMotion {
    /// P_c = P̄ − P.
    pub position: DVec3,
    /// V_c.
    pub velocity: DVec3,
    /// A_c.
    pub acceleration: DVec3,
}

/// Relative motion at a contact, its normal, and the distances kept.
///
/// With n the normal, g the distance kept and d_max the proximity distance,
///
/// ```text
/// depth  δ = P_c · n + g            > 0 too close, −d_max < δ <= 0 in proximity
/// factor λ = clamp(1 + δ / d_max)   to 0..=1
/// ```
///
/// V_c · n is then the speed of approach, dδ/dt.
///
/// ```
/// use glam::DVec3;
/// use response::{Margins, RelativeMotion, RelativeState};
///
/// // P is 0.5 above the plane z = 0 and should stay 1 above it.
/// let motion = RelativeMotion { position: DVec3::new(0.0, 0.0, -0.5), ..Default::default() };
/// let state = RelativeState::new(motion, DVec3::Z, 0.0, Margins::new(1.0, 0.25)?)?;
/// assert_eq!(state.depth(), 0.5);
/// assert_eq!(state.proximity_factor(), 1.0);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeState {
    motion: RelativeMotion,
    normal: DVec3,
    /// Offset of the contact.
    offset: f64,
    margins: Margins,
}

impl RelativeState {
    /// Returns the state of a contact with the given motion; `normal` is of unit length
    /// within 1e-6, `offset >= 0` the contact's own (radii of a medial one).
    ///
    /// # Errors
    ///
    /// [`ResponseError::ContactNotFinite`], [`ResponseError::Normal`] or
    /// [`ResponseError::Parameter`] with the value that is out of range.
    pub fn new(
        motion: RelativeMotion,
        normal: DVec3,
        offset: f64,
        margins: Margins,
    ) -> Result<Self, ResponseError> {
        check::contact_vector(0, "relative position", motion.position)?;
        check::contact_vector(0, "relative velocity", motion.velocity)?;
        check::contact_vector(0, "relative acceleration", motion.acceleration)?;
        check::not_negative("offset", offset)?;
        Ok(Self { motion, normal: check::normal(0, normal)?, offset, margins })
    }

    /// Computes the state of `contact` for particles with positions, velocities and
    /// accelerations `x`, `v`, `a`.
    ///
    /// # Errors
    ///
    /// As [`Self::new`], and [`ResponseError::ParticleOutOfRange`] when the
    /// contact refers to a particle that one of the slices lacks.
    pub fn of(
        contact: &Contact,
        [x, v, a]: [&[DVec3]; 3],
        margins: Margins,
    ) -> Result<Self, ResponseError> {
        let particle_count = x.len().min(v.len()).min(a.len());
        let particles = contact.stencil.terms().iter().map(|term| term.particle);
        check::particle_range(0, particles, particle_count)?;

        let anchor = contact.anchor.unwrap_or_default();
        let combine = |q: &[DVec3]| contact.stencil.combine(|k| q[k as usize]);
        let motion = RelativeMotion {
            position: anchor.point + combine(x),
            velocity: anchor.velocity + combine(v),
            acceleration: anchor.acceleration + combine(a),
        };
        Self::new(motion, contact.normal, contact.offset, margins)
    }

    /// Returns P_c, V_c and A_c.
    #[must_use]
    pub fn motion(&self) -> RelativeMotion {
        self.motion
    }

    /// Returns n, of unit length; it points out of the object that holds P̄.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Returns the distance kept, the source's g: offset and clearance.
    #[must_use]
    pub fn kept(&self) -> f64 {
        self.offset + self.margins.clearance
    }

    /// Returns the proximity distance, the source's d_max.
    #[must_use]
    pub fn proximity(&self) -> f64 {
        self.margins.proximity
    }

    /// Computes the depth δ = P_c · n + g.
    #[must_use]
    pub fn depth(&self) -> f64 {
        self.motion.position.dot(self.normal) + self.kept()
    }

    /// Computes λ, in `0.0..=1.0`: 1 in collision, falling to 0 at the rim of the
    /// proximity region.
    #[must_use]
    pub fn proximity_factor(&self) -> f64 {
        self.margins.proximity_factor(self.depth())
    }

    /// Computes the normal part `(u · n) n`.
    #[must_use]
    pub fn normal_part(&self, u: DVec3) -> DVec3 {
        u.dot(self.normal) * self.normal
    }

    /// Computes the tangential part `u − (u · n) n`.
    #[must_use]
    pub fn tangential_part(&self, u: DVec3) -> DVec3 {
        u - self.normal_part(u)
    }
}
