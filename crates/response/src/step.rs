//! Time integrators, and the second-order spring with their coefficients.
//!
//! Source: P. Volino and N. Magnenat-Thalmann, "Implementing fast cloth
//! simulation with collision response", Computer Graphics International, 2000,
//! as cited by B. Gilles, PhD thesis, 2007, section 4.7.2: a spring of second
//! order comes from the development of positions and velocities at t + 2h.
//!
//! Every integrator here moves a particle under an acceleration a by
//!
//! ```text
//! v' = v + a h        x' = x + v h + σ a h²
//! ```
//!
//! with its own σ ([`Integrator::POSITION_SHARE`]). Asking for x + Δx and
//! v + Δv two steps on, with accelerations a₁ and a₂, gives
//!
//! ```text
//! a₁ = Δx / h² − 2 v / h − σ Δv / h
//! ```
//!
//! A spring with another integrator's σ oscillates forever or diverges, so the
//! integrator is a type: the correction, the accelerations it is added to and
//! the step that consumes them all carry it.

use std::fmt::Debug;
use std::marker::PhantomData;

use glam::DVec3;
use surface::Term;

use crate::{RelativeState, ResponseError, check, distribute};

/// Length of a time step, finite and `> 0`, in the caller's time unit.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct StepLength(f64);

impl StepLength {
    /// Returns a step length, if it is valid.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] outside the range, and where its square
    /// or the inverse of that leaves the range of numbers.
    pub fn new(h: f64) -> Result<Self, ResponseError> {
        let square = h * h;
        let holds = h > 0.0 && square.is_normal() && square.recip().is_normal();
        Ok(Self(check::parameter("step length", h, "> 0 with a finite inverse square", holds)?))
    }

    /// Returns the length as a number.
    #[must_use]
    pub fn get(self) -> f64 {
        self.0
    }
}

/// Time integrator: the update of a motion by accelerations, which also defines the
/// coefficients of the second-order spring.
pub trait Integrator: Copy + Debug + Send + Sync + 'static {
    /// σ: factor of a h² in a step's change of position.
    const POSITION_SHARE: f64;
    /// Name in charts and reports.
    const NAME: &'static str;
}

/// Integrator whose accelerations are those at the end or the middle of the step, the
/// solution of a linear system ([`TimeStep::implicit_accelerations`]).
///
/// [`TimeStep::implicit_accelerations`]: crate::TimeStep::implicit_accelerations
pub trait Implicit: Integrator {}

macro_rules! integrator {
    ($(#[$doc:meta])* $name:ident, $share:literal, $text:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name {}
        impl Integrator for $name {
            const POSITION_SHARE: f64 = $share;
            const NAME: &'static str = $text;
        }
    };
}

integrator!(
    /// x' = x + v h. Unstable for every undamped spring.
    ExplicitEuler, 0.0, "explicit Euler"
);
integrator!(
    /// x' = x + v h + a h² / 2.
    Taylor, 0.5, "Taylor"
);
integrator!(
    /// x' = x + v' h.
    SymplecticEuler, 1.0, "symplectic Euler"
);
integrator!(
    /// x' = x + v' h with the forces at the end of the step.
    ImplicitEuler, 1.0, "implicit Euler"
);
integrator!(
    /// x' = x + (v + v') h / 2 with the forces at the middle of the step.
    ImplicitMidpoint, 0.5, "implicit midpoint"
);
impl Implicit for ImplicitEuler {}
impl Implicit for ImplicitMidpoint {}

/// Time step of an integrator `I`.
///
/// ```
/// use glam::DVec3;
/// use response::{Margins, RelativeMotion, RelativeState, Spring, SymplecticEuler, TimeStep};
/// use surface::{Stencil, Term};
///
/// // A particle 2 deep in a fixed floor, at rest: up and at rest two steps later.
/// let (mut x, mut v) = (vec![DVec3::Z * -2.0], vec![DVec3::ZERO]);
/// let terms = [Term { particle: 0, weight: -1.0 }];
/// let step = TimeStep::<SymplecticEuler>::new(0.01)?;
/// for _ in 0..2 {
///     let motion = RelativeMotion { position: -x[0], velocity: -v[0], ..Default::default() };
///     let state = RelativeState::new(motion, DVec3::Z, 0.0, Margins::new(0.0, 1.0)?)?;
///     let correction = step.second_order_spring(&state, -motion.position, -motion.velocity)?;
///     let mut a = step.accelerations(vec![DVec3::ZERO])?;
///     a.correct(&terms, &[1.0], correction)?;
///     a.advance(&mut x, &mut v)?;
/// }
/// assert!(x[0].length() < 1e-12 && v[0].length() < 1e-12);
/// # Ok::<(), response::ResponseError>(())
/// ```
///
/// A correction made for one integrator does not fit another's accelerations:
///
/// ```compile_fail
/// # use response::{Acceleration, Accelerations, SymplecticEuler, Taylor};
/// fn mismatch(a: &mut Accelerations<SymplecticEuler>, correction: Acceleration<Taylor>) {
///     a.correct(&[], &[], correction);
/// }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeStep<I> {
    h: StepLength,
    integrator: PhantomData<I>,
}

/// Correction ΔA_c for steps of the integrator `I`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Acceleration<I> {
    step: TimeStep<I>,
    change: DVec3,
}

/// Accelerations of all particles, consumed by one step of `I`.
#[derive(Clone, Debug, PartialEq)]
pub struct Accelerations<I> {
    step: TimeStep<I>,
    values: Vec<DVec3>,
}

impl<I: Integrator> TimeStep<I> {
    /// Returns a step of length `h > 0`.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] outside the range.
    pub fn new(h: f64) -> Result<Self, ResponseError> {
        Ok(Self { h: StepLength::new(h)?, integrator: PhantomData })
    }

    /// Returns the step length.
    #[must_use]
    pub fn length(self) -> StepLength {
        self.h
    }

    /// Computes ΔA_c such that two steps later P_c has changed by `position` and V_c by
    /// `velocity`, if the second step is corrected likewise and nothing else
    /// acts. They are ΔP_c of the spring (or reference) row and ΔV_c of the
    /// reaction (or reference) row.
    ///
    /// A_c of `state` must include all other accelerations: each missing one
    /// leaves a sag of a h². Apply it to a contact once: two copies diverge.
    ///
    /// # Errors
    ///
    /// [`ResponseError::ContactNotFinite`] when a target or the correction is not.
    pub fn second_order_spring(
        self,
        state: &RelativeState,
        position: DVec3,
        velocity: DVec3,
    ) -> Result<Acceleration<I>, ResponseError> {
        let h = self.h.get();
        let motion = state.motion();
        let first =
            position / (h * h) - 2.0 * motion.velocity / h - I::POSITION_SHARE * velocity / h;
        let change = first - motion.acceleration;
        Ok(Acceleration { step: self, change: check::contact_vector(0, "acceleration", change)? })
    }

    /// Takes ownership of the accelerations of all particles before contact.
    ///
    /// # Errors
    ///
    /// [`ResponseError::ParticleNotFinite`] with the first that is not.
    pub fn accelerations(self, values: Vec<DVec3>) -> Result<Accelerations<I>, ResponseError> {
        check::particles("acceleration", values.len(), &values)?;
        Ok(Accelerations { step: self, values })
    }
}

impl<I> Acceleration<I> {
    /// Returns ΔA_c as a vector.
    #[must_use]
    pub fn change(&self) -> DVec3 {
        self.change
    }
}

impl<I: Integrator> Accelerations<I> {
    /// Returns the accelerations, one per particle.
    #[must_use]
    pub fn values(&self) -> &[DVec3] {
        &self.values
    }

    /// Returns the accelerations, to be corrected; [`Self::advance`] checks them.
    #[must_use]
    pub fn values_mut(&mut self) -> &mut [DVec3] {
        &mut self.values
    }

    /// Spreads one contact's correction over its particles.
    ///
    /// # Errors
    ///
    /// [`ResponseError::StepLength`] when the correction was made for another
    /// step length; otherwise as [`distribute`].
    pub fn correct(
        &mut self,
        terms: &[Term],
        inverse_mass: &[f64],
        correction: Acceleration<I>,
    ) -> Result<(), ResponseError> {
        let (made_for, applied_to) = (correction.step.h.get(), self.step.h.get());
        if made_for.to_bits() != applied_to.to_bits() {
            return Err(ResponseError::StepLength { made_for, applied_to });
        }
        distribute(terms, inverse_mass, correction.change, &mut self.values)?;
        Ok(())
    }

    /// Moves the particles by one step.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Count`] when the lists differ in length, and
    /// [`ResponseError::ParticleNotFinite`] when an entry is not finite, with
    /// nothing moved.
    pub fn advance(self, x: &mut [DVec3], v: &mut [DVec3]) -> Result<(), ResponseError> {
        check::particles("position", self.values.len(), x)?;
        check::particles("velocity", self.values.len(), v)?;
        check::particles("acceleration", self.values.len(), &self.values)?;

        let h = self.step.h.get();
        for ((x, v), a) in x.iter_mut().zip(v).zip(&self.values) {
            *x += *v * h + I::POSITION_SHARE * h * h * *a;
            *v += *a * h;
        }
        Ok(())
    }
}
