//! Contact steps: positions, velocities and accelerations corrected in sequence.

use glam::DVec3;
use response::{
    ContactSet, ContactStep, Follower, Followers, Material, ParticleLoads, ParticleStates,
    ResponseError, RigidMotion, SolverMethod, SolverParams, SpringDamper, StepLength, StepParams,
    StepReport,
};
use surface::Contact;

use crate::common::{self, material, momentum_residual, on_plane, stacked, tower};

fn params() -> StepParams {
    StepParams {
        depth_tolerance: Some(1e-9),
        approach_tolerance: Some(1e-9),
        push_tolerance: Some(1e-9),
        solver: SolverParams { max_iterations: 2000, tolerance: 1e-11, ..Default::default() },
        max_rounds: 10,
        ..StepParams::new(StepLength::new(0.01).expect("in range"))
    }
}

struct World {
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    a: Vec<DVec3>,
}

impl World {
    fn correct(&mut self, params: &StepParams, step: &mut ContactStep) -> StepReport {
        let w = vec![1.0; self.x.len()];
        let detect = |x: &[DVec3], contacts: &mut ContactSet| {
            contacts.add(0, &material(0.5), &RigidMotion::default(), &tower(x));
            Ok::<(), ResponseError>(())
        };
        let loads = ParticleLoads::Accelerations(&mut self.a);
        let particles = ParticleStates { x: &mut self.x, v: &mut self.v, loads, inverse_mass: &w };
        step.correct(particles, params, detect).expect("valid")
    }
}

#[test]
fn a_pressed_tower_is_freed_stopped_and_carried() {
    let heights = [-0.3, 0.5, 1.6, 2.4];
    let mut world = World {
        x: heights.iter().map(|z| DVec3::Z * *z).collect(),
        v: vec![DVec3::new(0.0, 0.0, -3.0); 4],
        a: vec![DVec3::Z * -9.81; 4],
    };
    let mut step = ContactStep::default();
    let report = world.correct(&params(), &mut step);
    assert!(report.depth < 1e-9 && report.rounds >= 1, "{report:?}");
    for (k, x) in world.x.iter().enumerate().skip(1) {
        assert!(x.z - world.x[k - 1].z > 1.0 - 1e-8, "{:?}", world.x);
    }
    assert!(world.v.iter().all(|v| v.length() < 1e-7), "{:?}", world.v);
    assert!(world.a.iter().all(|a| a.length() < 1e-7), "{:?}", world.a);
    // The floor is given the momentum that the tower had.
    assert!((report.impulse - DVec3::Z * 12.0).length() < 1e-7);
}

#[test]
fn states_within_the_tolerances_are_not_changed() {
    let mut world =
        World { x: vec![DVec3::Z * -0.01], v: vec![DVec3::Z * -0.5], a: vec![DVec3::Z * -9.81] };
    let wide = StepParams {
        depth_tolerance: Some(0.02),
        approach_tolerance: Some(1.0),
        push_tolerance: Some(10.0),
        ..params()
    };
    let report = world.correct(&wide, &mut ContactStep::default());
    assert_eq!((report.rounds, report.velocities, report.loads), (0, None, None));
    assert_eq!(world.x[0].z, -0.01);
    let velocities = StepParams {
        depth_tolerance: None,
        approach_tolerance: Some(0.0),
        push_tolerance: None,
        ..params()
    };
    let report = world.correct(&velocities, &mut ContactStep::default());
    assert!(report.velocities.is_some() && report.positions.is_none());
    assert_eq!((world.x[0].z, world.v[0].z, world.a[0].z), (-0.01, 0.0, -9.81));
}

#[test]
fn separating_contacts_are_not_pushed() {
    let mut world = World { x: vec![DVec3::ZERO], v: vec![DVec3::Z], a: vec![DVec3::Z * -9.81] };
    let report = world.correct(&params(), &mut ContactStep::default());
    assert_eq!(report.loads, None, "thrown up, it still falls back");
    assert_eq!(world.a[0].z, -9.81);
}

#[test]
fn a_tower_without_a_floor_keeps_its_momentum() {
    let mut x = vec![DVec3::ZERO, DVec3::Z * 0.7, DVec3::Z * 1.2];
    let mut v = vec![DVec3::Z * 2.0, DVec3::ZERO, DVec3::Z * -1.0];
    let mut a = vec![DVec3::Z * 4.0, DVec3::ZERO, DVec3::Z * -5.0];
    let w = [1.0, 0.1, 3.0];
    let before = (x.clone(), v.clone(), a.clone());
    let detect = |x: &[DVec3], contacts: &mut ContactSet| {
        let found = [stacked(0, 1, x), stacked(1, 2, x)];
        contacts.add(0, &material(0.5), &RigidMotion::default(), &found);
        Ok::<(), ResponseError>(())
    };
    let loads = ParticleLoads::Accelerations(&mut a);
    let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &w };
    let report = ContactStep::default().correct(particles, &params(), detect).expect("valid");
    assert!(report.mass_moved.length() < 1e-11 && report.impulse.length() < 1e-11);
    assert!(momentum_residual(&w, &before.0, &x) < 1e-12);
    assert!(momentum_residual(&w, &before.1, &v) < 1e-12);
    assert!(momentum_residual(&w, &before.2, &a) < 1e-12);
    assert!(v[0].z <= v[1].z + 1e-9 && v[1].z <= v[2].z + 1e-9, "{v:?}");
}

#[test]
fn the_cache_saves_sweeps_from_step_to_step() {
    let mut world = World {
        x: (0..10).map(|k| DVec3::Z * f64::from(k)).collect(),
        v: vec![DVec3::ZERO; 10],
        a: vec![DVec3::ZERO; 10],
    };
    let mut step = ContactStep::default();
    let mut sweeps = Vec::new();
    for _ in 0..5 {
        for v in &mut world.v {
            v.z -= 9.81e-2;
        }
        let report = world.correct(&params(), &mut step);
        sweeps.push(report.velocities.expect("it fell").iterations);
    }
    assert!(sweeps[1..].iter().all(|s| 20 * s < sweeps[0]), "{sweeps:?}");
}

/// A step that solves for nothing leaves the impulses of the one before as those of its length.
#[test]
fn steps_that_solve_nothing_do_not_rescale_impulses() {
    let of_length = |h: f64| StepParams {
        h: StepLength::new(h).expect("in range"),
        push_tolerance: None,
        ..params()
    };
    let third = |between: Option<StepParams>| {
        let x = (0..6).map(|k| DVec3::Z * f64::from(k)).collect();
        let mut world = World { x, v: vec![DVec3::ZERO; 6], a: vec![DVec3::ZERO; 6] };
        let (mut step, mut reports) = (ContactStep::default(), Vec::new());
        for params in [Some(of_length(0.01)), between, Some(of_length(0.02))].into_iter().flatten()
        {
            world.v.fill(DVec3::Z * -9.81 * params.h.get());
            reports.push(world.correct(&params, &mut step).velocities);
        }
        reports.last().copied().flatten().expect("the last step solves")
    };
    let idle = StepParams { approach_tolerance: None, ..of_length(0.02) };
    assert_eq!(third(Some(idle)), third(None));
}

#[test]
fn followers_move_with_their_leaders_and_count_with_their_mass() {
    // Particle 3 follows 0, 1 and 2; particle 4 does too, but is fixed.
    let leaders = [(0, 0.5), (1, 0.3), (2, 0.2)].map(|(k, weight)| common::term(k, weight));
    let follower = |particle| Follower { particle, leaders };
    let followers = Followers::new(vec![follower(3), follower(4)]).expect("valid");
    let (mut x, mut v) = (vec![DVec3::ZERO; 5], vec![DVec3::Z * -1.0; 5]);
    let w = [1.0, 0.5, 2.0, 0.1, 0.0];
    let mut step = ContactStep::default();
    step.set_followers(followers);
    let detect = |x: &[DVec3], contacts: &mut ContactSet| {
        contacts.add(0, &material(0.0), &RigidMotion::default(), &[on_plane(0, x[0], DVec3::Z)]);
        Ok::<(), ResponseError>(())
    };
    let loads = ParticleLoads::None;
    let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &w };
    let report = step.correct(particles, &params(), detect).expect("valid");
    // The floor stops particle 0 with half of the mass 10 that follows it.
    assert!((report.impulse.z - 6.0).abs() < 1e-12, "{report:?}");
    let expected = [0.0, -1.0, -1.0, -0.5, -1.0];
    assert!(v.iter().zip(expected).all(|(v, z)| (v.z - z).abs() < 1e-12), "{v:?}");

    // Refused: weights that do not sum to 1, leaders that follow, and a follower that is listed twice.
    let short = leaders.map(|term| common::term(term.particle, 0.3));
    assert!(Followers::new(vec![Follower { particle: 3, leaders: short }]).is_err());
    let circle = leaders.map(|term| common::term(term.particle + 1, term.weight));
    let two = vec![follower(3), Follower { particle: 4, leaders: circle }];
    assert!(Followers::new(two).is_err());
    let twice = Followers::new(vec![follower(3), follower(4), follower(3)]);
    assert_eq!(twice.unwrap_err().to_string(), "follower is 3, but must be listed once");
    let beyond = Followers::new(vec![follower(9)]).expect("no count is known");
    step.set_followers(beyond);
    let particles =
        ParticleStates { x: &mut x, v: &mut v, loads: ParticleLoads::None, inverse_mass: &w };
    assert!(step.correct(particles, &params(), detect).is_err());
}

/// A negative weight would take mass from a leader: with equal masses, its inverse mass would be
/// infinite.
#[test]
fn leaders_with_negative_weights_are_refused() {
    let followers = |weights: [f64; 3]| {
        let leaders = std::array::from_fn(|k| common::term([0, 1, 2][k], weights[k]));
        Followers::new(vec![Follower { particle: 3, leaders }])
    };
    let refused = ResponseError::LeaderWeight { follower: 3, leader: 1, weight: -1.0 };
    assert_eq!(followers([2.0, -1.0, 0.0]), Err(refused));

    // Rounding is none.
    let rounded = followers([1.0, -1e-17, -0.0]).expect("weights of rounding");
    let weights = rounded.as_slice()[0].leaders.map(|leader| leader.weight);
    assert_eq!(weights, [1.0, 0.0, 0.0]);
}

/// A follower that is met on the way follows no more: its leader's soft contact stands for the others
/// alone, in depth and in number.
#[test]
fn followers_met_on_the_way_no_longer_count() {
    let spring = SpringDamper::new(1e3, 1.0).expect("in range");
    let soft = Material { spring: Some(spring), ..material(0.0) };
    let moved = |following: &[u32]| {
        let leaders = [(0, 1.0), (3, 0.0), (3, 0.0)].map(|(k, weight)| common::term(k, weight));
        let followers = following.iter().map(|&particle| Follower { particle, leaders }).collect();
        let mut step = ContactStep::default();
        step.set_followers(Followers::new(followers).expect("valid"));
        let mut x = [-0.1, 0.4, -0.2, 0.0].map(|z| DVec3::Z * z);
        let mut v = [-1.0, -1000.0, -1.0, 0.0].map(|z| DVec3::Z * z);
        let w = [1.0; 4];
        let detect = |x: &[DVec3], contacts: &mut ContactSet| {
            contacts.add(0, &soft, &RigidMotion::default(), &[on_plane(0, x[0], DVec3::Z)]);
            Ok::<(), ResponseError>(())
        };
        let loads = ParticleLoads::None;
        let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &w };
        let mut report = step.correct(particles, &params(), detect).expect("valid");
        let met = Contact { time: Some(0.5), ..on_plane(1, x[1], DVec3::Z) };
        let sweep = |_: &[DVec3], contacts: &mut ContactSet| {
            contacts.add(1, &material(0.0), &RigidMotion::default(), &[met]);
            Ok::<(), ResponseError>(())
        };
        let swept = step.correct_swept(&mut v, &w, &params(), &mut report, sweep).expect("valid");
        assert_eq!(swept.contacts, 1);
        v
    };
    assert_eq!(moved(&[1, 2]), moved(&[2]));
}

/// A particle in a groove of 20°, of which each detection finds the deeper side: pushed out of one,
/// it is inside the other. Both are held after two rounds, and it is at the bottom.
#[test]
fn rounds_do_not_take_turns_between_the_sides_of_a_crease() {
    let lean = 80_f64.to_radians();
    let sides = [1.0, -1.0].map(|side| DVec3::new(side * lean.sin(), 0.0, lean.cos()));
    let (mut x, mut v) = ([DVec3::new(0.05, 0.3, -1.0)], [DVec3::ZERO]);
    let mut step = ContactStep::default();
    let detect = |x: &[DVec3], contacts: &mut ContactSet| {
        let gaps = sides.map(|normal| normal.dot(x[0]));
        let deeper = sides[usize::from(gaps[1] < gaps[0])];
        let found = on_plane(0, x[0], deeper);
        contacts.add(0, &material(0.0), &RigidMotion::default(), &[found]);
        Ok::<(), ResponseError>(())
    };
    let loads = ParticleLoads::None;
    let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &[1.0] };
    let report = step.correct(particles, &params(), detect).expect("valid");
    assert!(report.rounds == 2 && report.depth < 1e-9, "{report:?}");
    assert!(x[0].distance(DVec3::Y * 0.3) < 1e-9, "{x:?}");
}

/// A particle that falls into a groove of two walls of one bone, steep or nearly flat, meets the
/// second wall once it slides on the first: both hold it at the end of the move.
#[test]
fn a_move_into_a_groove_ends_between_both_walls() {
    let method = SolverMethod::ConjugateGradient;
    let params = StepParams { solver: SolverParams { method, ..params().solver }, ..params() };
    for (degrees, from) in [(45.0_f64, -0.5), (2.0, -0.1)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let walls = [sin, -sin].map(|x| DVec3::new(x, 0.0, cos));
        let (mut x, mut v) = ([DVec3::new(from, 0.0, 2.0)], [DVec3::Z * -1000.0]);
        let (start, h, w) = (x[0], params.h.get(), [1.0]);
        let mut step = ContactStep::default();
        let none = |_: &[DVec3], _: &mut ContactSet| Ok::<(), ResponseError>(());
        let loads = ParticleLoads::None;
        let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &w };
        let mut report = step.correct(particles, &params, none).expect("valid");

        // The wall that is met first.
        let sweep = |v: &[DVec3], contacts: &mut ContactSet| {
            let time = |wall: &DVec3| wall.dot(start) / (-h * wall.dot(v[0]));
            let met = walls.iter().filter(|wall| wall.dot(start + h * v[0]) < -1e-9);
            if let Some(wall) = met.min_by(|a, b| time(a).total_cmp(&time(b))) {
                let found = Contact { time: Some(time(wall)), ..on_plane(0, start, *wall) };
                contacts.add(0, &material(0.0), &RigidMotion::default(), &[found]);
            }
            Ok::<(), ResponseError>(())
        };
        let swept = step.correct_swept(&mut v, &w, &params, &mut report, sweep).expect("valid");
        assert!(swept.contacts == 2 && swept.free_share >= 1.0, "{degrees}°: {swept:?}");
        let end = start + h * v[0];
        assert!(end.length() < 1e-8, "{degrees}°: at the bottom: {end}");
    }
}
