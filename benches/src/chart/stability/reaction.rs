//! Reaction against a particle shot at a wall.
//!
//! The reaction begins at the rim of the proximity region, at the height `d_max` over the wall,
//! and grows toward the wall. It alters the velocity before each move and the acceleration of the
//! move itself. The particle crosses the wall if it can cover the rest of the region before the
//! next alteration.

use glam::DVec3;
use response::stability::Scheme;
use response::{
    ExplicitEuler, Friction, ImplicitEuler, ImplicitMidpoint, Integrator, Margins, Reaction,
    RelativeMotion, RelativeState, ResponseError, SymplecticEuler, Taylor, TimeStep, distribute,
};
use surface::Term;

/// Steps after which a particle that has not crossed never will: each takes a share of its height.
pub(super) const STEPS: u32 = 60;

const HELD: [Term; 1] = [Term { particle: 0, weight: -1.0 }];

/// Computes the largest depth of the particle in the region over the width of the region: up to 1
/// it does not cross.
///
/// It starts at the rim with the speed `approach` = v h / `d_max`, under `gravity` =
/// g h² / `d_max`.
///
/// # Errors
///
/// When a parameter is not finite.
pub fn max_depth(scheme: Scheme, approach: f64, gravity: f64) -> Result<f64, ResponseError> {
    match scheme {
        Scheme::ExplicitEuler => shot::<ExplicitEuler>(approach, gravity),
        Scheme::Taylor => shot::<Taylor>(approach, gravity),
        Scheme::SymplecticEuler => shot::<SymplecticEuler>(approach, gravity),
        // Nothing here depends on the position, so that the end of a step is as its beginning.
        Scheme::ImplicitEuler => shot::<ImplicitEuler>(approach, gravity),
        Scheme::ImplicitMidpoint => shot::<ImplicitMidpoint>(approach, gravity),
    }
}

/// Simulates one shot; the width of the region and the step are 1.
fn shot<I: Integrator>(approach: f64, gravity: f64) -> Result<f64, ResponseError> {
    let step = TimeStep::<I>::new(1.0)?;
    let reaction = Reaction { friction: Friction::NONE };
    let (mut x, mut v) = ([DVec3::Z], [DVec3::Z * -approach]);
    let mut min_height = x[0].z;
    for _ in 0..STEPS {
        // The reaction alters the velocity before the move, and the acceleration of the move.
        let mut a = step.accelerations(vec![DVec3::Z * -gravity])?;
        let motion =
            RelativeMotion { position: -x[0], velocity: -v[0], acceleration: -a.values()[0] };
        let state = RelativeState::new(motion, DVec3::Z, 0.0, Margins::new(0.0, 1.0)?)?;
        distribute(&HELD, &[1.0], reaction.velocity(&state), &mut v)?;
        distribute(&HELD, &[1.0], reaction.acceleration(&state), a.values_mut())?;
        a.advance(&mut x, &mut v)?;
        min_height = min_height.min(x[0].z);
        if min_height < 0.0 {
            break;
        }
    }
    Ok(1.0 - min_height)
}
