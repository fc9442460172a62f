//! Rows with targets: every row of the table of corrections by every solver, alone and in closed
//! form.

use glam::DVec3;
use response::{
    Constraint, ContactLaw, ContactRows, ContactSystem, Friction, Impulse, Margins, Reaction,
    Reference, RelativeState, Restraint, SolveLevel, SolverMethod, SolverParams, Spring,
    SpringDamper, StepLength, SweepOrder, SymplecticEuler, TimeStep, distribute,
};
use surface::{Anchor, Contact, Stencil};

use crate::common::{self, LEVELS, METHODS, Stream, law, on_plane, solve_by, term};

/// A vertex-face contact in motion, with one fixed particle among five.
struct Scene {
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    a: Vec<DVec3>,
    w: Vec<f64>,
    contact: Contact,
    margins: Margins,
}

impl Scene {
    /// The depth is within the proximity region or beyond it, by the seed.
    fn new(seed: u64) -> Self {
        let mut s = Stream(seed);
        let mut list = || -> Vec<DVec3> {
            (0..5).map(|_| DVec3::new(s.next(), s.next(), s.next()) - 0.5).collect()
        };
        let (x, v, a) = (list(), list(), list());
        let w = vec![0.5 + s.next(), 1e-3, 0.0, 1.0 + s.next(), 1.0];
        let normal = DVec3::new(s.next(), s.next(), 1.0 + s.next()).normalize();
        let stencil = Stencil::vertex_face(0, [1, 2, 3], [0.5, 0.2, 0.3]);
        let height = -stencil.combine(|k| x[k as usize]).dot(normal);
        let contact = common::contact(stencil, normal, height);
        let margins = Margins::new(height + s.next() - 0.3, 0.5);
        let margins = margins.unwrap_or(Margins::new(0.0, 1.0).expect("in range"));
        Self { x, v, a, w, contact, margins }
    }

    fn state(&self) -> RelativeState {
        RelativeState::of(&self.contact, [&self.x, &self.v, &self.a], self.margins).expect("finite")
    }

    fn law(&self, friction: Friction) -> ContactLaw {
        ContactLaw::new(self.margins, 0.0).expect("in range").with_friction(friction)
    }

    /// Values of a level before the correction; displacements of the last step for positions.
    fn values(&self, level: SolveLevel) -> Vec<DVec3> {
        match level {
            SolveLevel::Position => vec![DVec3::ZERO; 5],
            SolveLevel::Velocity => self.v.clone(),
            SolveLevel::Acceleration => self.a.clone(),
        }
    }

    /// Compares the solution of one row with the distribution of its cell.
    fn check(
        &self,
        level: SolveLevel,
        start: &[DVec3],
        friction: Friction,
        constraint: Constraint,
        cell: DVec3,
    ) {
        let mut expected = start.to_vec();
        distribute(self.contact.stencil.terms(), &self.w, cell, &mut expected).expect("valid");
        for method in METHODS {
            let has_disc = friction.coefficient() > 0.0;
            if has_disc && method == SolverMethod::ConjugateGradient {
                continue;
            }
            let mut rows = ContactRows::new(5);
            rows.push_constraint(&self.contact, self.law(friction), constraint).expect("valid");
            let mut q = start.to_vec();
            let report = solve_by(&rows, &self.w, level, &mut q, method);
            assert!(report.converged, "{method:?} {constraint:?}: {report:?}");
            for (found, expected) in q.iter().zip(&expected) {
                let error = (*found - *expected).length();
                assert!(error < 1e-11, "{method:?} {level:?} {constraint:?} {friction:?}: {error}");
            }
        }
    }
}

#[test]
fn springs_are_rows_at_all_levels() {
    let h = StepLength::new(0.1).expect("in range");
    for seed in 0..40 {
        let scene = Scene::new(seed);
        let state = scene.state();
        for spring in [Spring::OneSided, Spring::Gradual, Spring::TwoSided] {
            let cells = [
                (SolveLevel::Position, spring.position(&state)),
                (SolveLevel::Velocity, spring.velocity(&state, h)),
                (SolveLevel::Velocity, spring.velocity_to_target(&state, h)),
                (SolveLevel::Acceleration, spring.acceleration(&state, h)),
            ];
            for (level, cell) in cells {
                let values = scene.values(level);
                let two_sided = Constraint::two_sided(&state, level, cell);
                scene.check(level, &values, Friction::NONE, two_sided, cell);
                // A push alone is the same one-sided; a pull is left out.
                let one_sided = Constraint::one_sided(&state, level, cell);
                let pushes = cell.dot(state.normal()) < 0.0;
                let cell = if pushes { cell } else { DVec3::ZERO };
                scene.check(level, &values, Friction::NONE, one_sided, cell);
            }
        }
    }
}

#[test]
fn references_and_second_order_springs_are_rows() {
    let step = TimeStep::<SymplecticEuler>::new(0.1).expect("in range");
    for seed in 0..40 {
        let scene = Scene::new(seed);
        let state = scene.state();
        for restraint in [Restraint::Sticking, Restraint::Sliding] {
            let reference = Reference::height(&state, 0.3, restraint).expect("finite");
            let (position, velocity) = (reference.position(&state), reference.velocity(&state));
            let second = step.second_order_spring(&state, position, velocity).expect("finite");
            let cells = [
                (SolveLevel::Position, position),
                (SolveLevel::Velocity, velocity),
                (SolveLevel::Acceleration, reference.acceleration(&state)),
                (SolveLevel::Acceleration, second.change()),
            ];
            for (level, cell) in cells {
                let (constraint, cell) = match restraint {
                    Restraint::Sticking => (Constraint::vector(&state, level, cell), cell),
                    Restraint::Sliding => {
                        (Constraint::two_sided(&state, level, cell), state.normal_part(cell))
                    }
                };
                scene.check(level, &scene.values(level), Friction::NONE, constraint, cell);
            }
        }
    }
}

#[test]
fn reactions_are_rows_with_either_friction() {
    let frictions = [
        Friction::NONE,
        Friction::share(0.4).expect("in range"),
        Friction::coulomb(0.3).expect("in range"),
        Friction::static_dynamic(0.8, 0.2).expect("in range"),
    ];
    for seed in 0..60 {
        let scene = Scene::new(seed);
        let state = scene.state();
        for friction in frictions {
            let reaction = Reaction { friction };
            // The contact's own constraint is the reaction, for velocities and accelerations.
            let of_contact = [
                (SolveLevel::Velocity, reaction.velocity(&state)),
                (SolveLevel::Acceleration, reaction.acceleration(&state)),
            ];
            for (level, cell) in of_contact {
                scene.check(level, &scene.values(level), friction, Constraint::Contact, cell);
            }

            // Positions: the last displacement is taken back.
            let moved: Vec<DVec3> = scene.v.iter().map(|v| 0.1 * *v).collect();
            let last = scene.contact.stencil.combine(|k| moved[k as usize]);
            let cell = reaction.position(&state, last).expect("finite");
            let constraint = Constraint::OneSided((last + cell).dot(state.normal()));
            scene.check(SolveLevel::Position, &moved, friction, constraint, cell);
        }
    }
}

#[test]
fn residuals_are_told_by_condition() {
    // Particle 0 approaches and slips at 1, particle 1 is off its target by 2.
    let contacts = [on_plane(0, DVec3::ZERO, DVec3::Z), on_plane(1, DVec3::ZERO, DVec3::Z)];
    let mut rows = ContactRows::new(2);
    rows.push(&contacts[0], law(0.5)).expect("valid");
    rows.push_constraint(&contacts[1], law(0.0), Constraint::TwoSided(2.0)).expect("valid");
    let system = ContactSystem::new(&rows, &[1.0; 2], SweepOrder::Given).expect("valid");
    let solve = |impulse: Impulse| {
        let mut v = [DVec3::new(1.0, 0.0, -1.0), DVec3::ZERO];
        let mut impulses = [impulse, Impulse::default()];
        let none = SolverParams { max_iterations: 0, ..SolverParams::default() };
        system.solve(SolveLevel::Velocity, &mut v, &mut impulses, &none).expect("valid").conditions
    };
    let cold = solve(Impulse::default());
    assert_eq!((cold.equality, cold.complementarity, cold.cone), (2.0, 1.0, 0.5));
    // Enough of a push, and none of the friction that it permits.
    let pushed = solve(Impulse { normal: 1.0, tangent: DVec3::ZERO });
    assert_eq!((pushed.equality, pushed.complementarity, pushed.cone), (2.0, 0.0, 0.5));
    // Too much of a push: it is to be taken back, with the friction.
    let beyond = solve(Impulse { normal: 3.0, tangent: DVec3::X * -1.0 });
    assert_eq!((beyond.complementarity, beyond.max()), (2.0, 2.0));
}

#[test]
fn compliant_rows_are_implicit_springs_at_all_levels() {
    let (m, k, c, h) = (2.0, 700.0, 3.0, StepLength::new(0.03).expect("in range"));
    let spring = SpringDamper::new(k, c).expect("in range");
    let law = law(0.0).with_compliance(spring.compliance(h)).expect("in range");
    let dt = h.get();
    let (x0, v0) = (DVec3::new(0.2, -0.1, -0.4), DVec3::new(1.0, 0.5, 2.0));

    // Implicit Euler of each coordinate.
    let expected = (m * v0 - k * dt * x0) / (m + c * dt + k * dt * dt);
    let contact = Contact {
        anchor: Some(Anchor::default()),
        ..common::contact(Stencil::single(term(0, -1.0)), DVec3::Z, 0.0)
    };
    for method in METHODS {
        for level in LEVELS {
            let start = match level {
                SolveLevel::Position => dt * v0,
                SolveLevel::Velocity => v0,
                SolveLevel::Acceleration => DVec3::ZERO,
            };
            // P_c = −x: its elongation is that of the spring.
            let target = spring.vector_target(level, h, -x0, -v0);
            let mut rows = ContactRows::new(1);
            rows.push_constraint(&contact, law, Constraint::Vector(target)).expect("valid");
            let mut q = [start];
            assert!(solve_by(&rows, &[1.0 / m], level, &mut q, method).converged);
            let found = match level {
                SolveLevel::Position => q[0] / dt,
                SolveLevel::Velocity => q[0],
                SolveLevel::Acceleration => v0 + dt * q[0],
            };
            assert!(
                (found - expected).length() < 1e-11,
                "{method:?} {level:?}: {found} {expected}"
            );
        }
    }
}

#[test]
fn a_soft_reference_holds_its_place_against_a_tangential_load() {
    let (k, load, h) = (500.0, DVec3::new(3.0, -2.0, -1.0), StepLength::new(0.01).expect("valid"));
    let spring = SpringDamper::new(k, 20.0).expect("in range");
    let law = law(0.0).with_compliance(spring.compliance(h)).expect("in range");
    let (mut x, mut v) = (DVec3::ZERO, DVec3::ZERO);
    for _ in 0..2000 {
        v += h.get() * load;
        let contact = on_plane(0, x, DVec3::Z);
        let target = spring.vector_target(SolveLevel::Velocity, h, -x, -v);
        let mut rows = ContactRows::new(1);
        rows.push_constraint(&contact, law, Constraint::Vector(target)).expect("valid");
        let mut q = [v];
        solve_by(&rows, &[1.0], SolveLevel::Velocity, &mut q, SolverMethod::GaussSeidel);
        v = q[0];
        x += h.get() * v;
    }
    assert!((x - load / k).length() < 1e-9 && v.length() < 1e-9, "{x} instead of {}", load / k);
}

#[test]
fn a_static_coefficient_holds_what_the_dynamic_one_lets_slide() {
    let (angle, gravity, h) = (25.0_f64.to_radians(), 9.81, 1e-3);
    let normal = DVec3::new(angle.sin(), 0.0, angle.cos());
    let down = DVec3::new(angle.cos(), 0.0, -angle.sin());
    // tan 25° = 0.466.
    let friction = Friction::static_dynamic(0.5, 0.3).expect("in range");
    for (start, acceleration) in [(0.0, 0.0), (1.0, gravity * (angle.sin() - 0.3 * angle.cos()))] {
        let (mut x, mut v) = (DVec3::ZERO, start * down);
        for _ in 0..1000 {
            v -= DVec3::Z * gravity * h;
            let mut rows = ContactRows::new(1);
            rows.push(&on_plane(0, x, normal), law(0.0).with_friction(friction)).expect("valid");
            let mut q = [v];
            solve_by(&rows, &[1.0], SolveLevel::Velocity, &mut q, SolverMethod::GaussSeidel);
            v = q[0];
            x += h * v;
        }
        let found = v.dot(down) - start;
        assert!((found - acceleration).abs() < 1e-9, "from {start}: {found} {acceleration}");
    }
}
