//! Reference row of the table of corrections: restores a stored P_c.
//!
//! Source: B. Gilles, PhD thesis, 2007, section 4.7.2: from a reference
//! configuration where point-to-face information was stored. The weights are
//! stored in the contact's stencil; the target of P_c is stored here, as a
//! distance along the normal or as a vector in the frame of the face.

use glam::{DMat3, DVec3};
use surface::triangle;

use crate::{RelativeState, ResponseError, check};

/// Frame of a face: the first axis along its first edge, the third along its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FaceFrame(DMat3);

impl FaceFrame {
    /// Computes the frame of a face; `None` where it has no area.
    #[must_use]
    pub fn new([a, b, c]: [DVec3; 3]) -> Option<Self> {
        let along = (b - a).try_normalize()?;
        let normal = triangle::normal([a, b, c]).try_normalize()?;
        Some(Self(DMat3::from_cols(along, normal.cross(along), normal)))
    }

    /// Returns a vector's coordinates in this frame.
    #[must_use]
    pub fn to_local(&self, vector: DVec3) -> DVec3 {
        self.0.transpose() * vector
    }

    /// Returns the vector with these coordinates in this frame.
    #[must_use]
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        self.0 * local
    }
}

/// Part of the motion that a reference restrains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Restraint {
    /// The whole motion.
    Sticking,
    /// The part along the normal.
    Sliding,
}

/// Reference: the target of a contact's P_c, and the part of it that is restrained.
///
/// ```
/// use glam::DVec3;
/// use response::{Restraint, Margins, Reference, RelativeMotion, RelativeState};
///
/// let motion = RelativeMotion { position: DVec3::new(0.1, 0.0, -0.5), ..Default::default() };
/// let state = RelativeState::new(motion, DVec3::Z, 0.0, Margins::new(0.0, 1.0)?)?;
/// // It was 0.8 above the surface.
/// let sliding = Reference::height(&state, 0.8, Restraint::Sliding)?;
/// assert!((sliding.position(&state) - DVec3::Z * -0.3).length() < 1e-15);
/// let sticking = Reference::height(&state, 0.8, Restraint::Sticking)?;
/// assert!((sticking.position(&state) - DVec3::new(-0.1, 0.0, -0.3)).length() < 1e-15);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reference {
    target: DVec3,
    restraint: Restraint,
}

impl Reference {
    /// Returns the reference of P straight over P̄ at the signed height `height`, along the
    /// normal.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] when the height is not finite.
    pub fn height(
        state: &RelativeState,
        height: f64,
        restraint: Restraint,
    ) -> Result<Self, ResponseError> {
        let height = check::parameter("reference height", height, "finite", true)?;
        Ok(Self { target: -height * state.normal(), restraint })
    }

    /// Returns the reference of P_c as stored in the frame of the face, `local`, in the
    /// present frame.
    ///
    /// # Errors
    ///
    /// [`ResponseError::ContactNotFinite`] when the vector is not.
    pub fn in_frame(
        frame: &FaceFrame,
        local: DVec3,
        restraint: Restraint,
    ) -> Result<Self, ResponseError> {
        let local = check::contact_vector(0, "reference vector", local)?;
        Ok(Self { target: frame.to_world(local), restraint })
    }

    /// Computes ΔP_c = P_ref − P_c.
    #[must_use]
    pub fn position(&self, state: &RelativeState) -> DVec3 {
        self.restrained(state, self.target - state.motion().position)
    }

    /// Computes ΔV_c = −V_c.
    #[must_use]
    pub fn velocity(&self, state: &RelativeState) -> DVec3 {
        self.restrained(state, -state.motion().velocity)
    }

    /// Computes ΔA_c = −A_c. [`TimeStep::second_order_spring`] instead reaches the target
    /// position and velocity two steps later.
    ///
    /// [`TimeStep::second_order_spring`]: crate::TimeStep::second_order_spring
    #[must_use]
    pub fn acceleration(&self, state: &RelativeState) -> DVec3 {
        self.restrained(state, -state.motion().acceleration)
    }

    fn restrained(&self, state: &RelativeState, change: DVec3) -> DVec3 {
        match self.restraint {
            Restraint::Sticking => change,
            Restraint::Sliding => state.normal_part(change),
        }
    }
}
