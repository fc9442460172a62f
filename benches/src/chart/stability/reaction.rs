//! A particle shot at a wall, with its approach taken off by a reaction.
//!
//! The reaction sets in at the rim of the proximity region, at the height
//! `d_max` over the wall, and takes the more off the nearer the particle is. It
//! alters the velocity before each move and the acceleration of the move
//! itself; what a step covers before the next alteration decides whether it
//! passes the wall.

use glam::DVec3;
use response::stability::Scheme;
use response::{
    ExplicitEuler, Friction, ImplicitEuler, ImplicitMidpoint, Integrator, Margins, Reaction,
    RelativeMotion, RelativeState, ResponseError, SymplecticEuler, Taylor, TimeStep, distribute,
};
use surface::Term;

/// Steps after which what has not crossed never will: it settles by a share of
/// its height each.
pub(super) const STEPS: u32 = 60;

const HELD: [Term; 1] = [Term { particle: 0, weight: -1.0 }];

/// How far into the region the particle comes over the width of the region: up
/// to 1 it does not cross. Shot from the rim with the speed `approach` =
/// v h / `d_max` under `gravity` = g h² / `d_max`.
///
/// # Errors
///
/// When a number is not finite.
pub fn deepest(scheme: Scheme, approach: f64, gravity: f64) -> Result<f64, ResponseError> {
    match scheme {
        Scheme::ExplicitEuler => shot::<ExplicitEuler>(approach, gravity),
        Scheme::Taylor => shot::<Taylor>(approach, gravity),
        Scheme::SymplecticEuler => shot::<SymplecticEuler>(approach, gravity),
        // Nothing here depends on where it acts, so that the end of a step is as its beginning.
        Scheme::ImplicitEuler => shot::<ImplicitEuler>(approach, gravity),
        Scheme::ImplicitMidpoint => shot::<ImplicitMidpoint>(approach, gravity),
    }
}

/// The width of the region and the step are 1.
fn shot<I: Integrator>(approach: f64, gravity: f64) -> Result<f64, ResponseError> {
    let step = TimeStep::<I>::new(1.0)?;
    let reaction = Reaction { friction: Friction::NONE };
    let (mut x, mut v) = ([DVec3::Z], [DVec3::Z * -approach]);
    let mut lowest = x[0].z;
    for _ in 0..STEPS {
        let mut a = step.accelerations(vec![DVec3::Z * -gravity])?;
        let motion =
            RelativeMotion { position: -x[0], velocity: -v[0], acceleration: -a.values()[0] };
        let state = RelativeState::new(motion, DVec3::Z, 0.0, Margins::new(0.0, 1.0)?)?;
        distribute(&HELD, &[1.0], reaction.velocity(&state), &mut v)?;
        distribute(&HELD, &[1.0], reaction.acceleration(&state), a.values_mut())?;
        a.advance(&mut x, &mut v)?;
        lowest = lowest.min(x[0].z);
        if lowest < 0.0 {
            break;
        }
    }
    Ok(1.0 - lowest)
}
