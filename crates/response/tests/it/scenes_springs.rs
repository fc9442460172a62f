//! Springs, soft and hard, within and beyond the limits of each integrator, with the
//! answers in closed form.

use glam::DVec3;
use response::stability::{HardRow, Holding, Scheme, StabilityCase, limit};
use response::{
    ContactRows, ImplicitEuler, Integrator, LinearForces, LinearParams, Margins, NormalForce,
    Reference, Restraint, SoftContacts, SoftLaw, SymplecticEuler, Taylor, TimeStep,
};

use crate::common::{self, law, on_plane, over_plane, rows, term, tower};

/// Radius over 1 that is rounding: an undamped spring has exactly 1.
const ROUNDING: f64 = 1e-9;

fn limit_of(scheme: Scheme, holding: impl Fn(f64) -> Holding, high: f64) -> Option<f64> {
    let stable = |at: f64| {
        StabilityCase { scheme, holding: holding(at) }
            .radius()
            .map(|radius| radius <= 1.0 + ROUNDING)
    };
    limit(1e-4, high, 1e-4, stable).expect("parameters in range")
}

fn penalty(zeta: f64) -> impl Fn(f64) -> Holding {
    move |omega_h| Holding::Penalty { omega_h, zeta }
}

#[test]
fn limit_of_a_penalty_under_symplectic_euler() {
    for (zeta, expected) in [(0.0, 2.0), (0.1, 1.810), (0.7, 1.041), (1.0, 0.828), (2.0, 0.472)] {
        let found = limit_of(Scheme::SymplecticEuler, penalty(zeta), 10.0).unwrap();
        let formula = 2.0 * (f64::sqrt(1.0 + zeta * zeta) - zeta);
        assert!((found / formula - 1.0).abs() < 1e-3, "ζ {zeta}: {found}, not {formula}");
        assert!((found - expected).abs() < 1e-3, "ζ {zeta}: {found}, not {expected}");
    }
}

#[test]
fn limit_of_a_penalty_under_explicit_euler() {
    assert_eq!(limit_of(Scheme::ExplicitEuler, penalty(0.0), 10.0), None, "no step is stable");
    for zeta in [0.1, 0.5, 1.0, 2.0_f64] {
        let under = 2.0 * zeta;
        let over = 2.0 * (zeta - (zeta * zeta - 1.0).max(0.0).sqrt());
        let expected = if zeta <= 1.0 { under } else { over };
        let found = limit_of(Scheme::ExplicitEuler, penalty(zeta), 10.0).unwrap();
        assert!((found / expected - 1.0).abs() < 1e-3, "ζ {zeta}: {found}, not {expected}");
    }
}

#[test]
fn implicit_penalties_have_no_limit() {
    for scheme in [Scheme::ImplicitEuler, Scheme::ImplicitMidpoint] {
        for omega_h in [0.01, 1.0, 2.5, 1e3] {
            let case = StabilityCase { scheme, holding: penalty(0.0)(omega_h) };
            let radius = case.radius().unwrap();
            assert!(radius <= 1.0 + ROUNDING, "{scheme:?} at {omega_h}: {radius}");
        }
    }
    // Explicit integrators without damping: Taylor has none either.
    assert_eq!(limit_of(Scheme::Taylor, penalty(0.0), 10.0), None);
}

/// Forces of a tower on springs that pull too, k = m = 1, at positions `x`.
fn springs(x: &[DVec3]) -> ContactRows {
    rows(x.len(), &tower(x), law(0.0))
}

fn two_sided(stiffness: f64, damping: f64) -> SoftLaw {
    SoftLaw::new(NormalForce::TwoSided { stiffness, damping }, 1.0).expect("in range")
}

fn resting(count: usize) -> Vec<DVec3> {
    let mut height = -1.0;
    std::iter::repeat_with(|| {
        height += 1.0;
        DVec3::Z * height
    })
    .take(count)
    .collect()
}

/// The fastest mode of the tower, by powers of K.
fn fastest_mode(count: usize) -> Vec<DVec3> {
    let x = resting(count);
    let rows = springs(&x);
    let soft =
        SoftContacts::new(&rows, &vec![DVec3::ZERO; count], two_sided(1.0, 0.0)).expect("valid");
    let mut mode: Vec<DVec3> =
        (0..count).map(|k| if k % 2 == 0 { DVec3::Z } else { DVec3::Z * -0.9 }).collect();
    for _ in 0..3000 {
        let mut next = vec![DVec3::ZERO; count];
        soft.add_stiffness(&mode, &mut next);
        let norm = next.iter().map(|q| q.length_squared()).sum::<f64>().sqrt();
        mode = next.iter().map(|q| *q / -norm).collect();
    }
    mode
}

/// Returns true if a tower stays bounded when it starts in `mode` with steps `h`.
fn tower_is_stable(mode: &[DVec3], h: f64) -> bool {
    let rest = resting(mode.len());
    let mut x: Vec<DVec3> = rest.iter().zip(mode).map(|(x, q)| *x + 1e-3 * *q).collect();
    let mut v = vec![DVec3::ZERO; mode.len()];
    let step = TimeStep::<SymplecticEuler>::new(h).expect("valid");
    for _ in 0..400 {
        let rows = springs(&x);
        let soft = SoftContacts::new(&rows, &v, two_sided(1.0, 0.0)).expect("valid");
        let mut force = vec![DVec3::ZERO; mode.len()];
        soft.add_forces(&mut force).expect("valid");
        step.accelerations(force).expect("valid").advance(&mut x, &mut v).expect("valid");
        if x.iter().zip(&rest).any(|(x, rest)| (*x - *rest).length() > 1.0) {
            return false;
        }
    }
    true
}

#[test]
fn a_stack_lowers_the_limit_to_one() {
    for (count, expected) in [(1, 2.0), (2, 1.236), (5, 1.042), (10, 1.011), (50, 1.0005)] {
        let mode = fastest_mode(count);
        let stable = |h: f64| Ok::<_, ()>(tower_is_stable(&mode, h));
        let found = limit(0.5, 3.0, 2e-3, stable).unwrap().unwrap();
        assert!((found / expected - 1.0).abs() < 0.01, "{count} masses: {found}, not {expected}");
    }
}

#[test]
fn a_stack_sinks_by_its_weight() {
    let (count, stiffness, gravity) = (10, 1000.0, 9.81);
    let mut x = resting(count);
    let mut v = vec![DVec3::ZERO; count];
    let step = TimeStep::<ImplicitEuler>::new(1.0).unwrap();
    for _ in 0..300 {
        let rows = springs(&x);
        let soft = SoftContacts::new(&rows, &v, two_sided(stiffness, 0.0)).unwrap();
        let mut force = vec![DVec3::Z * -gravity; count];
        soft.add_forces(&mut force).unwrap();
        let params = LinearParams::default();
        let (a, report) =
            step.implicit_accelerations(&vec![1.0; count], &force, &soft, &v, &params).unwrap();
        assert!(report.converged, "{report:?}");
        a.advance(&mut x, &mut v).unwrap();
    }
    let n = 10.0;
    let (bottom, total) = (n * gravity / stiffness, 0.5 * n * (n + 1.0) * gravity / stiffness);
    assert!((-x[0].z / bottom - 1.0).abs() < 1e-6, "{} sunk, not {bottom}", -x[0].z);
    let sunk = 9.0 - x[9].z;
    assert!((sunk / total - 1.0).abs() < 1e-6, "{sunk} sunk, not {total}");
}

/// Energy after one bounce over that before, dropped from 1 plus `extra`.
fn bounce(omega_h: f64, extra: f64) -> f64 {
    let (h, gravity) = (1e-3, 9.81);
    let stiffness = (omega_h / h) * (omega_h / h);
    let law = SoftLaw::new(NormalForce::Penalty { stiffness, damping: 0.0 }, 1.0).expect("valid");
    let step = TimeStep::<SymplecticEuler>::new(h).expect("valid");
    let (mut x, mut v) = ([DVec3::Z * (1.0 + extra)], [DVec3::ZERO]);
    let energy = |x: DVec3, v: DVec3| 0.5 * v.length_squared() + gravity * x.z;
    let before = energy(x[0], v[0]);
    let mut touched = false;
    for _ in 0..2000 {
        let rows = rows(1, &[on_plane(0, x[0], DVec3::Z)], common::law(0.0));
        let soft = SoftContacts::new(&rows, &v, law).expect("valid");
        let mut force = vec![DVec3::Z * -gravity];
        soft.add_forces(&mut force).expect("valid");
        step.accelerations(force).expect("valid").advance(&mut x, &mut v).expect("valid");
        touched |= x[0].z < 0.0;
        if touched && x[0].z > 0.0 {
            break;
        }
    }
    energy(x[0], v[0]) / before
}

#[test]
fn a_one_sided_penalty_gains_energy_below_its_limit() {
    let spread = |omega_h: f64| {
        let phases = (0..200).map(|phase| f64::from(phase) / 200.0 * 4.43e-3);
        phases
            .map(|extra| bounce(omega_h, extra))
            .fold((f64::INFINITY, 0.0_f64), |(low, high), e| (low.min(e), high.max(e)))
    };
    // Least and most over 200 phases of the first touch.
    for (omega_h, low, high) in [(0.5, 0.957, 1.049), (1.5, 0.644, 1.559), (1.9, 0.155, 6.77)] {
        let found = spread(omega_h);
        assert!((found.0 - low).abs() < 0.01, "ω h {omega_h}: {found:?}, not {low}");
        assert!((found.1 / high - 1.0).abs() < 0.01, "ω h {omega_h}: {found:?}, not {high}");
    }
}

#[test]
fn implicit_euler_damps_an_impact() {
    let expected =
        [(0.05, 0.924), (0.2, 0.731), (0.5, 0.456), (1.0, 0.250), (2.0, 0.088), (10.0, 0.0003)];
    for (omega_h, restitution) in expected {
        let stiffness: f64 = omega_h * omega_h;
        let law = SoftLaw::new(NormalForce::Penalty { stiffness, damping: 0.0 }, 1.0).unwrap();
        let step = TimeStep::<ImplicitEuler>::new(1.0).unwrap();
        // As deep as rounding, so that the first step is already held.
        let (mut x, mut v) = ([DVec3::Z * -1e-12], [-DVec3::Z]);
        for _ in 0..20_000 {
            let rows = rows(1, &[on_plane(0, x[0], DVec3::Z)], common::law(0.0));
            let soft = SoftContacts::new(&rows, &v, law).unwrap();
            let mut force = vec![DVec3::ZERO];
            soft.add_forces(&mut force).unwrap();
            let params = LinearParams::default();
            let (a, _) = step.implicit_accelerations(&[1.0], &force, &soft, &v, &params).unwrap();
            a.advance(&mut x, &mut v).unwrap();
            if x[0].z > 0.0 {
                break;
            }
        }
        assert!((v[0].z - restitution).abs() < 6e-4, "{omega_h}: {}, not {restitution}", v[0].z);
    }
}

#[test]
fn a_first_order_spring_oscillates_or_diverges() {
    let expected = [
        (Scheme::SymplecticEuler, 1.0),
        (Scheme::Taylor, 1.5_f64.sqrt()),
        (Scheme::ExplicitEuler, 2.0_f64.sqrt()),
        (Scheme::ImplicitEuler, 0.5_f64.sqrt()),
    ];
    for (scheme, expected) in expected {
        let radius =
            StabilityCase { scheme, holding: Holding::FirstOrder { gain: 1.0 } }.radius().unwrap();
        assert!((radius - expected).abs() < 1e-6, "{scheme:?}: {radius}, not {expected}");
    }
}

#[test]
fn a_second_order_spring_stops_at_once_and_copies_diverge() {
    let explicit = [Scheme::ExplicitEuler, Scheme::Taylor, Scheme::SymplecticEuler];
    for scheme in explicit {
        let expected = [
            (0.5, 0.5_f64.sqrt()),
            (1.0, 0.0),
            (1.5, 1.366),
            (2.0, 1.0 + 2.0_f64.sqrt()),
            (3.0, 4.449),
        ];
        for (gain, expected) in expected {
            let radius =
                StabilityCase { scheme, holding: Holding::SecondOrder { gain } }.radius().unwrap();
            // A double eigenvalue 0 is found to the root of rounding.
            assert!(
                (radius - expected).abs() < 1e-3,
                "{scheme:?} × {gain}: {radius}, not {expected}"
            );
        }
        let found = limit_of(scheme, |gain| Holding::SecondOrder { gain }, 3.0).unwrap();
        assert!((found / (4.0 / 3.0) - 1.0).abs() < 1e-3, "{scheme:?}: {found}");
    }
    for scheme in [Scheme::ImplicitEuler, Scheme::ImplicitMidpoint] {
        for gain in [0.5, 1.0, 2.0, 3.0, 80.0] {
            let radius =
                StabilityCase { scheme, holding: Holding::SecondOrder { gain } }.radius().unwrap();
            assert!(radius < 1.0, "{scheme:?} × {gain}: {radius}");
        }
    }
}

/// Growth a step by so many copies of a row.
type Growth = fn(f64) -> f64;

/// That of a spring that also stops: x' = x + v', v' = (1 − n) v − n x, of which
/// trace / 2 and determinant both are 1 − n.
fn stops(n: f64) -> f64 {
    let left = 1.0 - n;
    let root = left * left - left;
    if root < 0.0 { left.abs().sqrt() } else { left.abs() + root.sqrt() }
}

#[test]
fn copies_of_hard_rows_have_limits_that_no_integrator_changes() {
    // With the most copies that hold.
    let rows: [(HardRow, f64, Growth); 3] = [
        (HardRow::Spring, 4.0, |_| 1.0),
        (HardRow::SpringToTarget, 4.0 / 3.0, stops),
        (HardRow::Reference, 2.0, |n| (1.0 - n).abs()),
    ];
    for scheme in Scheme::ALL {
        for (row, most, growth) in rows {
            for gain in [0.5, 1.0, 1.3] {
                let case = StabilityCase { scheme, holding: Holding::Hard { row, gain } };
                let (radius, expected) = (case.radius().unwrap(), growth(gain));
                assert!((radius - expected).abs() < 1e-6, "{case:?}: {radius}, not {expected}");
            }
            let found = limit_of(scheme, |gain| Holding::Hard { row, gain }, 6.0).unwrap();
            assert!((found / most - 1.0).abs() < 1e-3, "{scheme:?}, {row:?}: {found}, not {most}");
        }
        for gain in [0.5, 1.0, 1.5, 3.0] {
            let holding = Holding::Hard { row: HardRow::Reaction, gain };
            let [x, v] = StabilityCase { scheme, holding }.step([-0.5, -1.0]).unwrap();
            // v' = (1 − n) v, and the depth stays.
            assert!((v + 1.0 - gain).abs() < 1e-15 && (x + 0.5 - v).abs() < 1e-15, "{x} {v}");
            let away = StabilityCase { scheme, holding }.step([-0.5, 1.0]).unwrap();
            assert!((away[1] - 1.0).abs() < 1e-15, "what leaves is let go: {away:?}");
        }
    }
}

/// Held by the second-order spring of `C` while moved by `M`; the types keep
/// these apart, so the change is carried over by hand.
fn after_steps<C: Integrator, M: Integrator>(
    gravity: f64,
    includes_gravity: bool,
    steps: usize,
) -> (f64, f64) {
    let h = 0.01;
    let (made, moved) =
        (TimeStep::<C>::new(h).expect("valid"), TimeStep::<M>::new(h).expect("valid"));
    let margins = Margins::new(0.0, 1.0).expect("valid");
    let (mut x, mut v) = ([DVec3::Z * 0.002], [DVec3::Z * 0.3]);
    for _ in 0..steps {
        let mut state = over_plane(x[0], v[0], DVec3::Z, margins);
        if includes_gravity {
            let mut motion = state.motion();
            motion.acceleration = DVec3::Z * gravity;
            state = response::RelativeState::new(motion, DVec3::Z, 0.0, margins).expect("valid");
        }
        let held = Reference::height(&state, 0.0, Restraint::Sliding).expect("valid");
        let correction = made
            .second_order_spring(&state, held.position(&state), held.velocity(&state))
            .expect("valid");
        let mut a = vec![DVec3::Z * -gravity];
        response::distribute(&[term(0, -1.0)], &[1.0], correction.change(), &mut a).expect("valid");
        moved.accelerations(a).expect("valid").advance(&mut x, &mut v).expect("valid");
    }
    (x[0].z, v[0].z)
}

#[test]
fn coefficients_of_another_integrator_never_settle() {
    let (x, v) = after_steps::<Taylor, SymplecticEuler>(0.0, true, 2000);
    assert!(x.abs() + 0.01 * v.abs() > 1e-4, "still ringing: {x} {v}");
    for (x, v) in [
        after_steps::<Taylor, Taylor>(0.0, true, 2),
        after_steps::<SymplecticEuler, SymplecticEuler>(0.0, true, 2),
        after_steps::<response::ExplicitEuler, response::ExplicitEuler>(0.0, true, 2),
    ] {
        assert!(x.abs() < 1e-15 && v.abs() < 1e-13, "dead after two steps: {x} {v}");
    }
}

#[test]
fn a_second_order_spring_sags_without_the_other_accelerations() {
    let (x, v) = after_steps::<SymplecticEuler, SymplecticEuler>(9.81, false, 50);
    assert!((x + 9.81e-4).abs() < 1e-12 && v.abs() < 1e-9, "sags by g h²: {x} {v}");
    let (x, _) = after_steps::<Taylor, Taylor>(9.81, false, 50);
    assert!((x + 9.81e-4).abs() < 1e-12, "sags by g h²: {x}");
    let (x, _) = after_steps::<Taylor, Taylor>(9.81, true, 50);
    assert!(x.abs() < 1e-12, "no sag with gravity in A_c: {x}");
}
