//! Contacts that a step meets on its way: bodies so fast that no state shows them.

use ccd::CcdParams;
use fixtures::Mesh;
use fixtures::shapes::{icosphere, plate, tetrahedron};
use glam::{DQuat, DVec3};
use response::{
    Margins, Material, ParticleLoads, ResponseError, RigidMotion, SolverMethod, SolverParams,
    StepLength, StepParams, StepReport, SweptReport,
};
use scene::{
    BodyId, BodyKind, BodyMove, CheckParams, DetectorParams, PairReport, Progress, Scene,
    SceneStates, SceneStep, StepDetectors, StepError,
};
use surface::Pose;

const H: f64 = 1e-3;

/// Speed to which solvers are exact: in a step, a move of 1e-3.
const SPEED: f64 = 1.0;

/// A ball of 10 with its lowest vertex 5 above a bone 2 thick.
struct World {
    scene: Scene,
    bone: BodyId,
    ball: BodyId,
    step: SceneStep,
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    w: Vec<f64>,
}

impl World {
    fn new(height: f64, velocity: DVec3) -> Self {
        Self::with_bone(plate(DVec3::new(80.0, 60.0, 2.0), [12, 9]), height, velocity)
    }

    fn with_bone(bone: Mesh, height: f64, velocity: DVec3) -> Self {
        let top = bone.positions.iter().fold(f64::MIN, |top, x| top.max(x.z));
        let bone = bone.translated(-DVec3::Z * top);
        let ball = icosphere(10.0, 2);
        let low = ball.positions.iter().fold(f64::MAX, |low, x| low.min(x.z));
        let ball = ball.translated(DVec3::new(0.3, 0.2, height - low));

        let mut scene = Scene::new();
        let bone = scene.add("bone", BodyKind::Rigid, bone.surface(), bone.positions);
        let ball = scene.add("ball", BodyKind::Deformable, ball.surface(), ball.positions);
        let (bone, ball) = (bone.expect("a bone"), ball.expect("a ball"));
        let step = SceneStep::new(Material::hard(Margins::new(0.0, 0.5).expect("in range")));
        let x = scene.particle_positions();
        let (mut v, w) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);
        v[scene.body(ball).particles().start as usize..].fill(velocity);
        Self { scene, bone, ball, step, x, v, w }
    }

    /// Corrects by static contacts, then by swept ones.
    fn correct(&mut self, params: &StepParams) -> (StepReport, SweptReport) {
        self.correct_within(params, &CcdParams::DEFAULT)
    }

    fn correct_within(
        &mut self,
        params: &StepParams,
        ccd: &CcdParams,
    ) -> (StepReport, SweptReport) {
        let params_of_detectors = DetectorParams { margin: 0.5, tolerance: 0.0 };
        let mut detectors = StepDetectors::new(params_of_detectors).expect("in range");
        let Self { scene, step, x, v, w, .. } = self;
        let loads = ParticleLoads::None;
        let states = SceneStates { x, v, loads, inverse_mass: w };
        let detect = |scene: &mut Scene, contacts: &mut scene::PairContacts<'_>| {
            detectors.detect(scene, contacts)
        };
        let mut report = step.correct(scene, states, params, detect).expect("valid");
        let loads = ParticleLoads::None;
        let states = SceneStates { x, v, loads, inverse_mass: w };
        let swept = step.correct_swept(scene, states, params, ccd, &mut report).expect("valid");
        (report, swept)
    }

    /// Moves the ball for a share of the step, and returns the exact depth.
    fn advance(&mut self, share: f64, bone_velocity: DVec3) -> f64 {
        let first = self.scene.body(self.ball).particles().start as usize;
        let mut x = self.x[first..].to_vec();
        for (x, v) in x.iter_mut().zip(&self.v[first..]) {
            *x += share * H * *v;
        }
        let pose = Pose::new(DQuat::IDENTITY, share * H * bone_velocity);
        self.scene.pose_body(self.bone, &pose).expect("a bone");
        self.scene.move_body(self.ball, &x).expect("finite");
        let reports =
            self.scene.check(&CheckParams::without_measures(0.0), Progress::none()).expect("valid");
        reports.iter().map(|report| report.max_vertex_depth).fold(0.0, f64::max)
    }
}

fn params(max_rounds: u32) -> StepParams {
    let method = SolverMethod::ConjugateGradient;
    let solver = SolverParams { method, max_iterations: 300, tolerance: SPEED };
    let h = StepLength::new(H).expect("in range");
    StepParams { solver, max_rounds, ..StepParams::new(h) }
}

#[test]
fn a_ball_does_not_tunnel_through_a_plate() {
    // By 30 in a step: from 5 above the plate to a place below it.
    let fast = DVec3::new(200.0, 0.0, -30_000.0);
    let mut world = World::new(5.0, fast);
    let (report, swept) = world.correct(&params(10));
    assert!(swept.rounds >= 1 && swept.contacts > 0, "{swept:?}");
    assert!(swept.free_share >= 1.0, "{swept:?}");
    let first = world.scene.body(world.ball).particles().start as usize;
    let gained: DVec3 = world.v[first..].iter().map(|v| *v - fast).sum();
    assert!((report.impulse - gained).length() <= 1e-12 * gained.length(), "{report:?}");
    // Vertices of the plate push faces of the ball along their normals: little to the side.
    assert!(gained.truncate().length() < 2e-3 * gained.z, "no friction: {gained}");
    let depth = world.advance(1.0, DVec3::ZERO);
    assert!(depth <= 2.0 * SPEED * H, "depth {depth} at the end of the move");

    // The way to the gap's end is not cut: vertices touch the plate.
    let low = world.scene.body(world.ball).positions().iter().map(|x| x.z);
    let low = low.fold(f64::MAX, f64::min);
    assert!(low.abs() <= 2.0 * SPEED * H, "{low}");
}

/// What is met on the way is held at the minimum separation, and no nearer.
#[test]
fn a_ball_that_is_met_keeps_the_minimum_separation() {
    let ccd = CcdParams { min_separation: 0.25, ..CcdParams::DEFAULT };
    let mut world = World::new(5.0, DVec3::new(200.0, 0.0, -30_000.0));
    let (_, swept) = world.correct_within(&params(10), &ccd);
    assert!(swept.contacts > 0 && swept.free_share >= 1.0, "{swept:?}");

    // Gaps are those of the start, of objects that touch at the separation.
    let contacts = world.step.contact_step().contacts().contacts();
    assert!(contacts.iter().any(|contact| contact.time.is_some()), "contacts of the move");
    for contact in contacts {
        let error = contact.identity_error(|particle| world.x[particle as usize]);
        assert!(error < 1e-12, "{error:e}: {contact:?}");
        let offset = if contact.time.is_some() { ccd.min_separation } else { 0.0 };
        assert!(contact.offset.total_cmp(&offset).is_eq(), "{contact:?}");
    }
    assert!(world.advance(1.0, DVec3::ZERO) <= 0.0, "apart at the end of the move");
    let heights = world.scene.body(world.ball).positions().iter().map(|x| x.z);
    let low = heights.fold(f64::MAX, f64::min);
    assert!((low - 0.25).abs() <= 2.0 * SPEED * H, "{low}");
}

/// Bodies with edges and corners meet by edges, which turn as the ball gives way.
#[test]
fn nothing_overlaps_within_the_free_share() {
    let tips = tetrahedron(14.0);
    for number in 0..12 {
        let angle = 0.5 * f64::from(number);
        let turn = DQuat::from_rotation_z(angle) * DQuat::from_rotation_x(0.3 + angle);
        let mut bone = tips.clone();
        bone.positions.iter_mut().for_each(|x| *x = turn * *x);
        let mut world = World::with_bone(bone, 1.0, DVec3::new(2000.0, 1000.0, -7000.0));
        let mut params = params(20);
        params.solver.tolerance = 1e-3 * SPEED;
        let (_, swept) = world.correct(&params);
        assert!(swept.contacts > 0, "{number}: {swept:?}");
        world.advance(swept.free_share, DVec3::ZERO);
        let reports = world.scene.check(&CheckParams::new(0.0), Progress::none()).expect("valid");
        let depths = reports.iter().filter_map(PairReport::max_depth).map(|depth| depth.lower);
        let depth = depths.fold(0.0, f64::max);
        assert!(swept.free_share >= 1.0, "{number}: {swept:?}");
        assert!(depth <= 2e-3 * SPEED * H, "{number}: depth {depth}, {swept:?}");
    }
}

/// A ball that is mirrored on its way faces inward when it meets the bone. It is held as any other: it was outside at
/// the start.
#[test]
fn tissue_that_turns_inside_out_on_its_way_is_held() {
    // With a corner up, which meets a face of the ball.
    let mut bone = tetrahedron(14.0);
    let turn = DQuat::from_rotation_arc(bone.positions[0].normalize(), DVec3::Z);
    bone.positions.iter_mut().for_each(|x| *x = turn * *x);
    let mut world = World::with_bone(bone, 5.0, DVec3::ZERO);
    let first = world.scene.body(world.ball).particles().start as usize;
    for (x, v) in world.x[first..].iter().zip(&mut world.v[first..]) {
        *v = DVec3::new(2.0 * (0.3 - x.x), 0.0, -7.0) / H;
    }
    let (_, swept) = world.correct(&params(0));
    let ends = world.x[first..].iter().zip(&world.v[first..]).map(|(x, v)| *x + H * *v);
    let ends: Vec<DVec3> = ends.collect();
    let moves = [BodyMove { body: world.ball, positions: &ends }];
    let report = world.scene.sweep(&moves, &CcdParams::DEFAULT, Progress::none());
    let free = report.expect("valid").largest_free_step;
    assert!((0.6..0.9).contains(&free), "{free}: mirrored by then");
    assert!((swept.free_share - free).abs() < 1e-9, "{swept:?}, free to {free}");
}

/// Faces of a plate that look inward stop what comes from outside, too.
#[test]
fn a_ball_does_not_tunnel_through_a_plate_that_is_inside_out() {
    let fast = DVec3::new(200.0, 0.0, -30_000.0);
    let plate = plate(DVec3::new(80.0, 60.0, 2.0), [12, 9]).flipped();
    let mut world = World::with_bone(plate, 5.0, fast);
    let (_, swept) = world.correct(&params(10));
    assert!(swept.rounds >= 1 && swept.contacts > 0 && swept.free_share >= 1.0, "{swept:?}");
    let depth = world.advance(1.0, DVec3::ZERO);
    assert!(depth <= 2.0 * SPEED * H, "depth {depth} at the end of the move");
    let heights = world.scene.body(world.ball).positions().iter().map(|x| x.z);
    let low = heights.fold(f64::MAX, f64::min);
    assert!(low >= -2.0 * SPEED * H, "{low}: below the plate");
}

#[test]
fn a_fast_bone_takes_the_ball_along() {
    let velocity = DVec3::Z * 20_000.0;
    let mut world = World::new(5.0, DVec3::ZERO);
    let motion = RigidMotion { velocity, ..RigidMotion::default() };
    let World { scene, step, bone, .. } = &mut world;
    step.move_bone(scene, *bone, &Pose::IDENTITY, motion).expect("a bone");
    let (report, swept) = world.correct(&params(10));
    assert!(swept.free_share >= 1.0 && swept.contacts > 0, "{swept:?}");
    assert!(report.impulse.z > 0.0 && report.rigid_work > 0.0, "{report:?}");
    let depth = world.advance(1.0, velocity);
    assert!(depth <= 2.0 * SPEED * H, "depth {depth}");
}

/// Without corrections, the step tells how far it is free.
#[test]
fn a_step_may_stop_at_the_first_contact() {
    let fast = DVec3::Z * -30_000.0;
    let mut world = World::new(5.0, fast);
    let (_, swept) = world.correct(&params(0));
    assert_eq!((swept.rounds, swept.contacts), (0, 0));
    assert!((swept.free_share - 5.0 / 30.0).abs() < 1e-6, "{swept:?}");
    let first = world.scene.body(world.ball).particles().start as usize;
    assert!(world.v[first..].iter().all(|v| *v == fast), "velocities stay");
    assert!(world.advance(swept.free_share, DVec3::ZERO) <= 0.0);

    // No state would show it: the whole move ends on the other side.
    assert!(world.advance(1.0, DVec3::ZERO) <= 0.0);
    let passed = world.scene.body(world.ball).positions().iter().all(|x| x.z < -2.0);
    assert!(passed, "through the bone");
}

/// What starts in a body and leaves it is not held.
#[test]
fn vertices_may_leave_a_body() {
    let up = DVec3::Z * 5000.0;
    let mut world = World::new(-0.7, up);
    let params = StepParams { depth_tolerance: None, ..params(10) };
    let (_, swept) = world.correct(&params);
    assert_eq!(swept, SweptReport { rounds: 0, contacts: 0, free_share: 1.0 });
    let first = world.scene.body(world.ball).particles().start as usize;
    assert!(world.v[first..].iter().all(|v| *v == up));
}

/// Positions and velocities are one per particle of the scene, also where a body was added since.
#[test]
fn states_of_other_counts_are_refused() {
    let params = StepParams::new(StepLength::new(H).expect("in range"));
    for case in 0..3 {
        let mut world = World::new(5.0, DVec3::ZERO);
        let (mut report, _) = world.correct(&params);
        let World { scene, step, x, v, w, .. } = &mut world;
        let mut expected = x.len();
        match case {
            0 => x.truncate(expected - 1),
            1 => x.clear(),
            _ => {
                let late = icosphere(1.0, 0).translated(DVec3::Z * 40.0);
                expected += late.positions.len();
                scene
                    .add("late", BodyKind::Deformable, late.surface(), late.positions)
                    .expect("a body");
            }
        }
        let got = x.len();
        let states = SceneStates { x, v, loads: ParticleLoads::None, inverse_mass: w };
        let swept = step.correct_swept(scene, states, &params, &CcdParams::DEFAULT, &mut report);
        let count = ResponseError::Count { what: "particle states", expected, got };
        assert_eq!(swept.err(), Some(StepError::Response(count)), "case {case}");
    }
}
