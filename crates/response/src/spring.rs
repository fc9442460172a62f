//! Spring row of the table of corrections: pushes P back to the distance kept.
//!
//! Source: B. Gilles, PhD thesis, 2007, section 4.7.2. The text of its table is
//! not reproduced here: the corrections are derived from its definitions of
//! P_c, g, d_max and λ, and where those leave a choice each one is offered.

use glam::DVec3;

use crate::{RelativeState, StepLength};

/// Displacement law of a spring, with δ the depth, λ the proximity factor and d_max
/// the proximity distance (see [`RelativeState`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Spring {
    /// Pushes by max(δ, 0): to the distance kept, once it is violated.
    OneSided,
    /// Pushes by λ d_max: to the rim of the proximity region while within it, and by
    /// at most d_max.
    Gradual,
    /// Pushes or pulls by λ δ: to the distance kept from either side, weaker toward the
    /// rim. Restrains permanent contacts that slide.
    TwoSided,
}

impl Spring {
    /// Computes ΔP_c, in the caller's length unit.
    ///
    /// ```
    /// use glam::DVec3;
    /// use response::{Margins, RelativeMotion, RelativeState, Spring};
    ///
    /// let motion = RelativeMotion { position: DVec3::Z * 0.3, ..Default::default() };
    /// let state = RelativeState::new(motion, DVec3::Z, 0.0, Margins::new(0.0, 1.0)?)?;
    /// assert_eq!(Spring::OneSided.position(&state), DVec3::Z * -0.3);
    /// # Ok::<(), response::ResponseError>(())
    /// ```
    #[must_use]
    pub fn position(self, state: &RelativeState) -> DVec3 {
        -self.push(state) * state.normal()
    }

    /// Computes ΔV_c = ΔP_c / h, which reaches the target in one step from rest.
    #[must_use]
    pub fn velocity(self, state: &RelativeState, h: StepLength) -> DVec3 {
        self.position(state) / h.get()
    }

    /// Computes ΔV_c = ΔP_c / h − V_c,n, which reaches the target in one step at any
    /// speed of approach. V_c,n counts with the weight of the push, so that the
    /// correction is continuous at the rim.
    #[must_use]
    pub fn velocity_to_target(self, state: &RelativeState, h: StepLength) -> DVec3 {
        let approach = state.normal_part(state.motion().velocity);
        self.velocity(state, h) - self.weight(state) * approach
    }

    /// Computes ΔA_c = ΔP_c / h². Undamped: [`TimeStep::second_order_spring`] also
    /// stops.
    ///
    /// [`TimeStep::second_order_spring`]: crate::TimeStep::second_order_spring
    #[must_use]
    pub fn acceleration(self, state: &RelativeState, h: StepLength) -> DVec3 {
        self.position(state) / (h.get() * h.get())
    }

    fn push(self, state: &RelativeState) -> f64 {
        match self {
            Self::OneSided => state.depth().max(0.0),
            Self::Gradual => state.proximity_factor() * state.proximity(),
            Self::TwoSided => state.proximity_factor() * state.depth(),
        }
    }

    fn weight(self, state: &RelativeState) -> f64 {
        match self {
            Self::OneSided if state.depth() > 0.0 => 1.0,
            Self::OneSided => 0.0,
            Self::Gradual | Self::TwoSided => state.proximity_factor(),
        }
    }
}
