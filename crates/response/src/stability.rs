//! Linear stability of a time step: its amplification matrix and the limits found with it.
//!
//! One particle on one spring makes a step a linear map of (position,
//! velocity); it is stable when the spectral radius of that map is at most 1.
//! [`StabilityCase::step`] takes the step with this crate's own forces and integrators;
//! no limit is built in.

use glam::DVec3;
use surface::{Contact, ContactSide, Term};

use crate::{
    Accelerations, ContactLaw, ContactRows, ExplicitEuler, Friction, Implicit, ImplicitEuler,
    ImplicitMidpoint, Integrator, LinearParams, Margins, NormalForce, Reaction, Reference,
    RelativeMotion, RelativeState, ResponseError, Restraint, SoftContacts, SoftLaw, Spring,
    SymplecticEuler, Taylor, TimeStep, check,
};

/// Amplification matrix: two rows that map (position, velocity).
pub type Amplification = [[f64; 2]; 2];

/// Integration scheme of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scheme {
    /// [`ExplicitEuler`].
    ExplicitEuler,
    /// [`Taylor`].
    Taylor,
    /// [`SymplecticEuler`].
    SymplecticEuler,
    /// [`ImplicitEuler`].
    ImplicitEuler,
    /// [`ImplicitMidpoint`].
    ImplicitMidpoint,
}

/// Force or correction that holds the particle, with ω² = k / m, ζ the damping ratio and
/// h the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Holding {
    /// Two-sided contact spring with the given ω h and ζ, both `>= 0`.
    Penalty {
        /// Frequency times step.
        omega_h: f64,
        /// Damping ratio, 1 where critical.
        zeta: f64,
    },
    /// Spring row as an acceleration, ΔP_c / h², times `gain`: as many copies of one
    /// contact that are added up.
    FirstOrder {
        /// Number of copies.
        gain: f64,
    },
    /// Second-order spring of the scheme's own coefficients, times `gain`.
    SecondOrder {
        /// Number of copies.
        gain: f64,
    },
    /// Row that alters the state before each move, times `gain`.
    Hard {
        /// Row of the table of corrections.
        row: HardRow,
        /// Number of copies.
        gain: f64,
    },
}

/// Row of the table of corrections that alters velocities or positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum HardRow {
    /// The spring's velocity, ΔP_c / h.
    Spring,
    /// The spring's velocity that also stops, ΔP_c / h − V_c.
    SpringToTarget,
    /// The reaction's velocity. One-sided: motion that separates is not changed.
    Reaction,
    /// The reference's position and velocity.
    Reference,
}

impl Holding {
    /// Checks that no parameter is negative or not finite.
    fn check(self) -> Result<(), ResponseError> {
        match self {
            Self::Penalty { omega_h, zeta } => {
                check::not_negative("frequency times step", omega_h)?;
                check::not_negative("damping ratio", zeta)?;
            }
            Self::FirstOrder { gain } | Self::SecondOrder { gain } | Self::Hard { gain, .. } => {
                check::not_negative("gain", gain)?;
            }
        }
        Ok(())
    }
}

impl Scheme {
    /// All schemes.
    pub const ALL: [Self; 5] = [
        Self::ExplicitEuler,
        Self::Taylor,
        Self::SymplecticEuler,
        Self::ImplicitEuler,
        Self::ImplicitMidpoint,
    ];

    /// Returns the name in charts.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::ExplicitEuler => ExplicitEuler::NAME,
            Self::Taylor => Taylor::NAME,
            Self::SymplecticEuler => SymplecticEuler::NAME,
            Self::ImplicitEuler => ImplicitEuler::NAME,
            Self::ImplicitMidpoint => ImplicitMidpoint::NAME,
        }
    }
}

/// One particle of mass 1 held at the origin, in steps of length 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StabilityCase {
    /// Integration scheme.
    pub scheme: Scheme,
    /// Force or correction that holds the particle.
    pub holding: Holding,
}

impl StabilityCase {
    /// Computes the spectral radius of a step: at most 1 where stable. For a holding that
    /// is no linear map: the radius in contact and approaching.
    ///
    /// ```
    /// use response::stability::{StabilityCase, Holding, Scheme};
    ///
    /// let holding = Holding::SecondOrder { gain: 1.0 };
    /// let case = StabilityCase { scheme: Scheme::SymplecticEuler, holding };
    /// assert!(case.radius()? < 1e-6); // at rest after two steps
    /// # Ok::<(), response::ResponseError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As [`Self::step`].
    pub fn radius(&self) -> Result<f64, ResponseError> {
        let [a, b] = [self.step([-1.0, 0.0])?, self.step([0.0, -1.0])?];
        Ok(spectral_radius([[-a[0], -b[0]], [-a[1], -b[1]]]))
    }

    /// Computes position and velocity after one step.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Parameter`] when a parameter of the holding is
    /// negative or not finite.
    pub fn step(&self, state: [f64; 2]) -> Result<[f64; 2], ResponseError> {
        self.holding.check()?;
        match self.scheme {
            Scheme::ExplicitEuler => explicit::<ExplicitEuler>(self.holding, state),
            Scheme::Taylor => explicit::<Taylor>(self.holding, state),
            Scheme::SymplecticEuler => explicit::<SymplecticEuler>(self.holding, state),
            Scheme::ImplicitEuler => implicit::<ImplicitEuler>(self.holding, state),
            Scheme::ImplicitMidpoint => implicit::<ImplicitMidpoint>(self.holding, state),
        }
    }
}

/// Computes the spectral radius: the largest magnitude of the eigenvalues.
#[must_use]
pub fn spectral_radius([[a, b], [c, d]]: Amplification) -> f64 {
    let (half_trace, determinant) = (0.5 * (a + d), a * d - b * c);
    let discriminant = half_trace * half_trace - determinant;
    if discriminant < 0.0 { determinant.sqrt() } else { half_trace.abs() + discriminant.sqrt() }
}

/// Finds the largest value up to which `is_stable` holds, by bisection between a stable
/// `low` and an unstable `high`, to the relative `precision`; `None` unless `low`
/// is stable and `high` is not.
///
/// # Errors
///
/// The first that `is_stable` returns.
pub fn limit<E>(
    mut low: f64,
    mut high: f64,
    precision: f64,
    mut is_stable: impl FnMut(f64) -> Result<bool, E>,
) -> Result<Option<f64>, E> {
    if !is_stable(low)? || is_stable(high)? {
        return Ok(None);
    }

    while high - low > precision * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break; // no number in between
        }
        if is_stable(middle)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Ok(Some(low))
}

const HELD: [Term; 1] = [Term { particle: 0, weight: -1.0 }];

/// Takes a step with the accelerations at its start.
fn explicit<I: Integrator>(holding: Holding, state: [f64; 2]) -> Result<[f64; 2], ResponseError> {
    let step = TimeStep::<I>::new(1.0)?;
    let a = match holding {
        Holding::Penalty { omega_h, zeta } => {
            let rows = held_row(state[0])?;
            let soft = SoftContacts::new(&rows, &[along(state[1])], penalty(omega_h, zeta)?)?;
            let mut force = vec![DVec3::ZERO];
            soft.add_forces(&mut force)?;
            force
        }
        Holding::FirstOrder { gain } | Holding::SecondOrder { gain } => {
            vec![gain * spring_acceleration(step, holding, state)?]
        }
        Holding::Hard { row, gain } => return hard(step, row, gain, state),
    };
    advance(step.accelerations(a)?, state)
}

/// Takes a step with the accelerations at its end or its middle.
fn implicit<I: Implicit>(holding: Holding, state: [f64; 2]) -> Result<[f64; 2], ResponseError> {
    let step = TimeStep::<I>::new(1.0)?;
    let (v, params) = ([along(state[1])], LinearParams::default());
    let (a, _) = match holding {
        Holding::Penalty { omega_h, zeta } => {
            let rows = held_row(state[0])?;
            let soft = SoftContacts::new(&rows, &v, penalty(omega_h, zeta)?)?;
            let mut force = vec![DVec3::ZERO];
            soft.add_forces(&mut force)?;
            step.implicit_accelerations(&[1.0], &force, &soft, &v, &params)?
        }
        Holding::FirstOrder { gain } | Holding::SecondOrder { gain } => {
            let force = [gain * spring_acceleration(step, holding, state)?];
            // The spring is linear: its values at unit states are its derivatives.
            let gains = Gains {
                by_position: gain * spring_acceleration(step, holding, [1.0, 0.0])?.z,
                by_velocity: gain * spring_acceleration(step, holding, [0.0, 1.0])?.z,
            };
            step.implicit_accelerations(&[1.0], &force, &gains, &v, &params)?
        }
        Holding::Hard { row, gain } => return hard(step, row, gain, state),
    };
    advance(a, state)
}

/// Corrects position and velocity, and moves without any force.
fn hard<I: Integrator>(
    step: TimeStep<I>,
    row: HardRow,
    gain: f64,
    [x, v]: [f64; 2],
) -> Result<[f64; 2], ResponseError> {
    let h = step.length();
    let relative = relative([x, v])?;

    // ΔP_c and ΔV_c of the row.
    let none = DVec3::ZERO;
    let [position, velocity] = match row {
        HardRow::Spring => [none, Spring::TwoSided.velocity(&relative, h)],
        HardRow::SpringToTarget => [none, Spring::TwoSided.velocity_to_target(&relative, h)],
        HardRow::Reaction => [none, Reaction { friction: Friction::NONE }.velocity(&relative)],
        HardRow::Reference => {
            let reference = Reference::height(&relative, 0.0, Restraint::Sticking)?;
            [reference.position(&relative), reference.velocity(&relative)]
        }
    };
    let state = [distributed(x, gain * position)?.z, distributed(v, gain * velocity)?.z];
    advance(step.accelerations(vec![none])?, state)
}

/// Computes the particle's acceleration by one copy of the spring row.
fn spring_acceleration<I: Integrator>(
    step: TimeStep<I>,
    holding: Holding,
    state: [f64; 2],
) -> Result<DVec3, ResponseError> {
    let state = relative(state)?;
    let reference = Reference::height(&state, 0.0, Restraint::Sliding)?;
    let (position, velocity) = (reference.position(&state), reference.velocity(&state));
    let change = if let Holding::SecondOrder { .. } = holding {
        step.second_order_spring(&state, position, velocity)?.change()
    } else {
        let h = step.length().get();
        position / (h * h)
    };
    distributed(0.0, change)
}

/// Computes the particle's value along the axis after a correction of its contact.
fn distributed(value: f64, correction: DVec3) -> Result<DVec3, ResponseError> {
    let mut q = [along(value)];
    crate::distribute(&HELD, &[1.0], correction, &mut q)?;
    Ok(q[0])
}

/// Returns the state of the particle's contact, always within proximity.
fn relative([x, v]: [f64; 2]) -> Result<RelativeState, ResponseError> {
    let motion =
        RelativeMotion { position: along(-x), velocity: along(-v), acceleration: DVec3::ZERO };
    RelativeState::new(motion, DVec3::Z, 0.0, Margins::new(0.0, 1.0)?)
}

struct Gains {
    by_position: f64,
    by_velocity: f64,
}

impl crate::LinearForces for Gains {
    fn add_stiffness(&self, dx: &[DVec3], out: &mut [DVec3]) {
        out[0] += self.by_position * dx[0];
    }

    fn add_damping(&self, dv: &[DVec3], out: &mut [DVec3]) {
        out[0] += self.by_velocity * dv[0];
    }
}

fn advance<I: Integrator>(a: Accelerations<I>, state: [f64; 2]) -> Result<[f64; 2], ResponseError> {
    // The axis of the spring is z.
    let (mut x, mut v) = ([along(state[0])], [along(state[1])]);
    a.advance(&mut x, &mut v)?;
    Ok([x[0].z, v[0].z])
}

/// Returns the row of the particle's contact with the origin at gap `x`.
fn held_row(x: f64) -> Result<ContactRows, ResponseError> {
    let (particle, origin) =
        ([Term { particle: 0, weight: 1.0 }], ContactSide::at_rest(DVec3::ZERO));
    let contact = Contact::between(ContactSide::Particles(&particle), origin, DVec3::Z, x);
    let mut rows = ContactRows::new(1);
    rows.push(&contact, ContactLaw::new(Margins::new(0.0, 1.0)?, 0.0)?)?;
    Ok(rows)
}

fn penalty(omega_h: f64, zeta: f64) -> Result<SoftLaw, ResponseError> {
    let normal =
        NormalForce::TwoSided { stiffness: omega_h * omega_h, damping: 2.0 * zeta * omega_h };
    SoftLaw::new(normal, 1.0)
}

fn along(z: f64) -> DVec3 {
    DVec3::new(0.0, 0.0, z)
}
