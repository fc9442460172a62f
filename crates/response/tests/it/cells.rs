//! Every cell of the table of corrections, against the formula written out in
//! the coordinates of a contact whose normal is an axis, then turned.

use glam::{DQuat, DVec3};
use response::{
    ExplicitEuler, FaceFrame, Friction, ImplicitEuler, ImplicitMidpoint, Integrator, Margins,
    Reaction, Reference, RelativeMotion, RelativeState, Restraint, Spring, StepLength,
    SymplecticEuler, Taylor, TimeStep, distribute,
};

use crate::common::{self, number, vector};

/// A state with its numbers in the frame whose third axis is the normal.
struct Planted {
    turn: DQuat,
    state: RelativeState,
    p: DVec3,
    v: DVec3,
    a: DVec3,
    kept: f64,
    proximity: f64,
}

fn planted(u: &mut arbitrary::Unstructured<'_>) -> arbitrary::Result<Planted> {
    let turn = DQuat::from_rotation_z(number(u, -3.0, 3.0)?)
        * DQuat::from_rotation_x(number(u, -3.0, 3.0)?)
        * DQuat::from_rotation_y(number(u, -3.0, 3.0)?);
    let (p, v, a) = (vector(u, 2.0)?, vector(u, 3.0)?, vector(u, 5.0)?);
    let (offset, clearance, proximity) =
        (number(u, 0.0, 1.0)?, number(u, 0.0, 0.5)?, number(u, 0.1, 2.0)?);
    let motion = RelativeMotion { position: turn * p, velocity: turn * v, acceleration: turn * a };
    let margins = Margins::new(clearance, proximity).expect("in range");
    let state = RelativeState::new(motion, turn * DVec3::Z, offset, margins).expect("finite");
    Ok(Planted { turn, state, p, v, a, kept: offset + clearance, proximity })
}

impl Planted {
    fn depth(&self) -> f64 {
        self.p.z + self.kept
    }

    fn lambda(&self) -> f64 {
        if self.depth() >= 0.0 {
            1.0
        } else if self.depth() <= -self.proximity {
            0.0
        } else {
            1.0 + self.depth() / self.proximity
        }
    }

    #[track_caller]
    fn check(&self, found: DVec3, expected: DVec3) {
        let error = (self.turn.inverse() * found - expected).length();
        assert!(error < 1e-12 * (1.0 + expected.length()), "{found} is not {expected} turned");
    }
}

#[test]
fn depth_and_factor() {
    fixtures::generate::cases(21, 1000, |u| {
        let planted = planted(u)?;
        assert!((planted.state.depth() - planted.depth()).abs() < 1e-13);
        assert!((planted.state.proximity_factor() - planted.lambda()).abs() < 1e-12);
        Ok(())
    });
}

#[test]
fn springs() {
    fixtures::generate::cases(22, 1000, |u| {
        let planted = planted(u)?;
        let h = number(u, 0.01, 1.0)?;
        let step = StepLength::new(h).expect("in range");
        let (depth, lambda) = (planted.depth(), planted.lambda());
        let active = if depth > 0.0 { 1.0 } else { 0.0 };
        let rows = [
            (Spring::OneSided, depth.max(0.0), active),
            (Spring::Gradual, lambda * planted.proximity, lambda),
            (Spring::TwoSided, lambda * depth, lambda),
        ];
        for (spring, push, weight) in rows {
            let state = &planted.state;
            planted.check(spring.position(state), DVec3::Z * -push);
            planted.check(spring.velocity(state, step), DVec3::Z * (-push / h));
            let to_target = DVec3::Z * (-push / h - weight * planted.v.z);
            planted.check(spring.velocity_to_target(state, step), to_target);
            planted.check(spring.acceleration(state, step), DVec3::Z * (-push / h / h));
        }
        Ok(())
    });
}

#[test]
fn gradual_spring_pushes_to_the_rim() {
    fixtures::generate::cases(23, 1000, |u| {
        let planted = planted(u)?;
        if (-planted.proximity..=0.0).contains(&planted.depth()) {
            let after = planted.depth()
                + (planted.turn.inverse() * Spring::Gradual.position(&planted.state)).z;
            assert!((after + planted.proximity).abs() < 1e-12, "{after}");
        }
        Ok(())
    });
}

#[test]
fn reactions() {
    fixtures::generate::cases(24, 1000, |u| {
        let planted = planted(u)?;
        let (share, mu) = (number(u, 0.0, 1.0)?, number(u, 0.0, 2.0)?);
        let last = vector(u, 1.0)?;
        let lambda = planted.lambda();
        let by_share = |q: DVec3| -lambda * DVec3::new(share * q.x, share * q.y, q.z.max(0.0));
        let by_coulomb = |q: DVec3| {
            let j = lambda * q.z.max(0.0);
            let slip = q.x.hypot(q.y);
            let rub = if slip > mu * j { mu * j / slip } else { 1.0 };
            -DVec3::new(rub * q.x, rub * q.y, j)
        };
        let approaching = |q: DVec3, cell: &dyn Fn(DVec3) -> DVec3| {
            if q.z > 0.0 { cell(q) } else { DVec3::ZERO }
        };
        let rules: [(Friction, &dyn Fn(DVec3) -> DVec3); 2] = [
            (Friction::share(share).expect("in range"), &by_share),
            (Friction::coulomb(mu).expect("in range"), &by_coulomb),
        ];
        for (friction, cell) in rules {
            let reaction = Reaction { friction };
            let turned = planted.turn * last;
            planted.check(reaction.position(&planted.state, turned).expect("finite"), cell(last));
            planted.check(reaction.velocity(&planted.state), approaching(planted.v, cell));
            planted.check(reaction.acceleration(&planted.state), approaching(planted.a, cell));
        }
        Ok(())
    });
}

#[test]
fn coulomb_stays_in_its_cone_turns_no_slip_and_gains_no_energy() {
    fixtures::generate::cases(25, 1000, |u| {
        let planted = planted(u)?;
        let mu = number(u, 0.0, 2.0)?;
        let reaction = Reaction { friction: Friction::coulomb(mu).expect("in range") };
        let change = planted.turn.inverse() * reaction.velocity(&planted.state);
        let after = planted.v + change;
        assert!(change.truncate().length() <= mu * change.z.abs() * (1.0 + 1e-12) + 1e-15);
        // Of turning there and back, relative to the speed.
        let rounding = 8.0 * f64::EPSILON * planted.v.length_squared();
        let kept = after.truncate().dot(planted.v.truncate());
        assert!(kept >= -rounding, "slip is not reversed");
        assert!(after.length_squared() <= planted.v.length_squared() + 1e-14);
        Ok(())
    });
}

#[test]
fn references() {
    fixtures::generate::cases(26, 1000, |u| {
        let planted = planted(u)?;
        let height = number(u, -1.0, 1.0)?;
        let state = &planted.state;
        let sticking = Reference::height(state, height, Restraint::Sticking).expect("finite");
        let sliding = Reference::height(state, height, Restraint::Sliding).expect("finite");
        let target = DVec3::Z * -height;
        planted.check(sticking.position(state), target - planted.p);
        planted.check(sticking.velocity(state), -planted.v);
        planted.check(sticking.acceleration(state), -planted.a);
        let normal = |q: DVec3| DVec3::Z * q.z;
        planted.check(sliding.position(state), normal(target - planted.p));
        planted.check(sliding.velocity(state), normal(-planted.v));
        planted.check(sliding.acceleration(state), normal(-planted.a));
        Ok(())
    });
}

#[test]
fn a_reference_in_the_face_frame_turns_with_the_face() {
    fixtures::generate::cases(27, 1000, |u| {
        let planted = planted(u)?;
        let face = [DVec3::ZERO, DVec3::new(2.0, 0.5, 0.0), DVec3::new(0.3, 1.5, 0.4)];
        let stored = FaceFrame::new(face).expect("has area").to_local(planted.p);
        let moved = face.map(|corner| planted.turn * corner + DVec3::ONE);
        let frame = FaceFrame::new(moved).expect("has area");
        let reference = Reference::in_frame(&frame, stored, Restraint::Sticking).expect("finite");
        // The whole contact has turned: nothing to restore.
        assert!(reference.position(&planted.state).length() < 1e-12);
        Ok(())
    });
    assert_eq!(FaceFrame::new([DVec3::ZERO, DVec3::X, DVec3::X * 2.0]), None);
}

/// Two steps of the second-order spring on a pair of particles reach what they
/// were requested, by the integrator the spring was made for.
fn reaches<I: Integrator>(u: &mut arbitrary::Unstructured<'_>) -> arbitrary::Result<()> {
    let h = number(u, 0.01, 0.5)?;
    let step = TimeStep::<I>::new(h).expect("in range");
    let terms = [common::term(0, -1.0), common::term(1, 1.0)];
    let w = [number(u, 0.1, 2.0)?, number(u, 0.0, 2.0)?];
    let mut x = [vector(u, 1.0)?, vector(u, 1.0)?];
    let mut v = [vector(u, 1.0)?, vector(u, 1.0)?];
    let pull = [vector(u, 1.0)?, vector(u, 1.0)?];
    let (goal, goal_speed) = (vector(u, 1.0)?, vector(u, 1.0)?);
    for _ in 0..2 {
        let mut a = step.accelerations(pull.to_vec()).expect("finite");
        let motion = RelativeMotion {
            position: x[1] - x[0],
            velocity: v[1] - v[0],
            acceleration: a.values()[1] - a.values()[0],
        };
        let margins = Margins::new(0.0, 1.0).expect("in range");
        let state = RelativeState::new(motion, DVec3::Z, 0.0, margins).expect("finite");
        let correction = step
            .second_order_spring(&state, goal - motion.position, goal_speed - motion.velocity)
            .expect("finite");
        a.correct(&terms, &w, correction).expect("one can move");
        // What the second step must add is a₂ = Δv / h − a₁.
        let first = a.values()[1] - a.values()[0];
        a.advance(&mut x, &mut v).expect("finite");
        let second = (goal_speed - motion.velocity) / h - first;
        let mut b = step.accelerations(pull.to_vec()).expect("finite");
        let missing = second - (b.values()[1] - b.values()[0]);
        distribute(&terms, &w, missing, b.values_mut()).expect("one can move");
        b.advance(&mut x, &mut v).expect("finite");
        let scale = 1e-12 / (h * h);
        assert!((x[1] - x[0] - goal).length() < scale, "{}: {}", I::NAME, x[1] - x[0] - goal);
        assert!((v[1] - v[0] - goal_speed).length() < scale, "{}", I::NAME);
    }
    Ok(())
}

#[test]
fn second_order_spring_reaches_position_and_velocity_two_steps_on() {
    fixtures::generate::cases(28, 1000, |u| {
        reaches::<ExplicitEuler>(u)?;
        reaches::<Taylor>(u)?;
        reaches::<SymplecticEuler>(u)?;
        reaches::<ImplicitEuler>(u)?;
        reaches::<ImplicitMidpoint>(u)
    });
}
