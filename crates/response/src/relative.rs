//! State of one contact: P̄ relative to P, and how far into the proximity
//! region it is.
//!
//! Source: B. Gilles, PhD thesis, 2007, section 4.7.2, "Collision response".
//! Names there and here: P_c, V_c, A_c are [`RelativeMotion`]'s fields; g is
//! [`kept`](RelativeState::kept), d_max [`proximity`](Margins::proximity),
//! λ [`proximity_factor`](RelativeState::proximity_factor).

use glam::DVec3;
use surface::Contact;

use crate::{ResponseError, check};

/// Distances a response keeps, in the caller's length unit.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Margins {
    clearance: f64,
    proximity: f64,
}

impl Margins {
    /// `clearance >= 0` is kept free beyond the contact's own offset;
    /// `proximity > 0`, the source's d_max, is how far outside that the
    /// response sets in.
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

    /// Distance kept free beyond the contact's own offset.
    #[must_use]
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// The source's d_max.
    #[must_use]
    pub fn proximity(&self) -> f64 {
        self.proximity
    }
}

/// P_c, V_c and A_c: position, velocity and acceleration of P̄ less those of P.
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
    kept: f64,
    proximity: f64,
}

impl RelativeState {
    /// State of a contact with the given motion; `normal` is of unit length
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
        let kept = check::not_negative("offset", offset)? + margins.clearance;
        Ok(Self { motion, normal: check::normal(0, normal)?, kept, proximity: margins.proximity })
    }

    /// State of `contact` for particles with positions, velocities and
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
        let missing =
            contact.stencil.terms().iter().find(|t| t.particle as usize >= particle_count);
        if let Some(&surface::Term { particle, .. }) = missing {
            return Err(ResponseError::ParticleOutOfRange { contact: 0, particle, particle_count });
        }
        let anchor = contact.anchor.unwrap_or_default();
        let combine = |q: &[DVec3]| contact.stencil.combine(|k| q[k as usize]);
        let motion = RelativeMotion {
            position: anchor.point + combine(x),
            velocity: anchor.velocity + combine(v),
            acceleration: anchor.acceleration + combine(a),
        };
        Self::new(motion, contact.normal, contact.offset, margins)
    }

    /// P_c, V_c and A_c.
    #[must_use]
    pub fn motion(&self) -> RelativeMotion {
        self.motion
    }

    /// n, of unit length; points out of the object that holds P̄.
    #[must_use]
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// The source's g: offset and clearance.
    #[must_use]
    pub fn kept(&self) -> f64 {
        self.kept
    }

    /// The source's d_max.
    #[must_use]
    pub fn proximity(&self) -> f64 {
        self.proximity
    }

    /// δ = P_c · n + g.
    #[must_use]
    pub fn depth(&self) -> f64 {
        self.motion.position.dot(self.normal) + self.kept
    }

    /// λ, in `0.0..=1.0`: 1 in collision, falling to 0 at the rim of the
    /// proximity region.
    #[must_use]
    pub fn proximity_factor(&self) -> f64 {
        (1.0 + self.depth() / self.proximity).clamp(0.0, 1.0)
    }

    /// `(u · n) n`.
    #[must_use]
    pub fn normal_part(&self, u: DVec3) -> DVec3 {
        u.dot(self.normal) * self.normal
    }

    /// `u − (u · n) n`.
    #[must_use]
    pub fn tangential_part(&self, u: DVec3) -> DVec3 {
        u - self.normal_part(u)
    }
}
