//! Contact steps with a plan as the detector, over reduced surfaces.

use std::ops::Range;

use fixtures::shapes::{icosphere, plate};
use glam::{DQuat, DVec3};
use plan::{Detection, DetectionMethod, ForcedMethod, Plan, PlanError, PlanParams, StructureKind};
use response::{
    Margins, Material, ParticleLoads, RigidMotion, SolverParams, StepLength, StepParams, StepReport,
};
use scene::{
    BodyId, BodyKind, CheckParams, PairContacts, PairId, Progress, Scene, SceneStates, SceneStep,
};
use surface::Pose;

use crate::plan;

const H: f64 = 1e-3;

/// Accepted error of a depth, of which each surface may deviate by a part.
const TOLERANCE: f64 = 1.5;

/// A bone and two soft balls in a row, whose surfaces are reduced.
struct World {
    scene: Scene,
    ids: Vec<BodyId>,
    plan: Plan,
    detection: Detection,
    step: SceneStep,
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    w: Vec<f64>,
    /// Allocations of the detections of the last step.
    by_detection: u64,
}

impl World {
    fn new() -> Self {
        let mut scene = Scene::new();
        let ball = icosphere(30.0, 4);
        for (name, along) in [("bone", 0.0), ("first", 62.5), ("second", 122.8)] {
            let kind = if name == "bone" { BodyKind::Rigid } else { BodyKind::Deformable };
            let x = ball.positions.iter().map(|p| *p + DVec3::X * along).collect();
            scene.add(name, kind, ball.surface(), x).expect("a body");
        }
        let params = PlanParams {
            margin: 1.0,
            max_displacement: 20.0,
            ..PlanParams::with_tolerance(TOLERANCE)
        };
        let ids: Vec<BodyId> = scene.ids().collect();
        let mut forced = Vec::new();
        for [a, b] in [[0, 1], [0, 2], [1, 2]] {
            let (pair, method) = (PairId::new(ids[a], ids[b]), DetectionMethod::Coarse);
            forced.push(ForcedMethod { pair, method });
        }
        let plan = Plan::with_forced(&mut scene, &params, &forced, Progress::none());
        let plan = plan.expect("a plan");
        let mut step = SceneStep::new(Material::hard(Margins::new(0.0, 1.0).expect("in range")));
        step.set_followers(plan.followers(&scene).expect("of this scene"));
        let x = scene.particle_positions();
        let w = (0..x.len()).map(|k| [1.0, 0.2, 3.0][k % 3]).collect();
        let (detection, v) = (Detection::default(), vec![DVec3::ZERO; x.len()]);
        Self { scene, ids, plan, detection, step, x, v, w, by_detection: 0 }
    }

    fn range(&self, body: usize) -> Range<usize> {
        let particles = self.scene.body(self.ids[body]).particles();
        particles.start as usize..particles.end as usize
    }

    fn correct(&mut self) -> StepReport {
        let Self { scene, plan, detection, step, x, v, w, by_detection, .. } = self;
        *by_detection = 0;
        let states = SceneStates { x, v, loads: ParticleLoads::None, inverse_mass: w };
        let solver = SolverParams { max_iterations: 200, tolerance: 1e-9, ..Default::default() };
        let params = StepParams {
            depth_tolerance: Some(1e-6),
            solver,
            ..StepParams::new(StepLength::new(H).expect("in range"))
        };
        let detect = |scene: &mut Scene, contacts: &mut PairContacts<'_>| {
            let taken = allocation_counter::measure(|| {
                plan.detect(scene, detection).expect("of this scene");
            });
            *by_detection += taken.count_total;
            for pair in detection.pairs() {
                contacts.add(pair.pair, &detection.contacts()[pair.contacts.clone()]);
            }
            Ok::<(), PlanError>(())
        };
        step.correct(scene, states, &params, detect).expect("valid")
    }
}

#[test]
fn vertices_that_reduced_surfaces_left_out_move_with_the_contact() {
    let mut world = World::new();
    let coarse = world.plan.structures().iter().filter(|s| s.kind == StructureKind::Coarse);
    assert!(coarse.count() >= 2, "{}", world.plan);

    // The balls run into each other and then, together, into the bone.
    let (first, second) = (world.range(1), world.range(2));
    for k in first.start..second.end {
        world.v[k] = DVec3::X * if k < second.start { -20.0 } else { -220.0 };
    }
    let (mut deepest, mut impulse) = (0.0_f64, DVec3::ZERO);
    let momentum = |world: &World| {
        let all = first.start..second.end;
        all.map(|k| world.v[k] / world.w[k]).sum::<DVec3>()
    };
    let start = momentum(&world);
    let mut free_steps = 0;
    for _ in 0..60 {
        let report = world.correct();
        let bone = world.ids[0];
        let is_free = world.detection.pairs().iter().all(|found| !found.pair.contains(bone));
        if is_free && report.velocities.is_some() {
            // Masses differ, and so do those of the vertices that were left out.
            let given = report.impulse.length() + report.mass_moved.length() / H;
            assert!(given < 1e-11 * start.length(), "two free bodies gain {given}");
            free_steps += 1;
        }
        impulse += report.impulse;
        deepest = deepest.max(report.depth);
        for k in first.start..second.end {
            world.x[k] += H * world.v[k];
        }
    }
    assert!(free_steps >= 3, "{free_steps}");
    impulse += world.correct().impulse;

    // What the bone gives is all that the momentum has changed by.
    let change = momentum(&world) - start;
    let scale = start.length();
    assert!((change - impulse).length() < 1e-9 * scale, "{change} of {impulse}");
    let reports =
        world.scene.check(&CheckParams::without_measures(0.0), Progress::none()).expect("valid");
    let depth = reports.iter().map(|report| report.max_vertex_depth).fold(0.0, f64::max);
    assert!(depth < TOLERANCE, "exact overlap left: {depth}, by the detector {deepest}");
}

#[test]
fn a_step_over_a_scene_allocates_nothing_after_a_few() {
    let mut world = World::new();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    one.install(|| {
        let mut contacts = 0;
        for frame in 0..40_u32 {
            let way = 2.7 + 0.1 * f64::from(frame % 4);
            let pose = Pose::new(DQuat::from_rotation_z(0.01 * way), DVec3::X * way);
            let motion = RigidMotion { velocity: DVec3::X, ..RigidMotion::default() };
            let bone = world.ids[0];
            let taken = allocation_counter::measure(|| {
                world.step.move_bone(&mut world.scene, bone, &pose, motion).expect("a bone");
                contacts += world.correct().contacts;
            });
            // Detection allocates only where it searches for the depth of surfaces.
            let own = taken.count_total - world.by_detection;
            assert!(frame < 8 || own == 0, "frame {frame} allocated {own} times");
        }
        assert!(contacts > 100, "{contacts}");
    });
}

/// Lowers a soft ball onto a plate 2 thick by `drop` per step, with positions corrected after each;
/// returns the lowest vertex over the plate's middle, and the largest number of unknown sides.
fn press(kind: BodyKind, drop: f64, margin: f64) -> (f64, usize) {
    let (plate, ball) = (plate(DVec3::new(80.0, 60.0, 2.0), [40, 30]), icosphere(10.0, 3));
    let top = plate.positions.iter().fold(f64::MIN, |top, x| top.max(x.z));
    let ball = ball.translated(DVec3::Z * (top + 10.2));
    let mut scene = Scene::new();
    scene.add("plate", kind, plate.surface(), plate.positions).expect("a plate");
    let soft = scene.add("ball", BodyKind::Deformable, ball.surface(), ball.positions);
    let first = scene.body(soft.expect("a ball")).particles().start as usize;

    let params = PlanParams { margin, ..PlanParams::with_tolerance(0.05) };
    let mut plan = plan(&mut scene, &params);
    let mut step = SceneStep::new(Material::hard(Margins::new(0.0, 1.0).expect("in range")));
    let (mut x, mut detection) = (scene.particle_positions(), Detection::default());
    let (mut v, mut w) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);
    w[..first].fill(0.0);
    let (mut lowest, mut unknown) = (f64::MAX, 0);
    for _ in 0..4 {
        let states =
            SceneStates { x: &mut x, v: &mut v, loads: ParticleLoads::None, inverse_mass: &w };
        let params = StepParams {
            depth_tolerance: Some(1e-6),
            approach_tolerance: None,
            ..StepParams::new(StepLength::new(H).expect("in range"))
        };
        step.correct(&mut scene, states, &params, |scene, contacts| {
            plan.detect(scene, &mut detection)?;
            for pair in detection.pairs() {
                contacts.add(pair.pair, &detection.contacts()[pair.contacts.clone()]);
            }
            Ok::<(), PlanError>(())
        })
        .expect("valid");
        unknown = unknown.max(step.unknown_sides());
        lowest = x[first..].iter().fold(lowest, |lowest, x| lowest.min(x.z - top + 1.0));
        for x in &mut x[first..] {
            x.z -= drop;
        }
    }
    (lowest, unknown)
}

#[test]
fn no_vertex_leaves_a_thin_plate_by_the_far_side() {
    for drop in [0.8, 1.2, 1.6, 1.95] {
        // A bone, and a soft body that cannot move.
        for kind in [BodyKind::Rigid, BodyKind::Deformable] {
            let (lowest, unknown) = press(kind, drop, 2.5);
            assert!(lowest > -1.0 && unknown == 0, "{drop} a step: {lowest}, {unknown} unknown");
            // Almost through a soft plate, contacts of its far vertices slow the way back.
            assert!(lowest > 0.9 || drop > 1.9, "{drop} a step: {lowest}");
        }
    }

    // Without a margin, vertices are first detected inside: where they were in the last step tells.
    let (lowest, unknown) = press(BodyKind::Rigid, 1.6, 0.0);
    assert!(lowest > -1.0 && unknown == 0, "{lowest}, {unknown} unknown");
}
