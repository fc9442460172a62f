//! Contact steps in the loop of a simulator: slopes, moving bones, soft and permanent
//! contacts, energy, and memory. Millimeters, grams and seconds.

use glam::DVec3;
use response::{
    ContactSet, ContactStep, Follower, Followers, Friction, Material, ParticleLoads,
    ParticleStates, ResponseError, Restraint, RigidMotion, SolverMethod, SolverParams,
    SpringDamper, StepLength, StepParams, StepReport,
};
use surface::Contact;

use crate::common::{Stream, kinetic_energy, material, on_plane, patch, stacked, term, tower};

const GRAVITY: f64 = 9810.0;

fn params(h: f64) -> StepParams {
    StepParams {
        solver: SolverParams { max_iterations: 500, tolerance: 1e-9, ..SolverParams::default() },
        ..StepParams::new(StepLength::new(h).expect("in range"))
    }
}

/// Particles in contact with a plane through the origin.
struct World {
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    w: Vec<f64>,
    normal: DVec3,
    material: Material,
    motion: RigidMotion,
    step: ContactStep,
}

impl World {
    fn new(x: Vec<DVec3>, normal: DVec3, material: Material) -> Self {
        let (v, w) = (vec![DVec3::ZERO; x.len()], vec![0.5; x.len()]);
        let (motion, step) = (RigidMotion::default(), ContactStep::default());
        Self { x, v, w, normal, material, motion, step }
    }

    fn correct(&mut self, params: &StepParams, loads: ParticleLoads<'_>) -> StepReport {
        let (normal, material, motion) = (self.normal, self.material, self.motion);
        let detect = |x: &[DVec3], contacts: &mut ContactSet| {
            let found: Vec<Contact> = (0..).zip(x).map(|(k, x)| on_plane(k, *x, normal)).collect();
            contacts.add(0, &material, &motion, &found);
            Ok::<(), ResponseError>(())
        };
        let (x, v) = (&mut self.x[..], &mut self.v[..]);
        let particles = ParticleStates { x, v, loads, inverse_mass: &self.w };
        self.step.correct(particles, params, detect).expect("valid")
    }
}

/// Normal of a slope of `degrees`, and the direction down it.
fn slope(degrees: f64) -> [DVec3; 2] {
    let (sin, cos) = degrees.to_radians().sin_cos();
    [DVec3::new(sin, 0.0, cos), DVec3::new(cos, 0.0, -sin)]
}

/// A slab of nine particles on springs along its edges and diagonals, lying on a slope.
fn slab(degrees: f64, friction: f64) -> World {
    let [normal, down] = slope(degrees);
    let mut x = Vec::new();
    for k in 0..9_u32 {
        let (row, column) = (f64::from(k / 3), f64::from(k % 3));
        x.push(10.0 * (row * down + column * DVec3::Y));
    }
    World::new(x, normal, material(friction))
}

/// Velocities gain gravity and the springs' accelerations, which add up to nothing.
fn accelerate(world: &mut World, rest: &[DVec3], h: f64) {
    for i in 0..world.x.len() {
        world.v[i] -= DVec3::Z * GRAVITY * h;
        for j in 0..i {
            let (along, length) = (world.x[j] - world.x[i], rest[j].distance(rest[i]));
            let pull = h * 300.0 * (along.length() - length) * along.normalize();
            world.v[i] += pull;
            world.v[j] -= pull;
        }
    }
}

fn advance(world: &mut World, h: f64) {
    for (x, v) in world.x.iter_mut().zip(&world.v) {
        *x += h * *v;
    }
}

/// Mean speed of the slab down the slope over the last half of some steps, and its mean
/// acceleration over all.
fn slide(degrees: f64, friction: f64, h: f64, is_before_move: bool) -> [f64; 2] {
    let [_, down] = slope(degrees);
    let (mut world, steps) = (slab(degrees, friction), 400_u32);
    let rest = world.x.clone();
    let middle = |world: &World| world.x.iter().sum::<DVec3>().dot(down) / 9.0;
    let mut half = 0.0;
    for step in 0..steps {
        if step == steps / 2 {
            half = middle(&world);
        }
        accelerate(&mut world, &rest, h);
        if is_before_move {
            world.correct(&params(h), ParticleLoads::None);
            advance(&mut world, h);
        } else {
            advance(&mut world, h);
            world.correct(&params(h), ParticleLoads::None);
        }
    }
    let creep = (middle(&world) - half) / (h * f64::from(steps / 2));
    let speed = world.v.iter().sum::<DVec3>().dot(down) / 9.0;
    [creep, speed / (h * f64::from(steps))]
}

#[test]
fn corrected_before_the_move_a_slab_sticks_and_after_it_creeps() {
    for h in [1e-3, 1e-2] {
        let [creep, _] = slide(20.0, 0.5, h, true);
        assert!(creep.abs() < 1e-4, "before the move: {creep} mm/s at {h} s");

        // Each move has the gain of its step.
        let [creep, _] = slide(20.0, 0.5, h, false);
        let gain = GRAVITY * 20_f64.to_radians().sin() * h;
        assert!((creep / gain - 1.0).abs() < 1e-3, "after the move: {creep}, not {gain}");
    }
}

#[test]
fn a_slab_slides_with_the_acceleration_that_friction_leaves() {
    for is_before_move in [true, false] {
        let [_, found] = slide(20.0, 0.2, 1e-3, is_before_move);
        let (sin, cos) = 20_f64.to_radians().sin_cos();
        let expected = GRAVITY * (sin - 0.2 * cos);
        assert!((found / expected - 1.0).abs() < 0.02, "{found}, not {expected}");
    }
}

#[test]
fn a_slab_sticks_where_the_integrator_takes_velocities_and_forces() {
    for has_forces in [false, true] {
        let (h, mut world) = (1e-3, slab(20.0, 0.5));
        let start = world.x.clone();
        let with_push = StepParams { push_tolerance: Some(0.0), ..params(h) };
        for _ in 0..100 {
            let scale = if has_forces { 1.0 / world.w[0] } else { 1.0 };
            let mut loads = vec![DVec3::Z * -GRAVITY * scale; 9];
            let given = if has_forces {
                ParticleLoads::Forces(&mut loads)
            } else {
                ParticleLoads::Accelerations(&mut loads)
            };
            let report = world.correct(&with_push, given);
            // Nine particles of mass 2 are carried.
            let force = DVec3::Z * 18.0 * GRAVITY;
            assert!((report.force - force).length() < 1e-6, "{report:?}");
            for (v, load) in world.v.iter_mut().zip(&loads) {
                *v += h / scale * *load;
            }
            advance(&mut world, h);
        }
        for (x, start) in world.x.iter().zip(&start) {
            assert!((*x - *start).length() < 1e-9, "{x}");
        }
    }
}

#[test]
fn a_particle_turns_and_rises_with_a_moving_bone() {
    // A turntable that rises, and spins up: the state of a point of it in closed form.
    let (at, friction) = (DVec3::new(3.0, 4.0, 0.0), material(50.0));
    let motion = RigidMotion {
        about: DVec3::new(1.0, 0.0, 0.0),
        velocity: DVec3::Z * 7.0,
        acceleration: DVec3::Z * 20.0,
        spin: DVec3::Z * 5.0,
        spin_change: DVec3::Z * 30.0,
    };
    let mut world = World { motion, ..World::new(vec![at], DVec3::Z, friction) };
    let mut loads = [DVec3::Z * -GRAVITY];
    let with_push = StepParams { push_tolerance: Some(0.0), ..params(1e-3) };
    let report = world.correct(&with_push, ParticleLoads::Accelerations(&mut loads));

    let velocity = DVec3::new(-20.0, 10.0, 7.0);
    let acceleration = DVec3::new(-30.0 * 4.0 - 25.0 * 2.0, 30.0 * 2.0 - 25.0 * 4.0, 20.0);
    assert!((world.v[0] - velocity).length() < 1e-9, "{}", world.v[0]);
    assert!((loads[0] - acceleration).length() < 1e-8, "{}", loads[0]);
    // The bone has given all of the momentum, and as much work as that times its velocity.
    assert!((report.impulse - 2.0 * velocity).length() < 1e-8);
    assert!((report.rigid_work - 2.0 * velocity.length_squared()).abs() < 1e-6);
    assert!((report.kinetic_energy - velocity.length_squared()).abs() < 1e-6);
}

#[test]
fn soft_contacts_sink_in_by_their_weight_at_any_stiffness() {
    for (stiffness, damping) in [(10.0, 5.0), (1e4, 100.0), (1e9, 1e3)] {
        let spring = SpringDamper::new(stiffness, damping).expect("in range");
        let soft = Material { spring: Some(spring), ..material(0.3) };
        for at_velocities in [true, false] {
            let h = 0.01;
            let mut world = World::new(vec![DVec3::Z * 0.2], DVec3::Z, soft);
            let params = StepParams {
                approach_tolerance: at_velocities.then_some(0.0),
                push_tolerance: Some(0.0),
                ..params(h)
            };
            let mut report = StepReport::default();
            for _ in 0..40_000 {
                let mut a = [DVec3::Z * -GRAVITY];
                if at_velocities {
                    world.v[0] += h * a[0];
                    report = world.correct(&params, ParticleLoads::None);
                } else {
                    report = world.correct(&params, ParticleLoads::Accelerations(&mut a));
                    world.v[0] += h * a[0];
                }
                advance(&mut world, h);
            }
            // k x = m g, with mass 2.
            let sink = 2.0 * GRAVITY / stiffness;
            let found = -world.x[0].z;
            assert!((found / sink - 1.0).abs() < 1e-6, "k {stiffness}: {found}, not {sink}");
            let energy = 0.5 * stiffness * sink * sink;
            assert!((report.contact_energy / energy - 1.0).abs() < 1e-5, "{report:?}");
        }
    }
}

/// Four masses on springs, of which two are in contact and the others follow these: as deep as all
/// four, since each contact stands for two vertices.
#[test]
fn soft_contacts_of_reduced_surfaces_sink_in_as_far_as_those_of_whole_ones() {
    let (h, stiffness) = (0.01, 1e4);
    let spring = SpringDamper::new(stiffness, 100.0).expect("in range");
    let soft = Material { spring: Some(spring), ..material(0.0) };
    let w = [2.0, 0.5, 0.5, 2.0];
    for in_contact in [4, 2] {
        let mut step = ContactStep::default();
        if in_contact == 2 {
            let follower = |particle, leader| {
                let leaders = [(leader, 1.0), (1 - leader, 0.0), (leader, 0.0)];
                Follower { particle, leaders: leaders.map(|(k, weight)| term(k, weight)) }
            };
            let followers = Followers::new(vec![follower(2, 0), follower(3, 1)]);
            step.set_followers(followers.expect("valid"));
        }

        // Followers bulge out of the reduced surface.
        let bulge = if in_contact == 2 { 0.1 } else { 0.0 };
        let (mut x, mut v) = ([DVec3::ZERO; 4], [DVec3::ZERO; 4]);
        for x in &mut x[2..] {
            x.z -= bulge;
        }
        let (mut report, params) = (StepReport::default(), params(h));
        for _ in 0..4000 {
            for v in &mut v {
                v.z -= h * GRAVITY;
            }
            let detect = |x: &[DVec3], contacts: &mut ContactSet| {
                for k in 0..in_contact {
                    let found = on_plane(k, x[k as usize], DVec3::Z);
                    contacts.add(0, &soft, &RigidMotion::default(), &[found]);
                }
                Ok::<(), ResponseError>(())
            };
            let loads = ParticleLoads::None;
            let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &w };
            report = step.correct(particles, &params, detect).expect("valid");
            for (x, v) in x.iter_mut().zip(&v) {
                *x += h * *v;
            }
        }

        // All of the weight on springs of the same total stiffness per mass: 0.5 and 2 on one each,
        // or 2.5 on springs for as many vertices of the leader's mass.
        let mut energy = 0.0;
        for k in 0..in_contact as usize {
            let mass = if in_contact == 4 { 1.0 / w[k] } else { 2.5 };
            let springs = if in_contact == 4 { 1.0 } else { 2.5 * w[k] };
            let sink = mass * GRAVITY / (springs * stiffness);

            // As deep on average.
            let of_followers = 1.0 - 1.0 / (w[k] * mass);
            let mean = -x[k].z + bulge * of_followers;
            assert!((mean / sink - 1.0).abs() < 1e-6, "{in_contact}, {k}: {mean} {sink}");
            energy += 0.5 * springs * stiffness * sink * sink;
        }
        assert!((report.contact_energy / energy - 1.0).abs() < 1e-5, "{report:?}");
    }
}

#[test]
fn an_open_gap_closes_before_a_soft_contact_pushes() {
    let spring = SpringDamper::new(1e5, 1e3).expect("in range");
    let soft = Material { spring: Some(spring), ..material(0.0) };
    for (height, speed, is_pushed) in [(0.011, 1.0, false), (0.009, 1.0, true)] {
        let mut world = World::new(vec![DVec3::Z * height], DVec3::Z, soft);
        world.v[0].z = -speed;
        let report = world.correct(&params(0.01), ParticleLoads::None);
        assert_eq!(report.impulse.z > 0.0, is_pushed, "from {height}: {report:?}");
    }
}

/// The proximity distance slows approaches by a share, which is not enough for fast ones: these end at
/// the surface.
#[test]
fn fast_approaches_end_at_the_surface() {
    let h = 0.1;
    for (height, speed, expected) in [(0.5, 4.0, 0.3), (0.5, 30.0, 0.0), (2.0, 30.0, 0.0)] {
        let mut world = World::new(vec![DVec3::Z * height], DVec3::Z, material(0.0));
        world.v[0].z = -speed;
        let report = world.correct(&params(h), ParticleLoads::None);
        advance(&mut world, h);
        assert!((world.x[0].z - expected).abs() < 1e-12, "from {height}: {}", world.x[0].z);
        assert!(report.approach_before > 0.0, "{report:?}");
    }
}

#[test]
fn permanent_contacts_hold_against_a_pull() {
    let pull = DVec3::new(300.0, 0.0, 500.0);
    for (restraint, expected) in
        [(Restraint::Sliding, pull.with_z(0.0) * 0.5), (Restraint::Sticking, DVec3::ZERO)]
    {
        let glued = Material { permanent: Some(restraint), ..material(0.0) };
        let mut world = World::new(vec![DVec3::Z * 0.1], DVec3::Z, glued);
        for _ in 0..500 {
            world.v[0] += 1e-3 * pull;
            world.correct(&params(1e-3), ParticleLoads::None);
            advance(&mut world, 1e-3);
        }
        assert!(world.x[0].z.abs() < 1e-12, "{restraint:?}: {}", world.x[0]);
        assert!((world.v[0] - expected).length() < 1e-9, "{restraint:?}: {}", world.v[0]);
    }
    let mut world = World::new(vec![DVec3::ZERO], DVec3::Z, material(0.0));
    world.v[0] = pull;
    world.correct(&params(1e-3), ParticleLoads::None);
    assert_eq!(world.v[0], pull, "a contact that may open does");
}

#[test]
fn hard_contacts_only_dissipate_the_work_of_bones() {
    for seed in 0..20 {
        let (mut v, w, contacts) = patch(40, seed);
        let mut s = Stream(seed + 100);
        let motion = RigidMotion {
            velocity: DVec3::new(s.next(), s.next(), s.next() - 0.5),
            spin: DVec3::Z * s.next(),
            ..RigidMotion::default()
        };
        // The upper particles also rest on a plane that moves.
        let mut x: Vec<DVec3> = (0..24).map(|_| DVec3::ZERO).collect();
        let before = v.clone();
        let detect = |x: &[DVec3], set: &mut ContactSet| {
            set.add(0, &material(0.4), &RigidMotion::default(), &contacts);
            let on_bone: Vec<Contact> = (0..12)
                .map(|k| on_plane(k, x[k as usize], DVec3::new(0.1, 0.2, 1.0).normalize()))
                .collect();
            set.add(1, &material(0.7), &motion, &on_bone);
            Ok::<(), ResponseError>(())
        };
        let loads = ParticleLoads::None;
        let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &w };
        let params = StepParams {
            depth_tolerance: None,
            solver: SolverParams { max_iterations: 20_000, tolerance: 1e-12, ..Default::default() },
            ..params(0.01)
        };
        let report = ContactStep::default().correct(particles, &params, detect).expect("valid");
        let change = kinetic_energy(&w, &v) - kinetic_energy(&w, &before);
        assert!((report.kinetic_energy - change).abs() < 1e-10 * kinetic_energy(&w, &before));
        assert!(report.kinetic_energy <= report.rigid_work + 1e-9, "seed {seed}: {report:?}");
        assert!(report.approach < 1e-6 && report.approach_before > 0.1, "{report:?}");
        let momentum: DVec3 =
            w.iter().zip(v.iter().zip(&before)).map(|(w, (v, b))| (*v - *b) / *w).sum();
        assert!((report.impulse - momentum).length() < 1e-12 * 24.0);
    }
}

/// Fixed particles that move do work, as bones do: one at 3 takes another of mass 2 along, and half of
/// its work is lost.
#[test]
fn fixed_particles_that_move_do_work() {
    let (mut x, mut v) = ([DVec3::ZERO, DVec3::Z], [DVec3::Z * 3.0, DVec3::ZERO]);
    let loads = ParticleLoads::None;
    let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &[0.0, 0.5] };
    let detect = |x: &[DVec3], set: &mut ContactSet| {
        set.add(0, &material(0.0), &RigidMotion::default(), &[stacked(0, 1, x)]);
        Ok::<(), ResponseError>(())
    };
    let report = ContactStep::default().correct(particles, &params(0.01), detect).expect("valid");
    assert!((report.kinetic_energy - 9.0).abs() < 1e-12, "{report:?}");
    assert!((report.rigid_work - 18.0).abs() < 1e-12, "{report:?}");
}

#[test]
fn a_dropped_tower_comes_to_rest_without_a_gain_of_energy() {
    let (h, count) = (1e-3, 5);
    let mut x: Vec<DVec3> = (0..count).map(|k| DVec3::Z * (1.3 * f64::from(k) + 0.5)).collect();
    let (mut v, w) = (vec![DVec3::ZERO; x.len()], [1.0, 0.1, 2.0, 0.5, 1.0]);
    let energy = |x: &[DVec3], v: &[DVec3]| {
        let heights = x.iter().zip(&w).map(|(x, w)| GRAVITY * x.z / w).sum::<f64>();
        kinetic_energy(&w, v) + heights
    };
    let (start, mut added) = (energy(&x, &v), 0.0);
    let mut step = ContactStep::default();
    for _ in 0..2000 {
        for v in &mut v {
            v.z -= GRAVITY * h;
        }
        let detect = |x: &[DVec3], set: &mut ContactSet| {
            set.add(0, &material(0.0), &RigidMotion::default(), &tower(x));
            Ok::<(), ResponseError>(())
        };
        let loads = ParticleLoads::None;
        let particles = ParticleStates { x: &mut x, v: &mut v, loads, inverse_mass: &w };
        let report = step.correct(particles, &params(h), detect).expect("valid");
        added += GRAVITY * report.mass_moved.z;
        for (x, v) in x.iter_mut().zip(&v) {
            *x += h * *v;
        }
        // What corrections of positions add is a term of its own.
        let gain = energy(&x, &v) - start - added;
        assert!(gain <= 1e-6 * start, "{gain} of {start}");
    }
    assert!(v.iter().all(|v| v.length() < 1e-6), "{v:?}");
}

#[test]
fn a_step_allocates_nothing_after_the_first_few() {
    for method in
        [SolverMethod::GaussSeidel, SolverMethod::AveragedJacobi, SolverMethod::ConjugateGradient]
    {
        let mut world = slab(20.0, 0.2);
        world.material.friction = Friction::static_dynamic(0.3, 0.2).expect("in range");
        let mut step = ContactStep::default();
        let params = StepParams {
            push_tolerance: Some(0.0),
            solver: SolverParams { method, ..params(1e-3).solver },
            ..params(1e-3)
        };
        for frame in 0..10 {
            for v in &mut world.v {
                v.z -= 1e-3 * GRAVITY;
            }
            advance(&mut world, 1e-3);
            let mut forces = vec![DVec3::Z * -GRAVITY; 9];
            let mut found = [on_plane(0, world.x[0], world.normal); 9];
            let detect = |x: &[DVec3], set: &mut ContactSet| {
                for (found, k) in found.iter_mut().zip(0..) {
                    *found = on_plane(k, x[k as usize], world.normal);
                }
                set.add(3, &world.material, &world.motion, &found);
                Ok::<(), ResponseError>(())
            };
            let (x, v, w) = (&mut world.x[..], &mut world.v[..], &world.w[..]);
            let loads = ParticleLoads::Forces(&mut forces);
            let particles = ParticleStates { x, v, loads, inverse_mass: w };
            let mut report = StepReport::default();
            let taken = allocation_counter::measure(|| {
                report = step.correct(particles, &params, detect).expect("valid");
            });
            let is_whole = report.positions.is_some() && report.loads.is_some();
            assert!(is_whole && report.velocities.is_some(), "{report:?}");
            assert!(frame < 4 || taken.count_total == 0, "{method:?}, {frame}: {taken:?}");
        }
    }
}
