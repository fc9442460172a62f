//! Limits of stability in closed form.
//!
//! With a contact spring of ω² = k / m and damping ratio ζ, a step is a linear map of (x, v) with
//! trace T and determinant D. It is stable where |T| ≤ 1 + D and D ≤ 1 (the Jury conditions). For
//! each integrator these give the limits below, as ω h.

use response::stability::Scheme;

/// Rounding of a spectral radius of 1, as an undamped spring has.
pub const ROUNDING: f64 = 1e-9;

/// Largest gain of second-order springs under an explicit integrator: the number of copies of one
/// contact that may be added up.
pub const SECOND_ORDER_GAIN: f64 = 4.0 / 3.0;

/// Largest gain of the spring's velocity ΔP / h: the step v ← v − g x / h, x ← x + h v has trace
/// 2 − g and determinant 1.
pub const SPRING_GAIN: f64 = 4.0;

/// Largest gain of a response that stops a motion in one step: g copies leave 1 − g of it.
pub const STOPPING_GAIN: f64 = 2.0;

/// Returns the largest ω h at which a contact spring of damping ratio ζ is stable: 0 if none is,
/// `None` if all are.
#[must_use]
pub fn spring(scheme: Scheme, zeta: f64) -> Option<f64> {
    match scheme {
        Scheme::ExplicitEuler if zeta <= 1.0 => Some(2.0 * zeta),
        Scheme::ExplicitEuler => Some(2.0 * (zeta - (zeta * zeta - 1.0).sqrt())),
        Scheme::Taylor => Some((4.0 * zeta).min(zeta.recip())),
        Scheme::SymplecticEuler => Some(2.0 * ((1.0 + zeta * zeta).sqrt() - zeta)),
        Scheme::ImplicitEuler | Scheme::ImplicitMidpoint => None,
    }
}

/// Returns the largest stable ω h for a stack of equal masses on equal springs, with ω and ζ of
/// one: its fastest mode is faster, and damped more, by the factor 2 cos(π / (2 n + 1)).
#[must_use]
pub fn stack(scheme: Scheme, zeta: f64, masses: u32) -> Option<f64> {
    let faster = 2.0 * (std::f64::consts::PI / (2.0 * f64::from(masses) + 1.0)).cos();
    spring(scheme, zeta * faster).map(|omega_h| omega_h / faster)
}

/// Computes the largest v h / `d_max` at which a reaction of velocity and acceleration stops a
/// particle shot from the rim, under g h² / `d_max`.
///
/// At the share s of the region's width a step covers s (u + σ g) of it, where u is the speed
/// before the reaction and σ the integrator's share, and leaves the speed s (u + g). The particle
/// crosses where u + σ g > 1.
#[must_use]
pub fn reaction(scheme: Scheme, gravity: f64) -> Option<f64> {
    let share = match scheme {
        Scheme::ExplicitEuler => 0.0,
        Scheme::Taylor | Scheme::ImplicitMidpoint => 0.5,
        Scheme::SymplecticEuler | Scheme::ImplicitEuler => 1.0,
    };
    let stops = |approach: f64| {
        let (mut s, mut u) = (1.0, approach);
        (0..super::reaction::STEPS).all(|_| {
            let covered = u + share * gravity;
            u = s * (u + gravity);
            s *= 1.0 - covered;
            covered <= 1.0
        })
    };
    response::stability::limit(0.0, 2.0, 1e-9, |approach| Ok::<_, ()>(stops(approach))).ok()?
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stacks_lower_the_limit_to_one() {
        for (masses, known) in [(1, 2.0), (2, 1.236), (5, 1.042), (10, 1.011), (50, 1.0005)] {
            let limit = stack(Scheme::SymplecticEuler, 0.0, masses).unwrap();
            assert!((limit - known).abs() < 6e-4, "{masses} masses: {limit}");
        }
    }
}
