//! A particle that meets a one-sided contact spring and leaves it again.
//!
//! The spring acts in whole steps, so the work done on the way in and out
//! differs, and by how much depends on when within a step they first touch.

use glam::DVec3;
use response::stability::Scheme;
use response::{
    ContactLaw, ContactRows, ExplicitEuler, Implicit, ImplicitEuler, ImplicitMidpoint, Integrator,
    LinearParams, Margins, NormalForce, ResponseError, SoftContacts, SoftLaw, SymplecticEuler,
    Taylor, TimeStep,
};
use surface::{Anchor, Contact, Stencil, Term};

/// Speed, in speeds of arrival, from where a bounce counts as an explosion.
const EXPLODED: f64 = 1e3;

/// Steps after which a particle counts as caught, at the speed that is left:
/// twice those of the slowest undamped bounce of the picture.
const LONGEST: u32 = 1000;

/// Speed on leaving over speed on arrival, at most over `phases` times of first
/// touch within a step. What never leaves has that of the energy left in it.
///
/// # Errors
///
/// [`ResponseError::Parameter`] when ω h or ζ is negative or not finite.
pub fn worst_restitution(
    scheme: Scheme,
    omega_h: f64,
    zeta: f64,
    phases: u32,
) -> Result<f64, ResponseError> {
    let mut worst: f64 = 0.0;
    for phase in 0..phases {
        let height = (f64::from(phase) + 0.5) / f64::from(phases);
        worst = worst.max(restitution(scheme, omega_h, zeta, height)?);
    }
    Ok(worst)
}

/// The same for one bounce: mass, step and speed of arrival are 1, and the
/// particle starts at `height`.
fn restitution(scheme: Scheme, omega_h: f64, zeta: f64, height: f64) -> Result<f64, ResponseError> {
    let stiffness = omega_h * omega_h;
    let normal = NormalForce::Penalty { stiffness, damping: 2.0 * zeta * omega_h };
    let law = SoftLaw::new(normal, 1.0)?;
    let (mut x, mut v) = ([DVec3::Z * height], [-DVec3::Z]);
    let mut touched = false;
    for _ in 0..LONGEST {
        step(scheme, law, &mut x, &mut v)?;
        touched |= x[0].z < 0.0;
        if (touched && x[0].z >= 0.0 && v[0].z > 0.0) || v[0].z.abs() > EXPLODED {
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

/// The particle over the fixed plane z = 0.
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
    fn gains_below_the_linear_limit_and_deadens_when_implicit() {
        let worst = |scheme, omega_h| worst_restitution(scheme, omega_h, 0.0, 200).unwrap();
        // Under symplectic Euler energy grows up to 1.05, 1.56 and 6.8 times.
        for (omega_h, energy) in [(0.5, 1.05_f64), (1.5, 1.56), (1.9, 6.8)] {
            let found = worst(Scheme::SymplecticEuler, omega_h);
            assert!((found / energy.sqrt() - 1.0).abs() < 0.02, "ω h {omega_h}: {found}");
        }
        assert!(worst(Scheme::ImplicitEuler, 1.0) < 0.5);
        assert!(worst(Scheme::ExplicitEuler, 0.5) > 1.2);
    }
}
