//! Bounce of a particle on a one-sided contact spring.
//!
//! The spring acts in whole steps, so the work done on the way in and out differs. The difference
//! depends on the time of first touch within a step.

use glam::DVec3;
use response::stability::Scheme;
use response::{
    ContactLaw, ContactRows, ExplicitEuler, Implicit, ImplicitEuler, ImplicitMidpoint, Integrator,
    LinearParams, Margins, NormalForce, ResponseError, SoftContacts, SoftLaw, SymplecticEuler,
    Taylor, TimeStep,
};
use surface::{Anchor, Contact, Stencil, Term};

/// Speed over that on arrival, from which on a bounce counts as an explosion.
const EXPLOSION: f64 = 1e3;

/// Steps after which a particle counts as caught: twice those of the slowest undamped bounce of
/// the picture.
const MAX_STEPS: u32 = 1000;

/// Computes the maximum speed on leaving over that on arrival, over `phases` times of first touch
/// within a step. The speed of a particle that never leaves is that of the energy left in it.
///
/// # Errors
///
/// [`ResponseError::Parameter`] when ω h or ζ is negative or not finite.
pub fn max_restitution(
    scheme: Scheme,
    omega_h: f64,
    zeta: f64,
    phases: u32,
) -> Result<f64, ResponseError> {
    let mut max: f64 = 0.0;
    for phase in 0..phases {
        let height = (f64::from(phase) + 0.5) / f64::from(phases);
        max = max.max(restitution(scheme, omega_h, zeta, height)?);
    }
    Ok(max)
}

/// Simulates one bounce: mass, step and speed of arrival are 1, and the particle starts at `height`.
fn restitution(scheme: Scheme, omega_h: f64, zeta: f64, height: f64) -> Result<f64, ResponseError> {
    // Until it leaves, explodes, or counts as caught.
    let stiffness = omega_h * omega_h;
    let normal = NormalForce::Penalty { stiffness, damping: 2.0 * zeta * omega_h };
    let law = SoftLaw::new(normal, 1.0)?;
    let (mut x, mut v) = ([DVec3::Z * height], [-DVec3::Z]);
    let mut has_touched = false;
    for _ in 0..MAX_STEPS {
        step(scheme, law, &mut x, &mut v)?;
        has_touched |= x[0].z < 0.0;
        if (has_touched && x[0].z >= 0.0 && v[0].z > 0.0) || v[0].z.abs() > EXPLOSION {
            return Ok(v[0].z.abs());
        }
    }

    let depth = (-x[0].z).max(0.0);
    Ok((v[0].z * v[0].z + stiffness * depth * depth).sqrt())
}

fn step(
    scheme: Scheme,
    law: SoftLaw,
    x: &mut [DVec3],
    v: &mut [DVec3],
) -> Result<(), ResponseError> {
    match scheme {
        Scheme::ExplicitEuler => explicit::<ExplicitEuler>(law, x, v),
        Scheme::Taylor => explicit::<Taylor>(law, x, v),
        Scheme::SymplecticEuler => explicit::<SymplecticEuler>(law, x, v),
        Scheme::ImplicitEuler => implicit::<ImplicitEuler>(law, x, v),
        Scheme::ImplicitMidpoint => implicit::<ImplicitMidpoint>(law, x, v),
    }
}

fn explicit<I: Integrator>(
    law: SoftLaw,
    x: &mut [DVec3],
    v: &mut [DVec3],
) -> Result<(), ResponseError> {
    let rows = rows(x[0])?;
    let mut force = vec![DVec3::ZERO];
    SoftContacts::new(&rows, v, law)?.add_forces(&mut force)?;
    TimeStep::<I>::new(1.0)?.accelerations(force)?.advance(x, v)
}

fn implicit<I: Implicit>(
    law: SoftLaw,
    x: &mut [DVec3],
    v: &mut [DVec3],
) -> Result<(), ResponseError> {
    let rows = rows(x[0])?;
    let soft = SoftContacts::new(&rows, v, law)?;
    let mut force = vec![DVec3::ZERO];
    soft.add_forces(&mut force)?;
    let step = TimeStep::<I>::new(1.0)?;
    let (a, _) = step.implicit_accelerations(&[1.0], &force, &soft, v, &LinearParams::default())?;
    a.advance(x, v)
}

/// Returns the contact of the particle with the fixed plane z = 0.
fn rows(x: DVec3) -> Result<ContactRows, ResponseError> {
    let contact = Contact {
        stencil: Stencil::single(Term { particle: 0, weight: -1.0 }),
        anchor: Some(Anchor { point: DVec3::new(x.x, x.y, 0.0), ..Anchor::default() }),
        normal: DVec3::Z,
        offset: 0.0,
        gap: x.z,
        time: None,
    };
    let mut rows = ContactRows::new(1);
    rows.push(&contact, ContactLaw::new(Margins::new(0.0, 1.0)?, 0.0)?)?;
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symplectic_bounces_gain_energy_and_implicit_ones_lose_it() {
        let max = |scheme, omega_h| max_restitution(scheme, omega_h, 0.0, 200).unwrap();
        // Under symplectic Euler, energy grows up to 1.05, 1.56 and 6.8 times.
        for (omega_h, energy) in [(0.5, 1.05_f64), (1.5, 1.56), (1.9, 6.8)] {
            let found = max(Scheme::SymplecticEuler, omega_h);
            assert!((found / energy.sqrt() - 1.0).abs() < 0.02, "ω h {omega_h}: {found}");
        }
        assert!(max(Scheme::ImplicitEuler, 1.0) < 0.5);
        assert!(max(Scheme::ExplicitEuler, 0.5) > 1.2);
    }
}
