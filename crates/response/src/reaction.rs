//! Reaction row of the table of corrections: cancels the approach and reduces the slip.
//!
//! Source: B. Gilles, PhD thesis, 2007, section 4.7.2, for the reaction and its
//! friction 0 ≤ µ ≤ 1, which removes that share of the slip. It creeps down any
//! slope; [`Friction::coulomb`] sticks on slopes up to atan µ, and is the law
//! that the solvers use.

use glam::DVec3;

use crate::{RelativeState, ResponseError, check};

/// Friction law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Rule"))]
pub struct Friction(Rule);

#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
enum Rule {
    Share(f64),
    Coulomb { sticking: f64, sliding: f64 },
}

#[cfg(feature = "serde")]
impl TryFrom<Rule> for Friction {
    type Error = ResponseError;

    fn try_from(rule: Rule) -> Result<Self, ResponseError> {
        match rule {
            Rule::Share(mu) => Self::share(mu),
            Rule::Coulomb { sticking, sliding } => Self::static_dynamic(sticking, sliding),
        }
    }
}

impl Friction {
    /// No friction.
    pub const NONE: Self = Self(Rule::Coulomb { sticking: 0.0, sliding: 0.0 });

    /// Returns the source's law, which removes the share µ, in `0.0..=1.0`, of the slip.
    ///
    /// That is what one contact does by itself, or several that do not disturb each other. Where
    /// contacts share particles, friction acts along the slip at the start, and against it: until
    /// 1 − µ λ of that slip is left, and not where other contacts leave less. Its ratio to the push
    /// is at most that of the contact by itself, so that it ends with the push. Such impulses, once
    /// solved, only dissipate. In permanent contacts, and in corrections of displacements, friction
    /// is not limited by a push.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] outside the range.
    pub fn share(mu: f64) -> Result<Self, ResponseError> {
        let within = (0.0..=1.0).contains(&mu);
        Ok(Self(Rule::Share(check::parameter("friction share", mu, "in 0..=1", within)?)))
    }

    /// Returns Coulomb's law, which removes at most µ `>= 0` times the normal part's
    /// change, and never reverses the slip.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] outside the range.
    pub fn coulomb(mu: f64) -> Result<Self, ResponseError> {
        Self::static_dynamic(mu, mu)
    }

    /// Returns Coulomb's law with a larger coefficient while the contact sticks:
    /// `0 <= dynamic <= static`.
    ///
    /// A slip that the static coefficient can stop is stopped; any other is reduced by the
    /// dynamic one.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] outside the range.
    pub fn static_dynamic(sticking: f64, sliding: f64) -> Result<Self, ResponseError> {
        let sticking = check::not_negative("friction coefficient", sticking)?;
        let range = "in 0..=the static one";
        let within = (0.0..=sticking).contains(&sliding);
        let sliding = check::parameter("dynamic friction coefficient", sliding, range, within)?;
        Ok(Self(Rule::Coulomb { sticking, sliding }))
    }

    /// Returns Coulomb's dynamic coefficient µ; 0 for a share.
    #[must_use]
    pub fn coefficient(self) -> f64 {
        self.coefficients().1
    }

    /// Returns Coulomb's static and dynamic coefficient; 0 for a share.
    pub(crate) fn coefficients(self) -> (f64, f64) {
        match self.0 {
            Rule::Share(_) => (0.0, 0.0),
            Rule::Coulomb { sticking, sliding } => (sticking, sliding),
        }
    }

    /// Returns the source's share µ of the slip that is removed, where that is the law.
    pub(crate) fn as_share(self) -> Option<f64> {
        match self.0 {
            Rule::Share(mu) => Some(mu),
            Rule::Coulomb { .. } => None,
        }
    }

    /// Computes the part of `slip` to remove, where the normal part cancels `approach` and
    /// both are scaled by λ.
    fn reduction(self, slip: DVec3, approach: f64, lambda: f64) -> DVec3 {
        match self.0 {
            Rule::Share(mu) => lambda * mu * slip,
            Rule::Coulomb { sticking, sliding } => {
                let normal = lambda * approach;
                let is_stopped = slip.length() <= sticking * normal;
                if is_stopped { slip } else { slip.clamp_length_max(sliding * normal) }
            }
        }
    }
}

/// Reaction: cancels the approaching part of a motion, scaled by λ.
///
/// ```
/// use glam::DVec3;
/// use response::{Friction, Margins, Reaction, RelativeMotion, RelativeState};
///
/// // P moves down and sideways at the surface: P̄ comes up relative to it.
/// let velocity = DVec3::new(0.3, 0.0, 2.0);
/// let motion = RelativeMotion { velocity, ..Default::default() };
/// let state = RelativeState::new(motion, DVec3::Z, 0.0, Margins::new(0.0, 1.0)?)?;
/// let sticks = Reaction { friction: Friction::coulomb(0.5)? };
/// assert_eq!(velocity + sticks.velocity(&state), DVec3::ZERO);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Reaction {
    /// Friction law.
    pub friction: Friction,
}

impl Reaction {
    /// Computes ΔP_c, which takes back the last displacement D = P_c(t) − P_c(t − h).
    ///
    /// The source's share of the slip is taken back whether or not D
    /// approaches; Coulomb's law needs an approach.
    ///
    /// # Errors
    ///
    /// [`ResponseError::ContactNotFinite`] when `last` is not.
    pub fn position(&self, state: &RelativeState, last: DVec3) -> Result<DVec3, ResponseError> {
        let last = check::contact_vector(0, "last displacement", last)?;
        Ok(self.cancel(state, last))
    }

    /// Computes ΔV_c: zero unless V_c · n > 0, that is, approaching.
    #[must_use]
    pub fn velocity(&self, state: &RelativeState) -> DVec3 {
        self.cancel_approaching(state, state.motion().velocity)
    }

    /// Computes ΔA_c: zero unless A_c · n > 0.
    #[must_use]
    pub fn acceleration(&self, state: &RelativeState) -> DVec3 {
        self.cancel_approaching(state, state.motion().acceleration)
    }

    fn cancel_approaching(&self, state: &RelativeState, u: DVec3) -> DVec3 {
        if u.dot(state.normal()) > 0.0 { self.cancel(state, u) } else { DVec3::ZERO }
    }

    fn cancel(&self, state: &RelativeState, u: DVec3) -> DVec3 {
        let lambda = state.proximity_factor();
        let approach = u.dot(state.normal()).max(0.0);
        let slip = self.friction.reduction(state.tangential_part(u), approach, lambda);
        -(lambda * approach * state.normal() + slip)
    }
}
