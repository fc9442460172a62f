//! Momentum in every scene of springs, hard corrections and friction, with the fixed
//! objects set free, so that all momentum stays in the scene.

use glam::DVec3;
use response::{
    ContactLaw, ContactRows, ExplicitEuler, Friction, Implicit, ImplicitEuler, ImplicitMidpoint,
    Integrator, LinearParams, Margins, NormalForce, Reaction, Reference, RelativeMotion,
    RelativeState, Restraint, SoftContacts, SoftLaw, SolveLevel, SolverMethod, SolverParams,
    Spring, StepLength, SymplecticEuler, Taylor, TimeStep, distribute,
};
use surface::{Contact, Stencil};

use crate::common::{self, contact, law, momentum_residual, patch, rows, solve, thorough};

const H: f64 = 0.01;
const STEPS: u32 = 40;
const WEIGHTS: [f64; 3] = [0.2, 0.3, 0.5];

/// A particle over a face of three, all of different masses and on their way.
struct Free {
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    w: Vec<f64>,
}

impl Free {
    fn new(height: f64) -> Self {
        let x = [
            DVec3::new(0.1, 0.2, height),
            DVec3::new(-1.0, -0.5, 0.0),
            DVec3::new(1.5, -0.4, 0.0),
            DVec3::new(-0.3, 0.9, 0.0),
        ];
        let v = [
            DVec3::new(0.5, 0.2, -0.9),
            DVec3::new(-0.1, 0.0, 0.2),
            DVec3::new(0.0, 0.3, 0.1),
            DVec3::new(0.2, -0.1, 0.4),
        ];
        Self { x: x.into(), v: v.into(), w: vec![1.0, 0.5, 4.0, 0.1] }
    }

    fn stencil() -> Stencil {
        Stencil::vertex_face(0, [1, 2, 3], WEIGHTS)
    }

    fn contacts(&self) -> [Contact; 1] {
        let apart = -Self::stencil().combine(|k| self.x[k as usize]).z;
        [contact(Self::stencil(), DVec3::Z, apart)]
    }

    fn rows(&self, law: ContactLaw) -> ContactRows {
        rows(4, &self.contacts(), law)
    }

    fn state(&self) -> RelativeState {
        let of = |q: &[DVec3]| Self::stencil().combine(|k| q[k as usize]);
        let position = DVec3::Z * of(&self.x).z;
        let motion = RelativeMotion { position, velocity: of(&self.v), acceleration: DVec3::ZERO };
        let margins = Margins::new(0.0, 1.0).expect("in range");
        RelativeState::new(motion, DVec3::Z, 0.0, margins).expect("finite")
    }

    /// Corrects the acceleration of the contact, and takes a step.
    fn accelerate<I: Integrator>(&mut self, change: DVec3, everywhere: DVec3) {
        let mut a = vec![everywhere; 4];
        distribute(Self::stencil().terms(), &self.w, change, &mut a).expect("finite");
        let step = TimeStep::<I>::new(H).expect("in range");
        step.accelerations(a).expect("finite").advance(&mut self.x, &mut self.v).expect("finite");
    }

    fn soft<I: Integrator>(&mut self, normal: NormalForce) {
        let rows = self.rows(law(0.3));
        let mut force = vec![DVec3::ZERO; 4];
        let soft_law = SoftLaw::new(normal, 0.1).expect("in range");
        SoftContacts::new(&rows, &self.v, soft_law)
            .and_then(|soft| soft.add_forces(&mut force))
            .expect("finite");
        let a = force.iter().zip(&self.w).map(|(f, w)| *w * *f).collect();
        let step = TimeStep::<I>::new(H).expect("in range");
        step.accelerations(a).expect("finite").advance(&mut self.x, &mut self.v).expect("finite");
    }

    fn soft_implicit<I: Implicit>(&mut self, normal: NormalForce) {
        let rows = self.rows(law(0.3));
        let soft_law = SoftLaw::new(normal, 0.1).expect("in range");
        let soft = SoftContacts::new(&rows, &self.v, soft_law).expect("finite");
        let mut force = vec![DVec3::ZERO; 4];
        soft.add_forces(&mut force).expect("finite");
        let params = LinearParams::default();
        let step = TimeStep::<I>::new(H).expect("in range");
        let (a, _) =
            step.implicit_accelerations(&self.w, &force, &soft, &self.v, &params).expect("finite");
        a.advance(&mut self.x, &mut self.v).expect("finite");
    }

    fn second_order<I: Integrator>(&mut self, everywhere: DVec3) {
        let state = self.state();
        let held = Reference::height(&state, 0.0, Restraint::Sliding).expect("finite");
        let correction = TimeStep::<I>::new(H)
            .and_then(|step| {
                step.second_order_spring(&state, held.position(&state), held.velocity(&state))
            })
            .expect("finite");
        self.accelerate::<I>(correction.change(), everywhere);
    }

    /// Solved together at a level, with friction; positions by the step's
    /// displacements.
    fn hard(&mut self, level: SolveLevel, params: &SolverParams) {
        let contacts = self.contacts();
        if level == SolveLevel::Velocity {
            solve(level, &mut self.v, &self.w, &contacts, law(0.5), params);
        }
        let mut moved: Vec<DVec3> = self.v.iter().map(|v| H * *v).collect();
        if level == SolveLevel::Position {
            solve(level, &mut moved, &self.w, &contacts, law(0.5), params);
            self.v = moved.iter().map(|u| *u / H).collect();
        }
        self.x.iter_mut().zip(moved).for_each(|(x, u)| *x += u);
    }

    fn react(&mut self, friction: Friction) {
        let change = Reaction { friction }.velocity(&self.state());
        distribute(Self::stencil().terms(), &self.w, change, &mut self.v).expect("finite");
        self.x.iter_mut().zip(&self.v).for_each(|(x, v)| *x += H * *v);
    }

    /// Takes back the last displacement after a step.
    fn react_by_position(&mut self, friction: Friction) {
        let before = self.x.clone();
        self.x.iter_mut().zip(&self.v).for_each(|(x, v)| *x += H * *v);
        let last = H * Self::stencil().combine(|k| self.v[k as usize]);
        let change = Reaction { friction }.position(&self.state(), last).expect("finite");
        distribute(Self::stencil().terms(), &self.w, change, &mut self.x).expect("finite");
        self.v = self.x.iter().zip(before).map(|(x, before)| (*x - before) / H).collect();
    }
}

const PENALTY: NormalForce = NormalForce::Penalty { stiffness: 900.0, damping: 3.0 };
const SPRING: NormalForce = NormalForce::TwoSided { stiffness: 900.0, damping: 3.0 };
const BARRIER: NormalForce = NormalForce::Barrier { stiffness: 50.0, range: 1.0 };
const FALL: DVec3 = DVec3::new(0.0, 0.0, -9.81);

/// A scene by its numbers, where the particle starts, what falls, and a step.
type Scene = (&'static str, f64, DVec3, fn(&mut Free));

const SCENES: [Scene; 25] = [
    ("penalty, symplectic", -0.2, DVec3::ZERO, |s| s.soft::<SymplecticEuler>(SPRING)),
    ("penalty, explicit", -0.2, DVec3::ZERO, |s| s.soft::<ExplicitEuler>(SPRING)),
    ("one-sided penalty", 0.05, DVec3::ZERO, |s| s.soft::<SymplecticEuler>(PENALTY)),
    ("impact, implicit", 0.05, DVec3::ZERO, |s| s.soft_implicit::<ImplicitEuler>(PENALTY)),
    ("impact, midpoint", 0.05, DVec3::ZERO, |s| s.soft_implicit::<ImplicitMidpoint>(PENALTY)),
    ("first order, symplectic", -0.2, DVec3::ZERO, first_order::<SymplecticEuler>),
    ("first order, Taylor", -0.2, DVec3::ZERO, first_order::<Taylor>),
    ("first order, explicit", -0.2, DVec3::ZERO, first_order::<ExplicitEuler>),
    ("second order, symplectic", -0.2, DVec3::ZERO, |s| {
        s.second_order::<SymplecticEuler>(DVec3::ZERO);
    }),
    ("second order, Taylor", -0.2, DVec3::ZERO, |s| s.second_order::<Taylor>(DVec3::ZERO)),
    ("second order, explicit", -0.2, DVec3::ZERO, |s| s.second_order::<ExplicitEuler>(DVec3::ZERO)),
    ("second order under gravity", -0.2, FALL, |s| s.second_order::<SymplecticEuler>(FALL)),
    ("hard, positions", 0.02, DVec3::ZERO, |s| s.hard(SolveLevel::Position, &thorough())),
    ("hard, velocities", 0.02, DVec3::ZERO, |s| s.hard(SolveLevel::Velocity, &thorough())),
    ("reaction", 0.5, DVec3::ZERO, |s| s.react(Friction::NONE)),
    ("hard, conjugate gradients", 0.02, DVec3::ZERO, |s| {
        let params = SolverParams { method: SolverMethod::ConjugateGradient, ..thorough() };
        s.hard(SolveLevel::Velocity, &params);
    }),
    ("hard, averaged Jacobi", 0.02, DVec3::ZERO, |s| {
        let params = SolverParams { method: SolverMethod::AveragedJacobi, ..thorough() };
        s.hard(SolveLevel::Velocity, &params);
    }),
    ("friction by share", 0.0, DVec3::ZERO, |s| s.react(Friction::share(0.5).expect("in range"))),
    ("friction by share, positions", 0.0, DVec3::ZERO, |s| {
        s.react_by_position(Friction::share(0.5).expect("in range"));
    }),
    ("Coulomb", 0.0, DVec3::ZERO, |s| s.react(Friction::coulomb(0.5).expect("in range"))),
    ("Coulomb, positions", 0.0, DVec3::ZERO, |s| {
        s.react_by_position(Friction::coulomb(0.5).expect("in range"));
    }),
    ("smooth friction", -0.1, DVec3::ZERO, |s| s.soft_implicit::<ImplicitEuler>(SPRING)),
    ("barrier", 0.4, DVec3::ZERO, |s| s.soft_implicit::<ImplicitEuler>(BARRIER)),
    ("distributed, positions", -0.2, DVec3::ZERO, |s| {
        let change = Spring::OneSided.position(&s.state());
        distribute(Free::stencil().terms(), &s.w, change, &mut s.x).expect("finite");
        s.hard(SolveLevel::Velocity, &thorough());
    }),
    ("distributed, velocities", -0.2, DVec3::ZERO, |s| {
        let h = StepLength::new(H).expect("in range");
        let change = Spring::OneSided.velocity_to_target(&s.state(), h);
        distribute(Free::stencil().terms(), &s.w, change, &mut s.v).expect("finite");
        s.hard(SolveLevel::Velocity, &thorough());
    }),
];

fn first_order<I: Integrator>(scene: &mut Free) {
    let h = StepLength::new(H).expect("in range");
    let change = Spring::TwoSided.acceleration(&scene.state(), h);
    scene.accelerate::<I>(change, DVec3::ZERO);
}

#[test]
fn scenes_of_one_contact_keep_their_momentum() {
    for (name, height, fall, step) in SCENES {
        let mut scene = Free::new(height);
        let (x, v) = (scene.x.clone(), scene.v.clone());
        let mut alone = false;
        let mut scale: f64 = 0.0;
        for k in 1..=STEPS {
            step(&mut scene);
            let time = f64::from(k) * H;
            let falling: Vec<DVec3> = v.iter().map(|v| *v + time * fall).collect();
            alone |= scene.v.iter().zip(&falling).any(|(v, free)| (*v - *free).length() > 1e-3);
            let size: f64 = scene.v.iter().zip(&scene.w).map(|(v, w)| v.length() / w).sum();
            scale = scale.max(size);
            let off = momentum(&scene.w, &scene.v) - momentum(&scene.w, &falling);
            assert!(off.length() < 1e-12 * scale, "{name}, step {k}: {off} of {scale}");
            // Nor do displacements shift the center of mass off its way.
            if fall == DVec3::ZERO {
                let off = momentum(&scene.w, &scene.x)
                    - momentum(&scene.w, &x)
                    - time * momentum(&scene.w, &v);
                assert!(off.length() < 1e-12 * (scale + 20.0), "{name}, step {k}: {off}");
            }
        }
        assert!(alone, "{name}: something was corrected");
    }
}

/// Σ m q.
fn momentum(w: &[f64], q: &[DVec3]) -> DVec3 {
    q.iter().zip(w).map(|(q, w)| *q / *w).sum()
}

/// Contacts of a tower without its floor.
fn stack(x: &[DVec3]) -> Vec<Contact> {
    let count = u32::try_from(x.len()).expect("a few particles");
    (1..count).map(|k| common::stacked(k - 1, k, x)).collect()
}

#[test]
fn stacks_without_a_floor_keep_their_momentum() {
    let w: Vec<f64> = (0..10).map(|k| 1.0 / (1.0 + f64::from(k))).collect();
    let x: Vec<DVec3> = (0..10).map(|k| DVec3::Z * 0.9 * f64::from(k)).collect();
    let spring = SoftLaw::new(NormalForce::TwoSided { stiffness: 100.0, damping: 1.0 }, 1.0);
    let (mut at, mut v) = (x.clone(), vec![DVec3::ZERO; 10]);
    let step = TimeStep::<SymplecticEuler>::new(H).expect("in range");
    for _ in 0..STEPS {
        let rows = rows(10, &stack(&at), law(0.0));
        let soft = SoftContacts::new(&rows, &v, spring.expect("in range")).expect("finite");
        let mut force = vec![DVec3::ZERO; 10];
        soft.add_forces(&mut force).expect("finite");
        let a = force.iter().zip(&w).map(|(f, w)| *w * *f).collect();
        step.accelerations(a).expect("finite").advance(&mut at, &mut v).expect("finite");
    }
    assert!(v.iter().any(|v| v.length() > 0.1), "it springs apart: {v:?}");
    assert!(momentum_residual(&w, &[DVec3::ZERO; 10], &v) < 1e-12, "stack of springs");

    for max_iterations in [1, 4, 16, 64] {
        let params = SolverParams { max_iterations, ..SolverParams::default() };
        let mut moved = vec![DVec3::ZERO; 10];
        solve(SolveLevel::Position, &mut moved, &w, &stack(&x), law(0.0), &params);
        let residual = momentum_residual(&w, &[DVec3::ZERO; 10], &moved);
        assert!(residual < 1e-12, "stack, {max_iterations} sweeps: {residual:e}");
    }
}

#[test]
fn patches_keep_their_momentum_by_every_method() {
    for method in
        [SolverMethod::GaussSeidel, SolverMethod::AveragedJacobi, SolverMethod::ConjugateGradient]
    {
        for count in [20, 80] {
            let (v, w, contacts) = patch(count, 3);
            let params = SolverParams { method, max_iterations: 50, tolerance: 0.0 };
            for level in [SolveLevel::Position, SolveLevel::Velocity, SolveLevel::Acceleration] {
                let mut q = v.clone();
                solve(level, &mut q, &w, &contacts, law(0.5), &params);
                let residual = momentum_residual(&w, &v, &q);
                assert!(residual < 1e-12, "{method:?}, {level:?}, {count}: {residual:e}");
            }
        }
    }
}

#[test]
fn half_weights_do_not_keep_the_momentum() {
    let scene = Free::new(-0.2);
    let mut half = vec![DVec3::ZERO; 4];
    for term in Free::stencil().terms() {
        half[term.particle as usize] += 0.5 * term.weight * DVec3::Z;
    }
    assert!(momentum_residual(&scene.w, &[DVec3::ZERO; 4], &half) > 0.1);
}
