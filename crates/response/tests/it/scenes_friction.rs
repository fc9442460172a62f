//! Friction and barriers on slopes and floors.

use glam::DVec3;
use response::{
    ContactSystem, Friction, ImplicitEuler, LinearParams, Margins, NormalForce, Reaction,
    ResponseError, SoftContacts, SoftLaw, SolveLevel, SolverParams, SweepOrder, TimeStep,
    distribute,
};
use surface::Stencil;

use crate::common::{law, on_plane, over_plane, rows, solve, term, thorough};

const GRAVITY: f64 = 9.81;

/// Normal of a slope of `degrees`, and the direction down it.
fn slope(degrees: f64) -> [DVec3; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [DVec3::new(sin, 0.0, cos), DVec3::new(cos, 0.0, -sin)]
}

/// Speed down the slope and way gone after `seconds`, with the velocity
/// corrected by `correct` after gravity.
fn slide(
    degrees: f64,
    h: f64,
    seconds: f64,
    mut correct: impl FnMut(DVec3, &mut [DVec3]),
) -> [f64; 2] {
    let [_, down] = slope(degrees);
    let (mut x, mut v) = (DVec3::ZERO, [DVec3::ZERO]);
    let mut time = 0.0;
    while time < seconds - 0.5 * h {
        v[0].z -= GRAVITY * h;
        correct(x, &mut v);
        x += h * v[0];
        time += h;
    }
    [v[0].dot(down), x.dot(down)]
}

#[test]
fn friction_by_share_creeps_down_any_slope() {
    let (normal, mu) = (slope(20.0)[0], 0.5);
    let margins = Margins::new(0.0, 1.0).unwrap();
    for (h, expected) in [(1e-3, 3.355e-3), (1e-2, 33.55e-3)] {
        let reaction = Reaction { friction: Friction::share(mu).unwrap() };
        let [speed, _] = slide(20.0, h, 2.0, |x, v| {
            let state = over_plane(x, v[0], normal, margins);
            distribute(&[term(0, -1.0)], &[1.0], reaction.velocity(&state), v).unwrap();
        });
        let formula = GRAVITY * 20_f64.to_radians().sin() * h * (1.0 - mu) / mu;
        assert!((speed / formula - 1.0).abs() < 1e-9, "h {h}: {speed}, not {formula}");
        assert!((speed / expected - 1.0).abs() < 1e-3, "h {h}: {speed}, not {expected}");
    }
}

#[test]
fn friction_by_share_creeps_as_fast_by_displacements() {
    let ([normal, down], mu) = (slope(20.0), 0.5);
    let margins = Margins::new(0.0, 1.0).unwrap();
    let reaction = Reaction { friction: Friction::share(mu).unwrap() };
    for (h, expected) in [(1e-3, 3.355e-3), (1e-2, 33.55e-3)] {
        let (mut x, mut v) = ([DVec3::ZERO], DVec3::ZERO);
        for _ in 0..200 {
            let before = x[0];
            v.z -= GRAVITY * h;
            x[0] += h * v;
            let state = over_plane(x[0], v, normal, margins);
            // P̄ is on the fixed plane, so P_c changes by what P moves back.
            let change = reaction.position(&state, before - x[0]).unwrap();
            distribute(&[term(0, -1.0)], &[1.0], change, &mut x).unwrap();
            v = (x[0] - before) / h;
        }
        let speed = v.dot(down);
        assert!((speed / expected - 1.0).abs() < 1e-3, "h {h}: {speed}, not {expected}");
        assert!(x[0].dot(normal).abs() < 1e-12, "stays on the slope: {}", x[0]);
    }
}

fn coulomb_slide(degrees: f64, mu: f64, h: f64, seconds: f64) -> [f64; 2] {
    let [normal, _] = slope(degrees);
    slide(degrees, h, seconds, |x, v| {
        let rows = rows(1, &[on_plane(0, x, normal)], law(mu));
        let system = ContactSystem::new(&rows, &[1.0], SweepOrder::Given).expect("valid");
        let mut impulses = system.no_impulses();
        let params = SolverParams::default();
        let report = system.solve(SolveLevel::Velocity, v, &mut impulses, &params).expect("valid");
        assert!(report.residual < 1e-12, "{report:?}");
    })
}

#[test]
fn coulomb_sticks_up_to_the_angle_and_then_slides() {
    let (mu, h) = (0.5, 1e-3);
    let angle = f64::atan(mu).to_degrees();
    for degrees in [5.0, 20.0, angle - 0.01] {
        let [speed, way] = coulomb_slide(degrees, mu, h, 2.0);
        assert!(speed.abs() < 1e-15 && way.abs() < 1e-13, "{degrees}°: {speed} {way}");
    }
    for (degrees, expected, gone) in
        [(27.0, 0.0833, 0.1665), (30.0, 0.6571, 1.3143), (45.0, 3.4684, 6.9367)]
    {
        let [speed, way] = coulomb_slide(degrees, mu, h, 2.0);
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        let a = GRAVITY * (sin - mu * cos);
        assert!((a - expected).abs() < 6e-5, "{degrees}°: {a}");
        assert!((speed - 2.0 * a).abs() < 1e-9, "{degrees}°: {speed}, not {}", 2.0 * a);
        // x = a t² / 2 + a t h / 2 by symplectic steps.
        assert!((way - 2.0 * a - a * h).abs() < 1e-9, "{degrees}°: {way}");
        assert!((way - gone).abs() < 0.004, "{degrees}°: {way}, not {gone}");
    }
    let [above, _] = coulomb_slide(angle + 0.01, mu, h, 2.0);
    assert!(above > 0.0, "slides just above the angle");
}

/// As [`coulomb_slide`], by displacements: contacts found before the move hold
/// the whole step's back.
fn displaced_slide(degrees: f64, mu: f64, h: f64, steps: u32) -> [f64; 2] {
    let [normal, down] = slope(degrees);
    let (mut x, mut v) = (DVec3::ZERO, DVec3::ZERO);
    for _ in 0..steps {
        v.z -= GRAVITY * h;
        let mut moved = [h * v];
        let contacts = [on_plane(0, x, normal)];
        let report =
            solve(SolveLevel::Position, &mut moved, &[1.0], &contacts, law(mu), &thorough());
        assert!(report.converged, "{report:?}");
        x += moved[0];
        v = moved[0] / h;
    }
    [v.dot(down), x.dot(down)]
}

#[test]
fn coulomb_holds_displacements_as_velocities() {
    let (mu, h) = (0.5, 1e-3);
    for degrees in [5.0, 20.0, f64::atan(mu).to_degrees() - 0.01] {
        let [speed, way] = displaced_slide(degrees, mu, h, 2000);
        assert!(speed.abs() < 1e-12 && way.abs() < 1e-13, "{degrees}°: {speed} {way}");
    }
    for (degrees, a) in [(27.0, 0.0833), (30.0, 0.6571), (45.0, 3.4684)] {
        let [speed, way] = displaced_slide(degrees, mu, h, 2000);
        assert!((speed - 2.0 * a).abs() < 2e-4, "{degrees}°: {speed}, not {}", 2.0 * a);
        assert!((way - 2.0 * a).abs() < 0.004, "{degrees}°: {way}");
    }
}

#[test]
fn smooth_friction_creeps_at_a_fraction_of_its_slip_speed() {
    let (mu, slip_speed, h) = (0.5, 1e-3, 1e-2);
    let [normal, down] = slope(20.0);
    // Pressed on by a spring that carries the weight exactly.
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let stiffness = 1e4;
    let depth = GRAVITY * cos / stiffness;
    let normal_force = NormalForce::Penalty { stiffness, damping: 0.0 };
    let soft_law = SoftLaw::new(normal_force, slip_speed).unwrap();
    let step = TimeStep::<ImplicitEuler>::new(h).unwrap();
    let (mut x, mut v) = ([normal * -depth], [DVec3::ZERO]);
    for _ in 0..500 {
        let rows = rows(1, &[on_plane(0, x[0], normal)], law(mu));
        let soft = SoftContacts::new(&rows, &v, soft_law).unwrap();
        let mut force = vec![DVec3::Z * -GRAVITY];
        soft.add_forces(&mut force).unwrap();
        let params = LinearParams::default();
        let (a, _) = step.implicit_accelerations(&[1.0], &force, &soft, &v, &params).unwrap();
        a.advance(&mut x, &mut v).unwrap();
    }
    let share = 1.0 - (1.0 - sin / cos / mu).sqrt();
    let creep = v[0].dot(down) / slip_speed;
    assert!((creep - share).abs() < 1e-6 && (creep - 0.478).abs() < 1e-3, "{creep}, not {share}");
}

#[test]
fn a_barrier_rests_where_its_force_carries_the_weight() {
    // Millimetres, kilograms, seconds.
    let gravity = 9810.0;
    let step = TimeStep::<ImplicitEuler>::new(1e-3).unwrap();
    let expected = [(1e2, 0.0110), (1e3, 0.1244), (1e4, 0.5359), (1e6, 0.9439)];
    for (stiffness, gap) in expected {
        let barrier = NormalForce::Barrier { stiffness, range: 1.0 };
        let soft_law = SoftLaw::new(barrier, 1.0).unwrap();
        let (mut x, mut v) = ([DVec3::Z * gap * 1.01], [DVec3::ZERO]);
        for _ in 0..4000 {
            let rows = rows(1, &[on_plane(0, x[0], DVec3::Z)], law(0.0));
            let soft = SoftContacts::new(&rows, &v, soft_law).unwrap();
            let mut force = vec![DVec3::Z * -gravity];
            soft.add_forces(&mut force).unwrap();
            let params = LinearParams::default();
            let (a, _) = step.implicit_accelerations(&[1.0], &force, &soft, &v, &params).unwrap();
            a.advance(&mut x, &mut v).unwrap();
            v[0] *= 0.9; // settle
        }
        assert!((x[0].z - gap).abs() < 6e-5, "κ {stiffness}: {}, not {gap}", x[0].z);
    }
    let overlapped = rows(1, &[on_plane(0, DVec3::Z * -0.2, DVec3::Z)], law(0.0));
    let barrier = SoftLaw::new(NormalForce::Barrier { stiffness: 1.0, range: 1.0 }, 1.0).unwrap();
    let refused = SoftContacts::new(&overlapped, &[DVec3::ZERO], barrier).map(|_| ());
    assert_eq!(refused, Err(ResponseError::Overlapped { contact: 0, gap: -0.2 }));
}

#[test]
fn half_weights_reach_two_thirds_and_masses_the_whole() {
    let stencil = Stencil::vertex_face(0, [1, 2, 3], [1.0 / 3.0; 3]);
    let mut half = [DVec3::ZERO; 4];
    for term in stencil.terms() {
        half[term.particle as usize] += 0.5 * term.weight * DVec3::Z;
    }
    let reached = stencil.combine(|k| half[k as usize]).z;
    assert!((reached - 2.0 / 3.0).abs() < 1e-15, "{reached}");
    let mut ruled = [DVec3::ZERO; 4];
    distribute(stencil.terms(), &[1.0; 4], DVec3::Z, &mut ruled).unwrap();
    let reached = stencil.combine(|k| ruled[k as usize]).z;
    assert!((reached - 1.0).abs() < 1e-15, "{reached}");
}
