//! Implicit steps: accelerations at the end or the middle of the step.
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

use crate::{Accelerations, Implicit, LinearForces, ResponseError, TimeStep, check};

/// How hard the linear solution tries.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LinearParams {
    /// Steps at most.
    pub max_iterations: u32,
    /// Residual that is left, as a share of the right side, `>= 0`.
    pub tolerance: f64,
}

impl Default for LinearParams {
    /// 1e-10 of the right side keeps the momentum to as much; a visual result
    /// needs 1e-3.
    fn default() -> Self {
        Self { max_iterations: 1000, tolerance: 1e-10 }
    }
}

/// How the linear solution went.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LinearReport {
    /// Steps done.
    pub iterations: u32,
    /// What is left, as a share of the right side.
    pub residual: f64,
    /// Whether that is within the tolerance.
    pub converged: bool,
}

impl<I: Implicit> TimeStep<I> {
    /// Accelerations Δv / h of a step under the forces `force`, whose
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
    /// when the solution is not finite. Not converging is no error: see the
    /// report.
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
        let (h, sigma) = (self.length().get(), I::POSITION_SHARE);
        let right = right_side(force, forces, v, inverse_mass, [h, sigma * h * h]);
        let product = |dv: &[DVec3], out: &mut [DVec3]| {
            system_product(forces, inverse_mass, [sigma * h, sigma * sigma * h * h], dv, out);
        };
        let (change, report) = conjugate_gradient(product, inverse_mass, right, params);
        let accelerations = change.into_iter().map(|dv| dv / h).collect();
        Ok((self.accelerations(accelerations)?, report))
    }
}

/// h f + σ h² K v, zero for fixed particles.
fn right_side(
    force: &[DVec3],
    forces: &impl LinearForces,
    v: &[DVec3],
    inverse_mass: &[f64],
    [by_force, by_stiffness]: [f64; 2],
) -> Vec<DVec3> {
    let mut right = vec![DVec3::ZERO; v.len()];
    forces.add_stiffness(v, &mut right);
    for ((right, force), w) in right.iter_mut().zip(force).zip(inverse_mass) {
        *right = if *w > 0.0 { by_force * *force + by_stiffness * *right } else { DVec3::ZERO };
    }
    right
}

/// (M − a C − b K) dv, zero for fixed particles.
fn system_product(
    forces: &impl LinearForces,
    inverse_mass: &[f64],
    [by_damping, by_stiffness]: [f64; 2],
    dv: &[DVec3],
    out: &mut [DVec3],
) {
    let mut damped = vec![DVec3::ZERO; dv.len()];
    forces.add_damping(dv, &mut damped);
    out.fill(DVec3::ZERO);
    forces.add_stiffness(dv, out);
    for (((out, damped), dv), w) in out.iter_mut().zip(damped).zip(dv).zip(inverse_mass) {
        *out = if *w > 0.0 {
            *dv / *w - by_damping * damped - by_stiffness * *out
        } else {
            DVec3::ZERO
        };
    }
}

/// Solves A x = b, preconditioned by the masses, from x = 0.
fn conjugate_gradient(
    product: impl Fn(&[DVec3], &mut [DVec3]),
    inverse_mass: &[f64],
    mut residual: Vec<DVec3>,
    params: &LinearParams,
) -> (Vec<DVec3>, LinearReport) {
    let mut x = vec![DVec3::ZERO; residual.len()];
    let scaled =
        |r: &[DVec3]| -> Vec<DVec3> { r.iter().zip(inverse_mass).map(|(r, w)| *r * *w).collect() };
    let mut direction = scaled(&residual);
    let mut along = vec![DVec3::ZERO; residual.len()];
    let start = dot(&residual, &direction);
    let mut square = start;
    let mut iterations = 0;
    let share = |square: f64| if start > 0.0 { (square / start).sqrt() } else { 0.0 };
    while iterations < params.max_iterations && share(square) > params.tolerance {
        product(&direction, &mut along);
        let curvature = dot(&direction, &along);
        if curvature <= 0.0 {
            break;
        }
        iterations += 1;
        let step = square / curvature;
        add(&mut x, step, &direction);
        add(&mut residual, -step, &along);
        let preconditioned = scaled(&residual);
        let next = dot(&residual, &preconditioned);
        let turn = next / square;
        square = next;
        direction.iter_mut().zip(preconditioned).for_each(|(d, r)| *d = r + turn * *d);
    }
    let residual = share(square);
    (x, LinearReport { iterations, residual, converged: residual <= params.tolerance })
}

fn add(to: &mut [DVec3], factor: f64, of: &[DVec3]) {
    to.iter_mut().zip(of).for_each(|(to, of)| *to += factor * *of);
}

fn dot(a: &[DVec3], b: &[DVec3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum()
}
