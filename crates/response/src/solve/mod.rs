//! Coupled contacts: solvers for rows that share particles.
//!
//! Corrections of contacts that share particles add up: on a patch of 80
//! contacts over 24 particles, the sum of the single corrections raises the
//! kinetic energy many times over. A [`ContactSystem`] corrects them together,
//! by one of three methods:
//!
//! - **Projected Gauss–Seidel** with accumulated impulses (the default): one
//!   row after the other; a normal impulse never pulls, and friction stays
//!   within Coulomb's disc. Source: the sequential impulses of game physics,
//!   and M. Jean, "The non-smooth contact dynamics method", CMAME 177, 1999.
//! - **Averaged Jacobi** (mass splitting): all rows at once, each with 1/n of the mass of
//!   a particle that n rows share. Source: R. Tonge, F. Benevolenski and
//!   A. Voroshilov, "Mass splitting for jitter-free parallel rigid body
//!   simulation", ACM TOG 31(4), 2012. Unlike averaging the corrections of each
//!   particle, this keeps the momentum.
//! - **Conjugate gradients** on the equality of the two-sided rows and of the one-sided rows
//!   that push, whichever these are. Source: P. Volino and N. Magnenat-Thalmann, "Accurate
//!   collision response on polygonal meshes", Computer Animation, 2000; the active set
//!   follows Z. Dostál, "Optimal Quadratic Programming Algorithms", Springer 2009. No
//!   Coulomb friction. Preconditioned by incomplete Cholesky factors of the rows' matrix, which
//!   are exact for chains and trees of rows. The best method for many rows that share
//!   particles, and for masses that differ much.
//!
//! With Q_c = Σ β_k q_k + b the relative motion of a row, n its normal, t its target, α its
//! compliance and p, j ⟂ n its accumulated impulses, all three change the particles by
//! q_k −= β_k (p n + j) / m_k, which keeps the momentum to rounding. The change of one row
//! is, with D = Σ β² / m,
//!
//! ```text
//! p ← project(p + ((Q_c − t) · n − α p) / (D + α))
//! ```
//!
//! | row | normal impulse | tangential impulse |
//! |---|---|---|
//! | [`Constraint::Contact`], [`OneSided`](crate::Constraint::OneSided) | p >= 0 | by friction |
//! | [`Constraint::TwoSided`] | any | by friction |
//! | [`Constraint::Vector`] | any | any |
//!
//! | friction | tangential impulse |
//! |---|---|
//! | Coulomb | \|j\| <= µ_s p, else µ_d p along the slip |
//! | the source's share | along the slip at the start, in 0..=κ p: until (1 − µ λ) of that slip is left |
//!
//! κ is the ratio of the tangential impulse to the normal one that the row has alone. Two-sided
//! rows, and rows on displacements, have no such limit.
//!
//! [`Constraint::Contact`]: crate::Constraint::Contact
//! [`Constraint::TwoSided`]: crate::Constraint::TwoSided
//! [`Constraint::Vector`]: crate::Constraint::Vector

mod cholesky;
mod coloring;
mod conjugate_gradient;
mod gauss_seidel;
mod jacobi;
mod packed;
mod parts;
mod row_graph;
mod slots;

use glam::DVec3;

use self::conjugate_gradient::GradientMemory;
use self::jacobi::JacobiMemory;
use self::packed::{PackedSystem, SolverState};
use self::slots::cells;
use crate::{ContactRows, ResponseError, SolveLevel, check};

/// Order of the rows in a Gauss–Seidel sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum SweepOrder {
    /// In batches that share no particle, each in the order given. Run in
    /// parallel with the feature `rayon`, in the caller's pool; the result has
    /// the same bits without it and for any number of threads.
    #[default]
    Colored,
    /// As given: from the support upward, a stack settles faster.
    Given,
}

/// Method that solves contacts together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum SolverMethod {
    /// Projected Gauss–Seidel.
    #[default]
    GaussSeidel,
    /// Averaged Jacobi.
    AveragedJacobi,
    /// Conjugate gradients, without Coulomb friction.
    ConjugateGradient,
}

/// Settings of a solver.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SolverParams {
    /// Method that solves contacts together.
    pub method: SolverMethod,
    /// Maximum number of sweeps or steps.
    pub max_iterations: u32,
    /// Largest change of a row at which a solver ends, in the unit of the unknowns,
    /// `>= 0`.
    pub tolerance: f64,
}

impl Default for SolverParams {
    /// Returns ten sweeps of Gauss–Seidel: enough for persistent contacts with a warm
    /// start. A tolerance of 0 ends earlier only where nothing changes.
    fn default() -> Self {
        Self { method: SolverMethod::GaussSeidel, max_iterations: 10, tolerance: 0.0 }
    }
}

/// Accumulated impulses of one row on P; those on P̄ are opposite. In mass times the unit
/// of the unknowns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Impulse {
    /// p, along the normal; `>= 0` for a one-sided row.
    pub normal: f64,
    /// j, perpendicular to the normal; `|j| <= µ p` under Coulomb's law.
    pub tangent: DVec3,
}

/// Report of a solution.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SolveReport {
    /// Number of sweeps or steps.
    pub iterations: u32,
    /// Largest change that one row alone still requires, in the unit of the unknowns.
    pub residual: f64,
    /// The same by condition.
    pub conditions: Residual,
    /// True if the residual is within the tolerance.
    pub converged: bool,
    /// Number of rows left out because none of their particles can move, or only by impulses
    /// beyond the range of numbers.
    pub immovable: usize,
}

/// Residual of the natural map: the largest change of Q_c that one row alone still requires,
/// by the condition that it leaves unmet, in the unit of the unknowns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Residual {
    /// Of two-sided rows and vectors: distance from the target.
    pub equality: f64,
    /// Of one-sided rows: a remaining approach, or a push that is not needed.
    pub complementarity: f64,
    /// Of friction: a slip that Coulomb's disc or the source's share forbids, or an impulse beyond
    /// their limits.
    pub cone: f64,
}

impl Residual {
    /// Returns the largest of all.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.equality.max(self.complementarity).max(self.cone)
    }

    /// Raises each to that of another row.
    fn include(&mut self, other: &Self) {
        self.equality = self.equality.max(other.equality);
        self.complementarity = self.complementarity.max(other.complementarity);
        self.cone = self.cone.max(other.cone);
    }
}

/// Memory of a solver, which a sequence of solutions reuses.
#[derive(Clone, Debug, Default)]
pub struct SolverMemory {
    state: SolverState,
    jacobi: JacobiMemory,
    gradient: GradientMemory,
}

/// Contact rows and inverse masses, prepared for solving.
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
#[derive(Clone, Debug, Default)]
pub struct ContactSystem {
    system: PackedSystem,
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
        let mut system = Self::default();
        system.rebuild(rows, inverse_mass, order)?;
        Ok(system)
    }

    /// Prepares other rows in the same memory.
    ///
    /// # Errors
    ///
    /// As [`Self::new`], with the former rows unchanged.
    pub fn rebuild(
        &mut self,
        rows: &ContactRows,
        inverse_mass: &[f64],
        order: SweepOrder,
    ) -> Result<(), ResponseError> {
        check::inverse_masses(rows.particle_count(), inverse_mass)?;
        self.system.rebuild(rows, inverse_mass, order);
        Ok(())
    }

    /// Returns the number of batches of rows that share no particle; 1 for
    /// [`SweepOrder::Given`].
    #[must_use]
    pub fn batch_count(&self) -> usize {
        self.system.batches().len()
    }

    /// Returns one zero impulse per row: a cold start.
    #[must_use]
    pub fn no_impulses(&self) -> Vec<Impulse> {
        vec![Impulse::default(); self.system.row_count]
    }

    /// Corrects `q`: displacements, velocities or accelerations of all
    /// particles.
    ///
    /// `impulses`, one per row, hold the start and are replaced by the result: keep them
    /// for the next step ([`ImpulseCache`]). Displacements are measured from the state in
    /// which the contacts were detected: 0 where that is the end of a step, the whole
    /// step's where it is the start. Friction takes back the slip of the latter, and of
    /// the former the slip by other contacts' pushes.
    ///
    /// Exceeding the tolerance is no error: see [`SolveReport`].
    ///
    /// # Errors
    ///
    /// With `q` and `impulses` unchanged:
    /// - [`ResponseError::Count`] or [`ResponseError::ParticleNotFinite`] for
    ///   `q`, also when the result would not be finite;
    /// - [`ResponseError::ContactNotFinite`] for an impulse;
    /// - [`ResponseError::Parameter`] for a negative tolerance.
    ///
    /// [`ImpulseCache`]: crate::ImpulseCache
    pub fn solve(
        &self,
        level: SolveLevel,
        q: &mut [DVec3],
        impulses: &mut [Impulse],
        params: &SolverParams,
    ) -> Result<SolveReport, ResponseError> {
        self.solve_in(&mut SolverMemory::default(), level, q, impulses, params)
    }

    /// As [`Self::solve`], in memory that is reused: allocates nothing once it has grown to
    /// the system, but for rows that are swept in parallel.
    ///
    /// # Errors
    ///
    /// As [`Self::solve`].
    pub fn solve_in(
        &self,
        memory: &mut SolverMemory,
        level: SolveLevel,
        q: &mut [DVec3],
        impulses: &mut [Impulse],
        params: &SolverParams,
    ) -> Result<SolveReport, ResponseError> {
        let system = &self.system;
        check::particles(level.name(), system.particle_count, q)?;
        check::count("impulses", system.row_count, impulses.len())?;
        check::not_negative("tolerance", params.tolerance)?;
        check_impulses(impulses)?;

        // Solve on copies, so that an error leaves the caller's lists unchanged.
        let SolverMemory { state, jacobi, gradient } = memory;
        system.start(level, q, impulses, state);
        let iterations = match params.method {
            SolverMethod::GaussSeidel => gauss_seidel::solve(system, state, params),
            SolverMethod::AveragedJacobi => jacobi::solve(system, state, params, jacobi),
            SolverMethod::ConjugateGradient => {
                conjugate_gradient::solve(system, state, params, gradient, jacobi)
            }
        };
        let conditions = state.residual(system);

        check::particles(level.name(), system.particle_count, &state.q)?;
        system.finish(state, q, impulses);
        let residual = conditions.max();
        let converged = residual <= params.tolerance;
        let immovable = system.immovable();
        Ok(SolveReport { iterations, residual, conditions, converged, immovable })
    }
}

impl SolverState {
    /// Computes the largest changes that any row alone still requires.
    fn residual(&mut self, system: &PackedSystem) -> Residual {
        system.residual(&self.goals, &self.impulses, cells(&mut self.q))
    }
}

fn check_impulses(impulses: &[Impulse]) -> Result<(), ResponseError> {
    for (row, impulse) in impulses.iter().enumerate() {
        check::contact_number(row, "impulse", impulse.normal)?;
        check::contact_vector(row, "impulse", impulse.tangent)?;
    }
    Ok(())
}
