//! Constraints of rows: targets of the relative motion, one- or two-sided, hard or
//! compliant.
//!
//! A row with the target t, the compliance α and the impulse λ asks for Q_c = t + α λ, with
//! Q_c the displacement since the contact was detected, the relative velocity or the
//! relative acceleration. Every cell of the table of corrections is such a target:
//! t = Q_c + ΔQ_c, with Q_c before the correction.
//!
//! Source: M. Macklin, M. Müller and N. Chentanez, "XPBD: position-based simulation of
//! compliant constrained dynamics", Motion in Games 2016, for α as the inverse of a
//! stiffness times h².

use glam::DVec3;

use crate::{RelativeState, ResponseError, SolveLevel, StepLength, check};

/// Constraint that a row imposes on the relative motion Q_c of its contact.
///
/// Targets are values of Q_c: at the level of positions, displacements since the contact
/// was detected. Friction acts in the tangent plane of all but [`Vector`](Self::Vector).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Constraint {
    /// One-sided, with the target of the contact: no depth is left, and λ of the approach is
    /// canceled.
    #[default]
    Contact,
    /// As [`Contact`](Self::Contact), with an approach of at most this speed left: that at which a
    /// gap closes by the end of the move.
    Approach(f64),
    /// One-sided along the normal: Q_c · n is at most the target.
    OneSided(f64),
    /// Two-sided along the normal: gradual and two-sided springs, the second-order spring,
    /// the sliding reference.
    TwoSided(f64),
    /// The whole vector: the sticking reference. No friction.
    Vector(DVec3),
}

impl Constraint {
    /// Returns the one-sided constraint that a correction ΔQ_c of the table makes alone.
    #[must_use]
    pub fn one_sided(state: &RelativeState, level: SolveLevel, correction: DVec3) -> Self {
        Self::OneSided((value(state, level) + correction).dot(state.normal()))
    }

    /// Returns the two-sided constraint along the normal that a correction ΔQ_c of the table
    /// makes alone.
    ///
    /// ```
    /// use glam::DVec3;
    /// use response::{Constraint, Margins, RelativeMotion, RelativeState, SolveLevel, Spring};
    ///
    /// let motion = RelativeMotion { position: DVec3::Z * 0.3, ..Default::default() };
    /// let state = RelativeState::new(motion, DVec3::Z, 0.0, Margins::new(0.0, 1.0)?)?;
    /// let push = Spring::TwoSided.position(&state);
    /// let constraint = Constraint::two_sided(&state, SolveLevel::Position, push);
    /// assert_eq!(constraint, Constraint::TwoSided(-0.3));
    /// # Ok::<(), response::ResponseError>(())
    /// ```
    #[must_use]
    pub fn two_sided(state: &RelativeState, level: SolveLevel, correction: DVec3) -> Self {
        Self::TwoSided((value(state, level) + correction).dot(state.normal()))
    }

    /// Returns the constraint of the whole vector that a correction ΔQ_c of the table makes
    /// alone.
    #[must_use]
    pub fn vector(state: &RelativeState, level: SolveLevel, correction: DVec3) -> Self {
        Self::Vector(value(state, level) + correction)
    }

    /// Returns true if the normal impulse must not pull.
    pub(crate) fn is_one_sided(self) -> bool {
        matches!(self, Self::Contact | Self::Approach(_) | Self::OneSided(_))
    }

    /// Checks that the target is finite.
    pub(crate) fn check(self, row: usize) -> Result<(), ResponseError> {
        match self {
            Self::Contact => Ok(()),
            Self::Approach(target) | Self::OneSided(target) | Self::TwoSided(target) => {
                check::contact_number(row, "target", target).map(drop)
            }
            Self::Vector(target) => check::contact_vector(row, "target", target).map(drop),
        }
    }
}

/// Returns Q_c before the correction.
fn value(state: &RelativeState, level: SolveLevel) -> DVec3 {
    match level {
        SolveLevel::Position => DVec3::ZERO,
        SolveLevel::Velocity => state.motion().velocity,
        SolveLevel::Acceleration => state.motion().acceleration,
    }
}

/// Linear spring with damping, taken implicitly: a compliant constraint.
///
/// At the end of a step h the row's impulse is h² times (at velocity level h times, at
/// acceleration level 1 times) the force −k x − c v at that time, with x the elongation.
///
/// ```
/// use response::{SolveLevel, SpringDamper, StepLength};
///
/// // A mass m on a spring k, let go at x = 1: one step of implicit Euler.
/// let (m, k, h) = (2.0, 50.0, StepLength::new(0.1)?);
/// let spring = SpringDamper::new(k, 0.0)?;
/// let (alpha, target) = (spring.compliance(h), spring.target(SolveLevel::Velocity, h, 1.0, 0.0));
/// let impulse = target / (1.0 / m + alpha);
/// assert!((impulse / m - -k * 0.1 / (m + k * 0.1 * 0.1)).abs() < 1e-12);
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct SpringDamper {
    stiffness: f64,
    damping: f64,
}

#[cfg(feature = "serde")]
check::deserialize_checked!(
    SpringDamper { stiffness: f64, damping: f64 },
    Self::new(stiffness, damping)
);

impl SpringDamper {
    /// Returns a spring of stiffness k `> 0` \[force / length\] and damping c `>= 0`
    /// \[force / speed\].
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] outside the ranges.
    pub fn new(stiffness: f64, damping: f64) -> Result<Self, ResponseError> {
        Ok(Self {
            stiffness: check::positive("stiffness", stiffness)?,
            damping: check::not_negative("damping", damping)?,
        })
    }

    /// Returns the stiffness k.
    #[must_use]
    pub fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// Returns the damping c.
    #[must_use]
    pub fn damping(&self) -> f64 {
        self.damping
    }

    /// Returns the spring that a number of these make side by side.
    pub(crate) fn times(&self, count: f64) -> Self {
        Self { stiffness: count * self.stiffness, damping: count * self.damping }
    }

    /// Computes the compliance α = 1 / (k h² + c h), the same at all three levels.
    #[must_use]
    pub fn compliance(&self, h: StepLength) -> f64 {
        let h = h.get();
        (self.stiffness * h * h + self.damping * h).recip()
    }

    /// Computes the target of a row with this compliance, from the elongation and its speed
    /// at the start of the step.
    #[must_use]
    pub fn target(&self, level: SolveLevel, h: StepLength, elongation: f64, speed: f64) -> f64 {
        let (k, c, h) = (self.stiffness, self.damping, h.get());
        match level {
            SolveLevel::Position => -k * h * elongation / (k * h + c),
            SolveLevel::Velocity => -k * elongation / (k * h + c),
            SolveLevel::Acceleration => {
                -(k * (elongation + h * speed) + c * speed) / (k * h * h + c * h)
            }
        }
    }

    /// Computes the target of a vector, coordinate by coordinate.
    #[must_use]
    pub fn vector_target(
        &self,
        level: SolveLevel,
        h: StepLength,
        elongation: DVec3,
        speed: DVec3,
    ) -> DVec3 {
        let (x, v) = (elongation, speed);
        let along = |x: f64, v: f64| self.target(level, h, x, v);
        DVec3::new(along(x.x, v.x), along(x.y, v.y), along(x.z, v.z))
    }
}
