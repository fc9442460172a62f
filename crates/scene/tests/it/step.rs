//! Contact steps over a scene: a soft ball on a bone, at rest and carried; materials by pair.

use distance_field::{DistanceField, FieldDetector, FieldParams};
use fixtures::shapes::{icosphere, plate};
use glam::{DQuat, DVec3};
use response::{
    Friction, Margins, Material, ParticleLoads, ResponseError, RigidMotion, SolverParams,
    StepLength, StepParams, StepReport,
};
use scene::{
    BodyId, BodyKind, CheckParams, PairId, Progress, Scene, SceneStates, SceneStep, StepError,
};
use surface::{Contact, ContactSide, Pose, RigidState, Term};

const GRAVITY: f64 = 9810.0;
const H: f64 = 1e-3;

fn friction(mu: f64) -> Material {
    let margins = Margins::new(0.0, 0.5).expect("in range");
    Material { friction: Friction::coulomb(mu).expect("in range"), ..Material::hard(margins) }
}

fn params() -> StepParams {
    StepParams {
        solver: SolverParams { max_iterations: 100, tolerance: 1e-9, ..SolverParams::default() },
        ..StepParams::new(StepLength::new(H).expect("in range"))
    }
}

/// A ball on springs between all of its vertices, over a plate.
struct World {
    scene: Scene,
    bone: BodyId,
    ball: BodyId,
    detector: FieldDetector,
    step: SceneStep,
    rest: Vec<DVec3>,
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    w: Vec<f64>,
    pose: Pose,
}

impl World {
    fn new(mu: f64) -> Self {
        // The plate's top is at height 2, and the ball is 0.3 above it.
        let bone_mesh = plate(DVec3::new(80.0, 60.0, 4.0), [8, 6]);
        let bounds = bone_mesh.positions.iter().fold(DVec3::MIN, |top, x| top.max(*x));
        let bone_mesh = bone_mesh.translated(DVec3::Z * (2.0 - bounds.z));
        let ball_mesh = icosphere(10.0, 1).translated(DVec3::Z * 12.3);
        let surface = bone_mesh.surface();
        let at = surface.positions(&bone_mesh.positions).expect("a plate");
        let params = FieldParams::new(0.5);
        let field = DistanceField::build(&surface, at, &params, Progress::none()).expect("a field");
        let detector = FieldDetector::new(field, 0.5).expect("a margin");

        let mut scene = Scene::new();
        let bone = scene.add("bone", BodyKind::Rigid, surface, bone_mesh.positions).expect("bone");
        let rest = ball_mesh.positions.clone();
        let ball = scene
            .add("ball", BodyKind::Deformable, ball_mesh.surface(), ball_mesh.positions)
            .expect("a ball");
        let x = scene.particle_positions();
        let (v, w) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);
        let step = SceneStep::new(friction(mu));
        Self { scene, bone, ball, detector, step, rest, x, v, w, pose: Pose::IDENTITY }
    }

    fn range(&self) -> std::ops::Range<usize> {
        let particles = self.scene.body(self.ball).particles();
        particles.start as usize..particles.end as usize
    }

    /// Forces, velocities, contact step, positions; returns the report and the largest move.
    fn advance(&mut self) -> (StepReport, f64) {
        let range = self.range();
        let (x, v) = (&self.x[range.clone()], &mut self.v[range.clone()]);
        for i in 0..x.len() {
            v[i].z -= GRAVITY * H;
            for j in 0..i {
                let along = (x[j] - x[i]).normalize();
                let longer = x[j].distance(x[i]) - self.rest[j].distance(self.rest[i]);
                let change = H * (300.0 * longer + 2.0 * (v[j] - v[i]).dot(along)) * along;
                v[i] += change;
                v[j] -= change;
            }
        }

        let (bone, ball, pose) = (self.bone, self.ball, self.pose);
        let detector = &self.detector;
        let loads = ParticleLoads::None;
        let states = SceneStates { x: &mut self.x, v: &mut self.v, loads, inverse_mass: &self.w };
        let detect = |scene: &mut Scene, contacts: &mut scene::PairContacts<'_>| {
            let found = scene.field_contacts(ball, detector, &RigidState::at_rest(pose))?;
            let found: Vec<Contact> = found.iter().map(|found| found.contact).collect();
            contacts.add(PairId::new(bone, ball), &found);
            Ok::<(), StepError>(())
        };
        let report = self.step.correct(&mut self.scene, states, &params(), detect).expect("valid");

        let mut largest = 0.0_f64;
        for (x, v) in self.x[range.clone()].iter_mut().zip(&self.v[range]) {
            *x += H * *v;
            largest = largest.max(H * v.length());
        }
        (report, largest)
    }

    fn mean_velocity(&self) -> DVec3 {
        let v = &self.v[self.range()];
        v.iter().sum::<DVec3>() / f64::from(u32::try_from(v.len()).expect("few"))
    }
}

#[test]
fn a_soft_ball_comes_to_rest_on_a_bone() {
    let mut world = World::new(0.5);
    let mut last = StepReport::default();
    let mut largest = 0.0_f64;
    for step in 0..1500 {
        let moved;
        (last, moved) = world.advance();
        if step >= 1000 {
            largest = largest.max(moved);
        }
    }
    assert!(largest <= 5e-3, "moves by {largest} mm a step at rest");
    assert!(last.contacts > 0 && last.depth < 1e-2, "{last:?}");
    // The bone carries the ball's weight.
    let weight = f64::from(u32::try_from(world.range().len()).expect("few")) * GRAVITY;
    assert!((last.impulse.z / (weight * H) - 1.0).abs() < 0.01, "{last:?}");

    let ball = world.ball;
    world.scene.move_body(ball, &world.x[world.range()]).expect("finite");
    let reports =
        world.scene.check(&CheckParams::without_measures(0.0), Progress::none()).expect("valid");
    let depth = reports.iter().map(|report| report.max_vertex_depth).fold(0.0, f64::max);
    assert!(depth < 0.05, "exact overlap left: {depth} mm");
}

#[test]
fn a_bone_that_moves_takes_the_ball_with_it() {
    let mut world = World::new(0.8);
    let velocity = DVec3::X * 40.0;
    for step in 0..800_u32 {
        let way = velocity * H * f64::from(step);
        world.pose = Pose::new(DQuat::IDENTITY, way);
        let motion = RigidMotion { about: way, velocity, ..RigidMotion::default() };
        world
            .step
            .move_bone(&mut world.scene, world.bone, &world.pose, motion)
            .expect("a rigid body");
        world.advance();
    }
    // It stands on a face, so it does not roll: it moves as the bone does.
    let found = world.mean_velocity();
    assert!((found - velocity).length() < 1e-3 * velocity.x, "{found}");
}

/// Contacts of vertices of a soft tetrahedron with bones under them, and velocities after one
/// step.
fn pushed(step: &mut SceneStep, x: Option<usize>) -> Result<Vec<DVec3>, StepError> {
    let (mut scene, mesh) = (Scene::new(), icosphere(1.0, 0));
    let mut add = |name: &str, kind| {
        scene.add(name, kind, mesh.surface(), mesh.positions.clone()).expect("a body")
    };
    let bones = [add("first", BodyKind::Rigid), add("second", BodyKind::Rigid)];
    let tissue = add("tissue", BodyKind::Deformable);
    let first = scene.body(tissue).particles().start;
    let mut at = scene.particle_positions();
    at.truncate(x.unwrap_or(at.len()));
    let mut v = vec![DVec3::new(1.0, 0.0, -1.0); at.len()];
    let w = vec![1.0; at.len()];
    let states =
        SceneStates { x: &mut at, v: &mut v, loads: ParticleLoads::None, inverse_mass: &w };
    step.correct(&mut scene, states, &params(), |_, contacts| {
        for (particle, bone) in (first..).zip(bones) {
            let vertex = [Term { particle, weight: 1.0 }];
            let floor = ContactSide::at_rest(DVec3::ZERO);
            let found = Contact::between(ContactSide::Particles(&vertex), floor, DVec3::Z, 0.0);
            contacts.add(PairId::new(bone, tissue), &[found]);
        }
        Ok::<(), StepError>(())
    })?;
    Ok(v[first as usize..].to_vec())
}

#[test]
fn materials_are_those_of_the_pair() {
    let mut step = SceneStep::new(friction(0.0));
    let ids: Vec<BodyId> = {
        let (mut scene, mesh) = (Scene::new(), icosphere(1.0, 0));
        for name in ["a", "b", "c"] {
            scene.add(name, BodyKind::Open, mesh.surface(), mesh.positions.clone()).expect("body");
        }
        scene.ids().collect()
    };
    step.set_material(PairId::new(ids[2], ids[1]), friction(0.25));
    let v = pushed(&mut step, None).expect("valid");
    assert_eq!(v[0], DVec3::X, "no friction with the first bone");
    assert_eq!(v[1], DVec3::X * 0.75, "friction with the second");
    assert_eq!(v[2], DVec3::new(1.0, 0.0, -1.0));
}

#[test]
fn lists_of_another_length_are_refused() {
    let refused = pushed(&mut SceneStep::new(friction(0.0)), Some(30));
    let expected = ResponseError::Count { what: "particle states", expected: 36, got: 30 };
    assert_eq!(refused, Err(StepError::Response(expected)));
}
