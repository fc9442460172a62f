//! Memory of sides: vertices pushed into a thin bone come out where they went in, by each detector.

use decimate::{CoarseSurface, Decimation};
use distance_field::{DistanceField, FieldDetector, FieldParams};
use fixtures::shapes::{icosphere, plate};
use glam::DVec3;
use medial::{MedialDetector, MedialParams};
use proximity::SurfaceTree;
use response::{
    Margins, Material, ParticleLoads, Restraint, SolverMethod, SolverParams, StepLength, StepParams,
};
use scene::{
    BodyId, BodyKind, DetectorParams, PairId, PermanentParams, Progress, Scene, SceneStates,
    SceneStep, StepDetectors, StepError, StepMethod,
};

const MARGIN: f64 = 0.5;
const THICKNESS: f64 = 2.0;

/// A ball over a bone, its lowest vertex 0.3 above.
struct World {
    scene: Scene,
    ball: BodyId,
    step: SceneStep,
    detectors: StepDetectors,
    /// Positions of the ball at first.
    start: Vec<DVec3>,
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    w: Vec<f64>,
}

impl World {
    fn new(method: StepMethod) -> Self {
        let bone = plate(DVec3::new(30.0, 30.0, THICKNESS), [20, 20]);
        let top = bone.positions.iter().fold(f64::MIN, |top, x| top.max(x.z));
        let bone = bone.translated(-DVec3::Z * top);
        let ball = icosphere(10.0, 3);
        let low = ball.positions.iter().fold(f64::MAX, |low, x| low.min(x.z));
        let ball = ball.translated(DVec3::new(0.3, 0.2, 0.3 - low));

        let mut scene = Scene::new();
        let bone = scene.add("bone", BodyKind::Rigid, bone.surface(), bone.positions);
        let ball = scene.add("ball", BodyKind::Deformable, ball.surface(), ball.positions);
        let (bone, ball) = (bone.expect("a bone"), ball.expect("a ball"));
        let mut step = SceneStep::new(Material::hard(Margins::new(0.0, MARGIN).expect("valid")));
        let params = DetectorParams { margin: MARGIN, tolerance: 0.1 };
        let mut detectors = StepDetectors::new(params).expect("in range");
        detectors.set_default_method(method);

        let (surface, x) = (scene.body(bone).surface(), scene.body(bone).checked_positions());
        match method {
            StepMethod::Field => {
                let params = FieldParams::new(0.5);
                let field = DistanceField::build(surface, x, &params, Progress::none());
                let field = FieldDetector::new(field.expect("closed"), MARGIN);
                detectors.set_field(bone, field.expect("in range"));
            }
            StepMethod::Balls => {
                let params = MedialParams::balls(150);
                let balls =
                    MedialDetector::new(surface, x, MARGIN + 0.6, &params, Progress::none());
                detectors.set_balls(bone, balls.expect("closed"));
            }
            StepMethod::Coarse => {
                let full = scene.body(ball);
                let full = SurfaceTree::new(full.surface().clone(), full.positions().to_vec());
                let decimation = Decimation::new(full.expect("small"), Progress::none());
                let decimation = decimation.expect("closed");
                let reduced = decimation.within(0.04, Progress::none()).expect("reduced");
                let coarse = CoarseSurface::new(reduced, decimation.full());
                detectors.set_coarse(ball, coarse.expect("attached"));
                step.set_followers(detectors.followers(&scene).expect("valid"));
            }
            _ => {}
        }
        let x = scene.particle_positions();
        let (v, w) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);
        let start = scene.body(ball).positions().to_vec();
        Self { scene, ball, step, detectors, start, x, v, w }
    }

    /// Moves the ball down from where it was at first, and corrects positions.
    fn push(&mut self, way: f64) {
        self.push_within(way, Some(0.0));
    }

    /// Moves the ball down, and corrects depths beyond a tolerance, if any.
    fn push_within(&mut self, way: f64, depth_tolerance: Option<f64>) {
        let range = self.scene.body(self.ball).particles();
        for (x, start) in self.x[range.start as usize..].iter_mut().zip(&self.start) {
            *x = *start - DVec3::Z * way;
        }
        let Self { scene, step, detectors, .. } = self;
        let method = SolverMethod::ConjugateGradient;
        let solver = SolverParams { method, max_iterations: 300, tolerance: 1e-6 };
        let h = StepLength::new(1e-3).expect("in range");
        let params =
            StepParams { solver, depth_tolerance, approach_tolerance: None, ..StepParams::new(h) };
        let loads = ParticleLoads::None;
        let states = SceneStates { x: &mut self.x, v: &mut self.v, loads, inverse_mass: &self.w };
        let detect = |scene: &mut Scene, contacts: &mut scene::PairContacts<'_>| {
            detectors.detect(scene, contacts)
        };
        step.correct(scene, states, &params, detect).expect("valid");
    }

    /// Moves the ball down in a step that detects nothing.
    fn push_unseen(&mut self, way: f64) {
        let range = self.scene.body(self.ball).particles();
        for (x, start) in self.x[range.start as usize..].iter_mut().zip(&self.start) {
            *x = *start - DVec3::Z * way;
        }
        let Self { scene, step, x, v, w, .. } = self;
        let params = StepParams::new(StepLength::new(1e-3).expect("in range"));
        let states = SceneStates { x, v, loads: ParticleLoads::None, inverse_mass: w };
        step.correct(scene, states, &params, |_, _| Ok::<(), StepError>(())).expect("valid");
    }

    /// Returns the number of vertices below the middle of the bone, and the lowest height.
    fn far_side(&self) -> (usize, f64) {
        let z = || self.scene.body(self.ball).positions().iter().map(|x| x.z);
        let below = z().filter(|z| *z < -0.5 * THICKNESS).count();
        (below, z().fold(f64::MAX, f64::min))
    }
}

fn assert_stays_out(mut world: World, name: &str) {
    // In contact first, then in by as much as the thickness.
    for way in [1.2, 1.6, THICKNESS] {
        world.push(0.0);
        world.push(way);
        let (below, lowest) = world.far_side();
        assert_eq!(below, 0, "{name}: {below} vertices out of the far side, lowest {lowest}");
        assert_eq!(world.step.unknown_sides(), 0, "{name}");
    }
    assert!(world.detectors.fallbacks().is_empty(), "{name}");
}

#[test]
fn vertices_leave_a_thin_bone_where_they_came_in() {
    for method in [StepMethod::Exact, StepMethod::Coarse, StepMethod::Field, StepMethod::Balls] {
        assert_stays_out(World::new(method), &format!("{method:?}"));
    }
}

/// A vertex that no contact had in the step before comes in by more than half of the thickness: the far
/// side is nearer, but it was outside, over the near one.
#[test]
fn vertices_that_were_near_nothing_leave_where_they_came_in() {
    for method in [StepMethod::Exact, StepMethod::Coarse, StepMethod::Field, StepMethod::Balls] {
        let mut world = World::new(method);
        world.push(-0.4);
        assert!(world.step.contact_step().contacts().contacts().is_empty(), "{method:?}");
        world.push(0.75 * THICKNESS);
        let (below, lowest) = world.far_side();
        assert_eq!((below, world.step.unknown_sides()), (0, 0), "{method:?}: lowest {lowest}");
    }
}

#[test]
fn kept_contacts_stay_on_their_side() {
    for restraint in [Restraint::Sticking, Restraint::Sliding] {
        let mut world = World::new(StepMethod::Exact);
        let ids: Vec<BodyId> = world.scene.ids().collect();
        let params = PermanentParams { restraint, skin: 2.5, attach_within: 0.0 };
        world.detectors.set_permanent(PairId::new(ids[0], ids[1]), params).expect("in range");
        assert_stays_out(world, &format!("{restraint:?}"));
    }
}

/// Without corrections the ball goes in step by step: what was outside is long past, but the sides
/// are remembered.
#[test]
fn sides_are_remembered_while_vertices_are_inside() {
    for method in [StepMethod::Exact, StepMethod::Field, StepMethod::Balls] {
        let mut world = World::new(method);
        for step in 0..=6 {
            world.push_within(0.3 * f64::from(step), None);
            assert_eq!(world.step.unknown_sides(), 0, "{method:?}");
        }

        // Depths up to 1.5 of 2: the nearest side is the far one of many.
        let (mut inside, mut deep) = (0, 0);
        for contact in world.step.contact_step().contacts().contacts() {
            if contact.stencil.terms().len() == 1 && contact.gap < 0.0 {
                assert!(contact.normal.z > 0.0, "{method:?}: {contact:?}");
                inside += 1;
                deep += usize::from(contact.gap < -0.5 * THICKNESS);
            }
        }
        assert!(inside > 20 && deep > 5, "{method:?}: {inside} {deep}");
    }
}

/// A step that is refused, for a velocity that is no number, and taken again.
#[test]
fn a_step_that_fails_forgets_no_side() {
    let mut world = World::new(StepMethod::Exact);
    for step in 0..=4 {
        world.push_within(0.3 * f64::from(step), None);
    }
    let World { scene, step, detectors, x, v, w, .. } = &mut world;
    let last = v.last_mut().expect("particles");
    let before = std::mem::replace(last, DVec3::NAN);
    let params = StepParams::new(StepLength::new(1e-3).expect("in range"));
    let states = SceneStates { x, v, loads: ParticleLoads::None, inverse_mass: w };
    let detect = |scene: &mut Scene, contacts: &mut scene::PairContacts<'_>| {
        detectors.detect(scene, contacts)
    };
    step.correct(scene, states, &params, detect).expect_err("a velocity is no number");
    *world.v.last_mut().expect("particles") = before;
    world.push_within(1.3, None);
    assert_eq!(world.step.unknown_sides(), 0);
}

/// Where the first state is inside, no side is remembered: that is reported.
#[test]
fn sides_that_nothing_tells_are_counted() {
    let mut world = World::new(StepMethod::Exact);
    world.push(THICKNESS);
    assert!(world.step.unknown_sides() > 0);

    // By the nearest side, which is the far one for the deepest.
    let (below, lowest) = world.far_side();
    assert!(below > 0, "lowest {lowest}");

    // Inside before, too, and in no contact: where it was tells nothing.
    let mut world = World::new(StepMethod::Exact);
    world.push_unseen(1.0);
    world.push_within(1.1, None);
    assert!(world.step.unknown_sides() > 0);
}
