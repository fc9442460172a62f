//! Input that cannot be answered is an error that names it, and no output
//! holds a value that is not finite.

use glam::DVec3;
use response::stability::{HardRow, Holding, Scheme, StabilityCase};
use response::{
    ContactLaw, ContactRows, ContactSet, ContactStep, ContactSystem, Friction, Impulse,
    ImpulseCache, LinearParams, Margins, Material, NormalForce, ParameterError, ParticleLoads,
    ParticleStates, RelativeMotion, RelativeState, ResponseError, Restraint, RigidMotion,
    SoftContacts, SoftLaw, SolveLevel, SolverParams, SpringDamper, StepLength, StepParams,
    SweepOrder, SymplecticEuler, TimeStep,
};
use surface::{Anchor, Contact, Stencil};

use crate::common::{self, METHODS, contact, law, material, on_plane, term};

fn parameter_of<T>(result: Result<T, ResponseError>) -> Option<&'static str> {
    match result {
        Err(ResponseError::Parameter(ParameterError { name, .. })) => Some(name),
        _ => None,
    }
}

#[test]
fn parameters_outside_their_range() {
    for bad in [f64::NAN, f64::INFINITY, -1.0] {
        assert_eq!(parameter_of(Margins::new(bad, 1.0)), Some("clearance"));
        assert_eq!(parameter_of(Margins::new(0.0, bad)), Some("proximity distance"));
        assert_eq!(parameter_of(Friction::share(bad)), Some("friction share"));
        assert_eq!(parameter_of(Friction::coulomb(bad)), Some("friction coefficient"));
        assert_eq!(parameter_of(StepLength::new(bad)), Some("step length"));
        let margins = Margins::new(0.0, 1.0).unwrap();
        assert_eq!(parameter_of(ContactLaw::new(margins, bad)), Some("friction coefficient"));
        let spring = NormalForce::Penalty { stiffness: bad, damping: 0.0 };
        assert_eq!(parameter_of(SoftLaw::new(spring, 1.0)), Some("stiffness"));
        let damper = NormalForce::TwoSided { stiffness: 1.0, damping: bad };
        assert_eq!(parameter_of(SoftLaw::new(damper, 1.0)), Some("damping"));
        let barrier = NormalForce::Barrier { stiffness: 1.0, range: bad };
        assert_eq!(parameter_of(SoftLaw::new(barrier, 1.0)), Some("range"));
        let spring = NormalForce::Penalty { stiffness: 1.0, damping: 0.0 };
        assert_eq!(parameter_of(SoftLaw::new(spring, bad)), Some("slip speed"));
    }
    assert_eq!(parameter_of(Margins::new(0.0, 0.0)), Some("proximity distance"));
    assert_eq!(parameter_of(Friction::share(1.1)), Some("friction share"));
    assert_eq!(parameter_of(StepLength::new(1e-200)), Some("step length"), "1 / h² overflows");
}

#[test]
fn stability_is_of_parameters_within_their_range() {
    let gains = |gain| {
        let rows =
            [HardRow::Spring, HardRow::SpringToTarget, HardRow::Reaction, HardRow::Reference];
        let hard = rows.map(|row| Holding::Hard { row, gain });
        [Holding::FirstOrder { gain }, Holding::SecondOrder { gain }].into_iter().chain(hard)
    };
    let radius = |scheme, holding| StabilityCase { scheme, holding }.radius();
    for scheme in Scheme::ALL {
        for bad in [f64::NAN, f64::INFINITY, -1.0] {
            for holding in gains(bad) {
                assert_eq!(parameter_of(radius(scheme, holding)), Some("gain"), "{holding:?}");
            }
            let [fast, loose] = [(bad, 0.0), (1.0, bad)]
                .map(|(omega_h, zeta)| radius(scheme, Holding::Penalty { omega_h, zeta }));
            assert_eq!(parameter_of(fast), Some("frequency times step"));
            assert_eq!(parameter_of(loose), Some("damping ratio"));
        }
        assert!(gains(0.0).all(|holding| radius(scheme, holding).is_ok()));
    }
}

#[test]
fn the_proximity_factor_never_leaves_its_range() {
    let margins = Margins::new(0.0, 1e-12).unwrap();
    for depth in [-1e300, -1.0, -1e-13, 0.0, 1e-13, 1.0, 1e300] {
        let motion = RelativeMotion { position: DVec3::Z * depth, ..Default::default() };
        let state = RelativeState::new(motion, DVec3::Z, 0.0, margins).unwrap();
        assert!((0.0..=1.0).contains(&state.proximity_factor()), "{depth}");
    }
}

#[test]
fn contacts_that_are_refused() {
    let stencil = Stencil::vertex_face(0, [1, 2, 3], [0.2, 0.3, 0.5]);
    let good = contact(stencil, DVec3::Z, 0.0);
    let lone = Stencil::single(term(0, -1.0));
    let nan_anchor = Anchor { velocity: DVec3::new(0.0, f64::NAN, 0.0), ..Anchor::default() };
    let cases = [
        (
            Contact { normal: DVec3::ZERO, ..good },
            "the normal of contact 1 has length 0, but must have length 1",
        ),
        (
            Contact { normal: DVec3::Z * 1.1, ..good },
            "the normal of contact 1 has length 1.1, but must have length 1",
        ),
        (Contact { normal: DVec3::NAN, ..good }, "normal of contact 1 is NaN, which is not finite"),
        (
            Contact { gap: f64::NEG_INFINITY, ..good },
            "gap of contact 1 is -inf, which is not finite",
        ),
        (
            Contact { stencil: Stencil::vertex_face(0, [1, 2, 9], [0.2, 0.3, 0.5]), ..good },
            "contact 1 refers to particle 9, but there are 4",
        ),
        (
            Contact { stencil: Stencil::vertex_face(0, [1, 2, 3], [0.2, 0.25, 0.5]), ..good },
            "the weights of contact 1 sum to -0.050000000000000044, but must sum to 0",
        ),
        (
            Contact { stencil: Stencil::vertex_face(0, [1, 2, 3], [f64::NAN, 0.3, 0.5]), ..good },
            "weight of contact 1 is NaN, which is not finite",
        ),
        (
            Contact { stencil: lone, ..good },
            "the weights of contact 1 sum to -1, but must sum to 0",
        ),
        (
            Contact { anchor: Some(Anchor::default()), ..good },
            "the weights of contact 1 sum to 0, but must sum to -1",
        ),
        (
            Contact { stencil: lone, anchor: Some(nan_anchor), ..good },
            "anchor velocity of contact 1 is NaN, which is not finite",
        ),
    ];
    for (bad, message) in cases {
        let mut rows = ContactRows::new(4);
        let refused = rows.extend(&[good, bad], law(0.5)).unwrap_err();
        assert!(refused.to_string().starts_with(message), "{refused}, not: {message}");
        assert_eq!(rows.len(), 1, "the good one stays");
        assert_eq!(rows.row(0).terms.len(), 4);
        rows.push(&good, law(0.5)).unwrap();
        assert_eq!(rows.row(1).terms, rows.row(0).terms, "a refusal leaves nothing behind");
    }
}

#[test]
fn states_that_are_refused_leave_all_as_it_was() {
    let rows = common::rows(2, &[on_plane(0, DVec3::ZERO, DVec3::Z)], law(0.5));
    for bad in [f64::NAN, -1.0, f64::INFINITY] {
        let refused = ContactSystem::new(&rows, &[1.0, bad], SweepOrder::Given).map(|_| ());
        assert!(matches!(refused, Err(ResponseError::InverseMass { particle: 1, .. })));
    }
    let system = ContactSystem::new(&rows, &[1.0, 1.0], SweepOrder::Given).unwrap();
    for method in METHODS {
        let params = SolverParams { method, ..SolverParams::default() };
        let start = [-DVec3::Z, DVec3::new(0.0, f64::NAN, 0.0)];
        let mut v = start;
        let mut impulses = system.no_impulses();
        let refused = system.solve(SolveLevel::Velocity, &mut v, &mut impulses, &params);
        assert!(
            matches!(
                refused,
                Err(ResponseError::ParticleNotFinite { what: "velocity", particle: 1, .. })
            ),
            "{refused:?}"
        );
        assert_eq!(v[0], start[0]);
        // Finite, but not what comes of it.
        let mut v = [DVec3::Z * -1e308, DVec3::ZERO];
        let mut huge = [Impulse { normal: 1e308, tangent: DVec3::X * 1e308 }];
        match system.solve(SolveLevel::Velocity, &mut v, &mut huge, &params) {
            Ok(_) => assert!(v.iter().all(|v| v.is_finite()), "{method:?}: {v:?}"),
            Err(_) => assert_eq!(v[0], DVec3::Z * -1e308),
        }
        let mut nan = [Impulse { normal: f64::NAN, tangent: DVec3::ZERO }];
        let refused = system.solve(SolveLevel::Velocity, &mut v, &mut nan, &params);
        assert!(matches!(
            refused,
            Err(ResponseError::ContactNotFinite { contact: 0, what: "impulse", .. })
        ));
        let negative = SolverParams { tolerance: -1.0, ..params };
        let refused = system.solve(SolveLevel::Velocity, &mut v, &mut impulses, &negative);
        assert_eq!(parameter_of(refused), Some("tolerance"));
    }
    assert!(matches!(
        system.solve(
            SolveLevel::Velocity,
            &mut [DVec3::ZERO; 2],
            &mut [],
            &SolverParams::default()
        ),
        Err(ResponseError::Count { expected: 1, got: 0, .. })
    ));
    assert!(ImpulseCache::default().store(&ContactSet::default(), &[Impulse::default()]).is_err());
}

#[test]
fn rows_without_a_free_particle_are_counted_and_left() {
    let stencil = Stencil::new(&[term(0, -1.0), term(1, 1.0)]).unwrap();
    let contacts = [contact(stencil, DVec3::Z, -0.5), on_plane(2, -DVec3::Z, DVec3::Z)];
    let rows = common::rows(3, &contacts, law(0.5));
    for order in [SweepOrder::Given, SweepOrder::Colored] {
        let system = ContactSystem::new(&rows, &[0.0, 0.0, 1.0], order).unwrap();
        for method in METHODS {
            let mut moved = [DVec3::ZERO; 3];
            let params = SolverParams { method, ..SolverParams::default() };
            let mut impulses = system.no_impulses();
            let report =
                system.solve(SolveLevel::Position, &mut moved, &mut impulses, &params).unwrap();
            assert_eq!((report.immovable, report.converged), (1, true), "{method:?}");
            assert_eq!(moved, [DVec3::ZERO, DVec3::ZERO, DVec3::Z]);
            assert_eq!(impulses[0], Impulse::default());
        }
    }
}

#[test]
fn nothing_is_solved_for_nothing() {
    let system = ContactSystem::new(&ContactRows::new(0), &[], SweepOrder::Colored).unwrap();
    for method in METHODS {
        let params = SolverParams { method, ..SolverParams::default() };
        let report = system.solve(SolveLevel::Velocity, &mut [], &mut [], &params).unwrap();
        assert!(report.converged && report.immovable == 0 && report.residual == 0.0);
    }
}

#[test]
fn soft_and_implicit_refuse_what_is_not_finite() {
    let rows = common::rows(1, &[on_plane(0, DVec3::Z * -1.0, DVec3::Z)], law(0.5));
    let spring = NormalForce::Penalty { stiffness: 1e308, damping: 0.0 };
    let law = SoftLaw::new(spring, 1.0).unwrap();
    let nan = SoftContacts::new(&rows, &[DVec3::NAN], law).map(|_| ());
    assert!(matches!(nan, Err(ResponseError::ParticleNotFinite { what: "velocity", .. })));
    let deep = common::rows(1, &[on_plane(0, DVec3::Z * -1e10, DVec3::Z)], common::law(0.0));
    let overflow = SoftContacts::new(&deep, &[DVec3::ZERO], law).map(|_| ());
    assert!(matches!(overflow, Err(ResponseError::ContactNotFinite { what: "force", .. })));
    let soft = SoftContacts::new(&rows, &[DVec3::ZERO], law).unwrap();
    assert!(soft.add_forces(&mut []).is_err());
    let step = TimeStep::<response::ImplicitEuler>::new(0.1).unwrap();
    let params = LinearParams::default();
    let refused =
        step.implicit_accelerations(&[1.0], &[DVec3::NAN], &soft, &[DVec3::ZERO], &params);
    assert!(matches!(refused, Err(ResponseError::ParticleNotFinite { what: "force", .. })));
    // So stiff that the system overflows: an error or a finite answer.
    let force = [DVec3::Z * 1e308];
    if let Ok((a, _)) =
        step.implicit_accelerations(&[1e-300], &force, &soft, &[DVec3::ZERO], &params)
    {
        assert!(a.values().iter().all(|a| a.is_finite()));
    }
}

#[test]
fn steps_refuse_what_is_not_finite_and_move_nothing() {
    let step = TimeStep::<SymplecticEuler>::new(0.1).unwrap();
    assert!(step.accelerations(vec![DVec3::NAN]).is_err());
    let mut a = step.accelerations(vec![DVec3::Z]).unwrap();
    a.values_mut()[0] = DVec3::NAN;
    let (mut x, mut v) = ([DVec3::ONE], [DVec3::ONE]);
    assert!(a.advance(&mut x, &mut v).is_err());
    assert_eq!((x[0], v[0]), (DVec3::ONE, DVec3::ONE));
    let margins = Margins::new(0.0, 1.0).unwrap();
    let state = RelativeState::new(RelativeMotion::default(), DVec3::Z, 0.0, margins).unwrap();
    assert!(step.second_order_spring(&state, DVec3::NAN, DVec3::ZERO).is_err());
    let other = TimeStep::<SymplecticEuler>::new(0.2).unwrap();
    let correction = other.second_order_spring(&state, DVec3::Z, DVec3::ZERO).unwrap();
    let mut a = step.accelerations(vec![DVec3::ZERO]).unwrap();
    assert_eq!(
        a.correct(&[term(0, -1.0)], &[1.0], correction),
        Err(ResponseError::StepLength { made_for: 0.2, applied_to: 0.1 })
    );
}

#[test]
fn a_step_names_what_it_cannot_take() {
    let params = StepParams {
        push_tolerance: Some(0.0),
        ..StepParams::new(StepLength::new(0.1).expect("in range"))
    };
    let made_of = |material: Material, contact: Contact, velocity: DVec3, params: &StepParams| {
        let (mut x, mut v, mut a) = ([DVec3::ZERO], [velocity], [DVec3::ZERO]);
        let loads = ParticleLoads::Accelerations(&mut a);
        let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &[1.0] };
        let detect = |_: &[DVec3], contacts: &mut ContactSet| {
            contacts.add(0, &material, &RigidMotion::default(), &[contact]);
            Ok::<(), ResponseError>(())
        };
        ContactStep::default().correct(particles, params, detect)
    };
    let attempt =
        |contact, velocity, params: &StepParams| made_of(material(0.5), contact, velocity, params);
    let good = on_plane(0, DVec3::ZERO, DVec3::Z);
    assert!(attempt(good, -DVec3::Z, &params).is_ok());
    let nan_gap = Contact { gap: f64::NAN, ..good };
    assert!(matches!(
        attempt(nan_gap, DVec3::ZERO, &params),
        Err(ResponseError::ContactNotFinite { contact: 0, what: "gap", .. })
    ));
    assert!(matches!(
        attempt(good, DVec3::NAN, &params),
        Err(ResponseError::ParticleNotFinite { what: "velocity", .. })
    ));
    let elsewhere = Contact { stencil: Stencil::single(term(7, -1.0)), ..good };
    assert!(matches!(
        attempt(elsewhere, DVec3::ZERO, &params),
        Err(ResponseError::ParticleOutOfRange { particle: 7, .. })
    ));
    let negative = StepParams { approach_tolerance: Some(-1.0), ..params };
    let refused = attempt(good, DVec3::ZERO, &negative);
    assert_eq!(parameter_of(refused), Some("approach tolerance"));
    let spring = Some(SpringDamper::new(1.0, 0.0).expect("in range"));
    let glue = Material { spring, permanent: Some(Restraint::Sticking), ..material(0.0) };
    assert_eq!(parameter_of(made_of(glue, good, DVec3::ZERO, &params)), Some("stiffness"));
}

/// Contacts met on the way are checked as those of the positions are, whether they act or not.
#[test]
fn swept_contacts_that_are_refused() {
    let params = StepParams::new(StepLength::new(0.1).expect("in range"));
    let attempt = |material: Material, contact: Contact| {
        let (mut x, mut v, w) = ([DVec3::Z], [DVec3::Z * -100.0], [1.0]);
        let mut step = ContactStep::default();
        let loads = ParticleLoads::None;
        let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &w };
        let none = |_: &[DVec3], _: &mut ContactSet| Ok::<(), ResponseError>(());
        let mut report = step.correct(particles, &params, none).expect("valid");
        let sweep = |_: &[DVec3], contacts: &mut ContactSet| {
            contacts.add(0, &material, &RigidMotion::default(), &[contact]);
            Ok::<(), ResponseError>(())
        };
        step.correct_swept(&mut v, &w, &params, &mut report, sweep)
    };
    let good = Contact { time: Some(0.1), ..on_plane(0, DVec3::Z, DVec3::Z) };
    assert_eq!(attempt(material(0.0), good).map(|report| report.contacts), Ok(1));
    let elsewhere = Contact { stencil: Stencil::single(term(7, -1.0)), ..good };
    assert!(matches!(
        attempt(material(0.0), elsewhere),
        Err(ResponseError::ParticleOutOfRange { contact: 0, particle: 7, .. })
    ));
    let away = Contact { normal: DVec3::Z * -2.0, ..good };
    assert!(matches!(attempt(material(0.0), away), Err(ResponseError::Normal { contact: 0, .. })));
    let spring = Some(SpringDamper::new(1.0, 0.0).expect("in range"));
    let glue = Material { spring, permanent: Some(Restraint::Sticking), ..material(0.0) };
    assert_eq!(parameter_of(attempt(glue, good)), Some("stiffness"));
}

/// Rows that no finite impulse can correct are left out by all methods, and the others solved.
#[test]
fn rows_beyond_the_range_of_numbers_are_counted_and_left() {
    let free = on_plane(1, DVec3::ZERO, DVec3::Z);
    let of = |weight: f64| {
        let stencil = Stencil::new(&[term(0, -1.0 - weight), term(2, weight)]).unwrap();
        Contact { stencil, ..on_plane(0, DVec3::ZERO, DVec3::Z) }
    };
    // Inverse mass, compliance, and the weight of a fixed particle.
    let cases = [
        (1e-310, 0.0, 0.0),
        (5e-324, 0.0, 0.0),
        (1e-310, 0.0, 0.5),
        (1e-20, 1e305, 0.0),
        (1.0, f64::MAX, 0.0),
        (1.0, 0.0, 1e200),
    ];
    for (w, compliance, weight) in cases {
        let mut rows = common::rows(3, &[free], law(0.0));
        rows.push(&of(weight), law(0.0).with_compliance(compliance).unwrap()).unwrap();
        for order in [SweepOrder::Given, SweepOrder::Colored] {
            let system = ContactSystem::new(&rows, &[w, 1.0, 0.0], order).unwrap();
            for method in METHODS {
                let mut v = [-DVec3::Z, -DVec3::Z, DVec3::ZERO];
                let params = SolverParams { method, ..SolverParams::default() };
                let mut impulses = system.no_impulses();
                let report =
                    system.solve(SolveLevel::Velocity, &mut v, &mut impulses, &params).unwrap();
                assert_eq!((report.immovable, report.converged), (1, true), "{method:?}, {w:e}");
                assert_eq!(v, [-DVec3::Z, DVec3::ZERO, DVec3::ZERO], "{method:?}, {w:e}");
                assert_eq!(impulses[1], Impulse::default());
            }
        }
    }
}
