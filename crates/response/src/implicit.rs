//! Implicit integration: accelerations at the end or the middle of the step.
//!
//! With f, K = ∂f/∂x, C = ∂f/∂v at the start and σ the integrator's position
//! share (1 for Euler, ½ for the midpoint), the change of velocity solves
//!
//! ```text
//! (M − σ h C − σ² h² K) Δv = h f + σ h² K v
//! ```
//!
//! by conjugate gradients over the particles that can move.
//!
//! Source: D. Baraff and A. Witkin, "Large steps in cloth simulation",
//! SIGGRAPH 1998, sections 3 and 5; one Newton step, as there.

use glam::DVec3;
use surface::vectors::{add_scaled, dot};

use crate::{Accelerations, Implicit, LinearForces, ResponseError, TimeStep, check};

/// Settings of the linear solver.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LinearParams {
    /// Maximum number of steps.
    pub max_iterations: u32,
    /// Residual at which the solver ends, relative to the right side, `>= 0`.
    pub tolerance: f64,
}

impl Default for LinearParams {
    /// Returns a tolerance of 1e-10, which keeps the momentum to as much; a visual result
    /// needs 1e-3.
    fn default() -> Self {
        Self { max_iterations: 1000, tolerance: 1e-10 }
    }
}

/// Report of the linear solver.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LinearReport {
    /// Number of steps.
    pub iterations: u32,
    /// Residual relative to the right side.
    pub residual: f64,
    /// True if the residual is within the tolerance.
    pub converged: bool,
}

impl<I: Implicit> TimeStep<I> {
    /// Computes the accelerations Δv / h of a step under the forces `force`, whose
    /// derivatives are `forces`, from the velocities `v`.
    ///
    /// `inverse_mass` is 0 for a fixed particle, which keeps its velocity.
    ///
    /// ```
    /// use glam::DVec3;
    /// use response::{ImplicitEuler, LinearForces, TimeStep};
    ///
    /// /// A spring to the origin, f = −k x, far too stiff for an explicit step.
    /// struct Spring(f64);
    /// impl LinearForces for Spring {
    ///     fn add_stiffness(&self, dx: &[DVec3], out: &mut [DVec3]) {
    ///         out[0] -= self.0 * dx[0];
    ///     }
    ///     fn add_damping(&self, _: &[DVec3], _: &mut [DVec3]) {}
    /// }
    /// let (mut x, mut v) = (vec![DVec3::X], vec![DVec3::ZERO]);
    /// let spring = Spring(1e9);
    /// let step = TimeStep::<ImplicitEuler>::new(0.01)?;
    /// for _ in 0..20 {
    ///     let force = [-spring.0 * x[0]];
    ///     let (a, report) =
    ///         step.implicit_accelerations(&[1.0], &force, &spring, &v, &Default::default())?;
    ///     assert!(report.converged);
    ///     a.advance(&mut x, &mut v)?;
    /// }
    /// assert!(x[0].length() < 1e-9);
    /// # Ok::<(), response::ResponseError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`ResponseError::Count`], [`ResponseError::InverseMass`] or
    /// [`ResponseError::ParticleNotFinite`] with the first value refused, also
    /// when the solution is not finite. A residual above the tolerance is no error: see
    /// the report.
    pub fn implicit_accelerations(
        self,
        inverse_mass: &[f64],
        force: &[DVec3],
        forces: &impl LinearForces,
        v: &[DVec3],
        params: &LinearParams,
    ) -> Result<(Accelerations<I>, LinearReport), ResponseError> {
        check::inverse_masses(v.len(), inverse_mass)?;
        check::particles("force", v.len(), force)?;
        check::particles("velocity", v.len(), v)?;
        check::not_negative("tolerance", params.tolerance)?;

        // One linear solve per step, from rest.
        let (h, sigma) = (self.length().get(), I::POSITION_SHARE);
        let system =
            System { forces, inverse_mass, damping: sigma * h, stiffness: sigma * sigma * h * h };
        let right = system.right_side(force, v, h, sigma * h * h);
        let (mut change, report) = system.conjugate_gradient(right, params);
        for dv in &mut change {
            *dv /= h;
        }
        Ok((self.accelerations(change)?, report))
    }
}

/// Linear system (M − a C − b K) Δv = r over the particles that can move.
struct System<'a, F> {
    forces: &'a F,
    inverse_mass: &'a [f64],
    /// a.
    damping: f64,
    /// b.
    stiffness: f64,
}

impl<F: LinearForces> System<'_, F> {
    /// Computes c f + d K v, zero for fixed particles.
    fn right_side(&self, force: &[DVec3], v: &[DVec3], c: f64, d: f64) -> Vec<DVec3> {
        let mut right = vec![DVec3::ZERO; v.len()];
        self.forces.add_stiffness(v, &mut right);
        for ((right, force), w) in right.iter_mut().zip(force).zip(self.inverse_mass) {
            *right = if *w > 0.0 { c * *force + d * *right } else { DVec3::ZERO };
        }
        right
    }

    /// Computes (M − a C − b K) dv, zero for fixed particles.
    fn product(&self, dv: &[DVec3], out: &mut [DVec3]) {
        let mut damped = vec![DVec3::ZERO; dv.len()];
        self.forces.add_damping(dv, &mut damped);
        out.fill(DVec3::ZERO);
        self.forces.add_stiffness(dv, out);
        for (((out, damped), dv), w) in out.iter_mut().zip(damped).zip(dv).zip(self.inverse_mass) {
            *out = if *w > 0.0 {
                *dv / *w - self.damping * damped - self.stiffness * *out
            } else {
                DVec3::ZERO
            };
        }
    }

    /// Solves for Δv by conjugate gradients from 0, preconditioned by the masses.
    ///
    /// Steps carry the residual along, and it drifts by rounding: it is computed anew where it
    /// seems to be within the tolerance, and steps begin again while that helps.
    fn conjugate_gradient(
        &self,
        right: Vec<DVec3>,
        params: &LinearParams,
    ) -> (Vec<DVec3>, LinearReport) {
        let start = self.square(&right);
        let mut x = vec![DVec3::ZERO; right.len()];
        let (mut residual, mut remaining) = (right.clone(), relative(start, start));
        let mut iterations = 0;

        while iterations < params.max_iterations && remaining > params.tolerance {
            let mut trial = x.clone();
            let limit = params.max_iterations - iterations;
            iterations += self.descend(&mut trial, &mut residual, start, limit, params.tolerance);

            // The residual itself, without drift; a descent that does not lower it was the last.
            self.product(&trial, &mut residual);
            for (residual, right) in residual.iter_mut().zip(&right) {
                *residual = *right - *residual;
            }
            let left = relative(self.square(&residual), start);
            let is_lower = left < remaining;
            if is_lower || iterations >= params.max_iterations {
                (x, remaining) = (trial, left);
            }
            if !is_lower {
                break;
            }
        }
        let converged = remaining <= params.tolerance;
        (x, LinearReport { iterations, residual: remaining, converged })
    }

    /// Descends from `x` until the residual that is carried along is within the tolerance, relative
    /// to `start`; returns the steps.
    fn descend(
        &self,
        x: &mut [DVec3],
        residual: &mut [DVec3],
        start: f64,
        max_iterations: u32,
        tolerance: f64,
    ) -> u32 {
        let mut direction = self.precondition(residual);
        let mut along = vec![DVec3::ZERO; residual.len()];
        let mut square = dot(residual, &direction);
        let mut iterations = 0;

        // Step along the direction to the minimum of the quadratic form.
        while iterations < max_iterations && relative(square, start) > tolerance {
            self.product(&direction, &mut along);
            let curvature = dot(&direction, &along);
            if curvature <= 0.0 {
                break;
            }
            iterations += 1;
            let step = square / curvature;
            add_scaled(x, step, &direction);
            add_scaled(residual, -step, &along);

            // The next direction is conjugate to all earlier ones.
            let preconditioned = self.precondition(residual);
            let next = dot(residual, &preconditioned);
            let turn = next / square;
            square = next;
            for (d, r) in direction.iter_mut().zip(preconditioned) {
                *d = r + turn * *d;
            }
        }
        iterations
    }

    /// Computes the square of a residual in the measure of the preconditioner.
    fn square(&self, residual: &[DVec3]) -> f64 {
        dot(residual, &self.precondition(residual))
    }

    fn precondition(&self, r: &[DVec3]) -> Vec<DVec3> {
        r.iter().zip(self.inverse_mass).map(|(r, w)| *r * *w).collect()
    }
}

/// Computes the root of a square relative to that at the start; 0 where both are 0.
fn relative(square: f64, start: f64) -> f64 {
    if start > 0.0 { (square / start).sqrt() } else { 0.0 }
}
