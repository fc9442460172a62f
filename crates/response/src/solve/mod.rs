//! Several contacts at once.
//!
//! Corrections of contacts that share particles add up: on a patch of 80
//! contacts over 24 particles, the sum of what each asks for alone raises the
//! kinetic energy many times over. A [`ContactSystem`] corrects them together,
//! by one of three methods:
//!
//! - **Projected Gauss–Seidel** with accumulated impulses (the default): one
//!   row after the other; a normal impulse never pulls, and friction stays
//!   within Coulomb's disc. Source: the sequential impulses of game physics,
//!   and M. Jean, "The non-smooth contact dynamics method", CMAME 177, 1999.
//! - **Averaged Jacobi**: all rows at once, each seeing of a particle that n
//!   rows share one nth of its mass. Source: R. Tonge, F. Benevolenski and
//!   A. Voroshilov, "Mass splitting for jitter-free parallel rigid body
//!   simulation", ACM TOG 31(4), 2012. Unlike averaging the corrections of each
//!   particle, this keeps the momentum.
//! - **Conjugate gradients** on the equality of the rows that come into
//!   violation. Source:
//!   P. Volino and N. Magnenat-Thalmann, "Accurate collision response on
//!   polygonal meshes", Computer Animation, 2000. No friction, and a row may
//!   pull.
//!
//! With Q_c = Σ β_k q_k + b the relative motion of a row, n its normal and
//! p >= 0, j ⟂ n its accumulated impulses, all three change the particles by
//! q_k −= β_k (p n + j) / m_k, which keeps the momentum to rounding.

mod coloring;
mod conjugate_gradient;
mod gauss_seidel;
mod jacobi;
mod packed;
mod slots;

use glam::DVec3;

use self::packed::Packed;
use crate::{ContactRows, ResponseError, check};

/// Which rows of a Gauss–Seidel sweep come first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SweepOrder {
    /// In batches that share no particle, each in the order given. Run in
    /// parallel with the feature `rayon`, in the caller's pool; the result has
    /// the same bits without it and for any number of threads.
    #[default]
    Colored,
    /// As given: from the support upward, a stack settles faster.
    Given,
}

/// How contacts are solved together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SolverMethod {
    /// Projected Gauss–Seidel.
    #[default]
    GaussSeidel,
    /// Averaged Jacobi.
    AveragedJacobi,
    /// Conjugate gradients, without friction.
    ConjugateGradient,
}

/// How hard a solver tries.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SolverParams {
    /// How contacts are solved together.
    pub method: SolverMethod,
    /// Sweeps or steps at most.
    pub max_iterations: u32,
    /// Ends when no row is changed by more than this, in the unit of what is
    /// solved for, `>= 0`.
    pub tolerance: f64,
}

impl Default for SolverParams {
    /// Ten sweeps of Gauss–Seidel: what a warm start makes enough for contacts
    /// that persist. A tolerance of 0 ends earlier only where nothing changes.
    fn default() -> Self {
        Self { method: SolverMethod::GaussSeidel, max_iterations: 10, tolerance: 0.0 }
    }
}

/// What is corrected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum SolveLevel {
    /// Displacements since the contacts were found: no depth is left, and slip
    /// is taken back within Coulomb's disc. Rigid objects count as at rest.
    Position,
    /// Velocities: the approach is canceled, λ of it.
    Velocity,
    /// Accelerations: likewise.
    Acceleration,
}

/// Accumulated impulses of one row: what P was given, and P̄ with the opposite
/// sign. Mass times the unit of what was solved for.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Impulse {
    /// p, along the normal; `>= 0` except by conjugate gradients.
    pub normal: f64,
    /// j, perpendicular to the normal, `|j| <= µ p`.
    pub tangent: DVec3,
}

/// How a solution went.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SolveReport {
    /// Sweeps or steps done.
    pub iterations: u32,
    /// Largest change that one row alone would still ask for, in the unit of
    /// what was solved for: what is left of an approach, of a forbidden slip,
    /// or of a push that is not needed.
    pub residual: f64,
    /// Whether the residual is within the tolerance.
    pub converged: bool,
    /// Rows left out because none of their particles can move.
    pub immovable: usize,
}

/// Contact rows and the masses they act on, ready to be solved.
///
/// ```
/// use glam::DVec3;
/// use response::{
///     ContactLaw, ContactRows, ContactSystem, SolveLevel, Margins, SweepOrder, SolverParams,
/// };
/// use surface::{Anchor, Contact, Stencil, Term};
///
/// // Two particles one over the other come down on a floor.
/// let on = |stencil, anchor| Contact {
///     stencil, anchor, normal: DVec3::Z, offset: 0.0, gap: 0.0, time: None,
/// };
/// let term = |particle, weight| Term { particle, weight };
/// let pair = Stencil::new(&[term(1, -1.0), term(0, 1.0)]).expect("two terms");
/// let contacts = [on(Stencil::single(term(0, -1.0)), Some(Anchor::default())), on(pair, None)];
///
/// let mut rows = ContactRows::new(2);
/// rows.extend(&contacts, ContactLaw::new(Margins::new(0.0, 1.0)?, 0.3)?)?;
/// let system = ContactSystem::new(&rows, &[1.0, 1.0], SweepOrder::Given)?;
/// let mut v = vec![DVec3::Z * -2.0; 2];
/// let params = SolverParams { max_iterations: 100, tolerance: 1e-12, ..Default::default() };
/// let report = system.solve(SolveLevel::Velocity, &mut v, &mut system.no_impulses(), &params)?;
/// assert!(report.converged && v.iter().all(|v| v.length() < 1e-11));
/// # Ok::<(), response::ResponseError>(())
/// ```
#[derive(Clone, Debug)]
pub struct ContactSystem {
    packed: Packed,
}

impl ContactSystem {
    /// Prepares rows for particles of the given inverse masses, 0 for a fixed
    /// one.
    ///
    /// # Errors
    ///
    /// [`ResponseError::Count`] or [`ResponseError::InverseMass`].
    pub fn new(
        rows: &ContactRows,
        inverse_mass: &[f64],
        order: SweepOrder,
    ) -> Result<Self, ResponseError> {
        check::inverse_masses(rows.particle_count(), inverse_mass)?;
        Ok(Self { packed: Packed::new(rows, inverse_mass, order) })
    }

    /// Batches of rows that share no particle; 1 for [`SweepOrder::Given`].
    #[must_use]
    pub fn batch_count(&self) -> usize {
        self.packed.batches.len()
    }

    /// One zero impulse a row: a cold start.
    #[must_use]
    pub fn no_impulses(&self) -> Vec<Impulse> {
        vec![Impulse::default(); self.packed.row_count]
    }

    /// Corrects `q`: displacements, velocities or accelerations of all
    /// particles.
    ///
    /// `impulses`, one a row, hold where to start and are replaced by what was
    /// reached: keep them for the next step ([`warm_start`]). Displacements
    /// are since the contacts were found: 0 where they were found at the end of
    /// a step, the whole step's where at its start. Friction takes back the
    /// slip of the second, and of the first that of other contacts' pushes.
    ///
    /// Not reaching the tolerance is no error: see [`SolveReport`].
    ///
    /// # Errors
    ///
    /// With `q` and `impulses` unchanged:
    /// - [`ResponseError::Count`] or [`ResponseError::ParticleNotFinite`] for
    ///   `q`, also when the result would not be finite;
    /// - [`ResponseError::ContactNotFinite`] for an impulse;
    /// - [`ResponseError::Parameter`] for a negative tolerance.
    ///
    /// [`warm_start`]: crate::warm_start
    pub fn solve(
        &self,
        level: SolveLevel,
        q: &mut [DVec3],
        impulses: &mut [Impulse],
        params: &SolverParams,
    ) -> Result<SolveReport, ResponseError> {
        let packed = &self.packed;
        check::particles(level.name(), packed.particle_count, q)?;
        check::count("impulses", packed.row_count, impulses.len())?;
        check::not_negative("tolerance", params.tolerance)?;
        check_impulses(impulses)?;
        let mut work = packed.start(level, q, impulses);
        let iterations = match params.method {
            SolverMethod::GaussSeidel => gauss_seidel::solve(packed, &mut work, params),
            SolverMethod::AveragedJacobi => jacobi::solve(packed, &mut work, params),
            SolverMethod::ConjugateGradient => conjugate_gradient::solve(packed, &mut work, params),
        };
        let slots = slots::cells(&mut work.q);
        let residual = packed.residual(&work.bias, &work.impulses, work.has_friction, slots);
        check::particles(level.name(), packed.particle_count, &work.q)?;
        packed.finish(&work, q, impulses);
        let converged = residual <= params.tolerance;
        Ok(SolveReport { iterations, residual, converged, immovable: packed.immovable() })
    }
}

impl SolveLevel {
    fn name(self) -> &'static str {
        match self {
            Self::Position => "displacement",
            Self::Velocity => "velocity",
            Self::Acceleration => "acceleration",
        }
    }
}

fn check_impulses(impulses: &[Impulse]) -> Result<(), ResponseError> {
    impulses.iter().enumerate().try_for_each(|(row, impulse)| {
        check::contact_number(row, "impulse", impulse.normal)?;
        check::contact_vector(row, "impulse", impulse.tangent)?;
        Ok(())
    })
}
