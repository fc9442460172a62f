//! Contact steps by each detector: a soft ball of 642 vertices let down on a flat bone, and balls
//! that can no longer be trusted.
#![expect(clippy::print_stdout, reason = "measured values are printed")]

use std::time::Duration;

use decimate::{CoarseSurface, Decimation};
use distance_field::{DistanceField, FieldDetector, FieldParams};
use fixtures::Mesh;
use fixtures::shapes::{icosphere, plate};
use glam::DVec3;
use medial::{MedialDetector, MedialParams};
use proximity::SurfaceTree;
use response::{Friction, Margins, Material, ParticleLoads, SolverParams, StepLength, StepParams};
use scene::{
    BodyId, BodyKind, CheckParams, DetectorParams, Fallback, FallbackReason, PairId, Progress,
    Scene, SceneStates, SceneStep, StepDetectors, StepError, StepMethod,
};

const GRAVITY: f64 = 9810.0;
pub(crate) const H: f64 = 1e-3;
pub(crate) const MARGIN: f64 = 0.5;
pub(crate) const TOLERANCE: f64 = 0.2;

/// Springs of each vertex to its place in the shape at rest about the center \[1/s²\], and their
/// damping \[1/s\].
const STIFFNESS: f64 = 3000.0;
const DAMPING: f64 = 60.0;

/// A ball that keeps its shape by springs, 0.3 above a flat bone.
pub(crate) struct World {
    pub(crate) scene: Scene,
    pub(crate) bone: BodyId,
    pub(crate) ball: BodyId,
    pub(crate) step: SceneStep,
    pub(crate) detectors: StepDetectors,
    rest: Vec<DVec3>,
    pub(crate) x: Vec<DVec3>,
    pub(crate) v: Vec<DVec3>,
    pub(crate) w: Vec<f64>,
    /// Time of the last detection, where it is measured.
    pub(crate) elapsed: Duration,
}

/// Motion of a ball over many steps.
#[derive(Debug, Default)]
pub(crate) struct Measured {
    /// Largest move of a vertex in a step, after settling.
    pub(crate) jitter: f64,
    /// Largest height of the ball's center over its start.
    pub(crate) thrown: f64,
    /// Exact depth left.
    pub(crate) depth: f64,
    fallbacks: usize,
}

impl World {
    pub(crate) fn new(method: StepMethod) -> Self {
        Self::with_bone(method, plate(DVec3::new(80.0, 60.0, 4.0), [24, 18]))
    }

    /// A ball on a bone whose faces look inward.
    pub(crate) fn inside_out(method: StepMethod) -> Self {
        Self::with_bone(method, plate(DVec3::new(80.0, 60.0, 4.0), [24, 18]).flipped())
    }

    fn with_bone(method: StepMethod, bone_mesh: Mesh) -> Self {
        let top = bone_mesh.positions.iter().fold(f64::MIN, |top, x| top.max(x.z));
        let bone_mesh = bone_mesh.translated(DVec3::Z * (2.0 - top));
        let ball_mesh = icosphere(10.0, 3).translated(DVec3::Z * 12.3);
        assert_eq!(ball_mesh.positions.len(), 642, "vertices");

        let mut scene = Scene::new();
        let rest = ball_mesh.positions.clone();
        let bone = scene
            .add("bone", BodyKind::Rigid, bone_mesh.surface(), bone_mesh.positions)
            .expect("a bone");
        let ball = scene
            .add("ball", BodyKind::Deformable, ball_mesh.surface(), ball_mesh.positions)
            .expect("a ball");
        let margins = Margins::new(0.0, MARGIN).expect("in range");
        let friction = Friction::coulomb(0.5).expect("in range");
        let step = SceneStep::new(Material { friction, ..Material::hard(margins) });
        let x = scene.particle_positions();
        let (v, w) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);
        // Where the ball is dented, its coarse surface is proved to be near by no less.
        let tolerance = if method == StepMethod::Coarse { 0.6 } else { TOLERANCE };
        let params = DetectorParams { margin: MARGIN, tolerance };
        let detectors = StepDetectors::new(params).expect("in range");
        let mut world =
            Self { scene, bone, ball, step, detectors, rest, x, v, w, elapsed: Duration::ZERO };
        world.add_structures(method);
        world
    }

    fn add_structures(&mut self, method: StepMethod) {
        self.detectors.set_method(PairId::new(self.bone, self.ball), method);
        let bone = self.scene.body(self.bone);
        match method {
            StepMethod::Field => {
                let (surface, x) = (bone.surface(), bone.checked_positions());
                let params = FieldParams::new(0.5);
                let field = DistanceField::build(surface, x, &params, Progress::none());
                let detector = FieldDetector::new(field.expect("closed"), MARGIN);
                self.detectors.set_field(self.bone, detector.expect("in range"));
            }
            StepMethod::Coarse => {
                let ball = self.scene.body(self.ball);
                let full = SurfaceTree::new(ball.surface().clone(), ball.positions().to_vec());
                let decimation = Decimation::new(full.expect("small"), Progress::none());
                let decimation = decimation.expect("closed");
                let reduced = decimation.within(0.15, Progress::none()).expect("reduced");
                assert!(reduced.kept.len() < 500, "{}", reduced.kept.len());
                let coarse = CoarseSurface::new(reduced, decimation.full());
                self.detectors.set_coarse(self.ball, coarse.expect("attached"));
                let followers = self.detectors.followers(&self.scene).expect("valid");
                self.step.set_followers(followers);
            }
            StepMethod::Balls => {
                for (id, balls) in [(self.bone, 150), (self.ball, 4)] {
                    let balls = balls_of(&self.scene, id, balls, MARGIN + 2.0);
                    self.detectors.set_balls(id, balls);
                }
            }
            _ => {}
        }
    }

    /// Advances by forces, velocities, the contact step, positions; returns the largest move.
    pub(crate) fn advance(&mut self) -> f64 {
        let range = self.scene.body(self.ball).particles();
        let range = range.start as usize..range.end as usize;
        let (x, v) = (&self.x[range.clone()], &mut self.v[range.clone()]);
        let (center, rest_center, mean) = (mean(x), mean(&self.rest), mean(v));
        for ((x, v), rest) in x.iter().zip(v).zip(&self.rest) {
            let place = center + *rest - rest_center;
            let force = STIFFNESS * (place - *x) + DAMPING * (mean - *v);
            *v += H * (force - DVec3::Z * GRAVITY);
        }

        let Self { scene, step, detectors, .. } = self;
        let loads = ParticleLoads::None;
        let states = SceneStates { x: &mut self.x, v: &mut self.v, loads, inverse_mass: &self.w };
        let detect = |scene: &mut Scene, contacts: &mut scene::PairContacts<'_>| {
            detectors.detect(scene, contacts)
        };
        step.correct(scene, states, &params(), detect).expect("valid");

        let mut largest = 0.0_f64;
        for (x, v) in self.x[range.clone()].iter_mut().zip(&self.v[range]) {
            *x += H * *v;
            largest = largest.max(H * v.length());
        }
        largest
    }

    /// Lets the ball down and measures it.
    pub(crate) fn measure(&mut self) -> Measured {
        let mut measured = Measured::default();
        let particles = self.scene.body(self.ball).particles();
        let particles = particles.start as usize..particles.end as usize;
        let start = mean(&self.rest).z;
        for step in 0..500 {
            let moved = self.advance();
            if step >= 400 {
                measured.jitter = measured.jitter.max(moved);
            }
            measured.thrown = measured.thrown.max(mean(&self.x[particles.clone()]).z - start);
            measured.fallbacks += self.detectors.fallbacks().len();
        }
        self.scene.move_body(self.ball, &self.x[particles]).expect("finite");
        let reports =
            self.scene.check(&CheckParams::without_measures(0.0), Progress::none()).expect("valid");
        for report in reports {
            measured.depth = measured.depth.max(report.max_vertex_depth);
        }
        measured
    }
}

fn params() -> StepParams {
    StepParams {
        solver: SolverParams { max_iterations: 100, tolerance: 1e-9, ..SolverParams::default() },
        ..StepParams::new(StepLength::new(H).expect("in range"))
    }
}

fn mean(x: &[DVec3]) -> DVec3 {
    x.iter().sum::<DVec3>() / f64::from(u32::try_from(x.len()).expect("few"))
}

fn balls_of(scene: &Scene, id: BodyId, count: usize, margin: f64) -> MedialDetector {
    let (body, params) = (scene.body(id), MedialParams::balls(count));
    let (surface, x) = (body.surface(), body.checked_positions());
    MedialDetector::new(surface, x, margin, &params, Progress::none()).expect("a closed body")
}

fn assert_rests(method: StepMethod) {
    assert_rests_in(World::new(method), method);
}

fn assert_rests_in(mut world: World, method: StepMethod) {
    let measured = world.measure();
    println!("measured: rest by {method:?}, jitter {:.1e} | {} |", measured.jitter, 5e-3);
    assert_eq!(measured.fallbacks, 0, "{method:?}: {measured:?}");
    assert!(measured.jitter <= 5e-3, "{method:?}: {measured:?}");
    assert!(measured.thrown <= 0.0, "{method:?}: {measured:?}");
    assert!(measured.depth <= TOLERANCE, "{method:?}: {measured:?}");
}

#[test]
fn a_soft_ball_rests_on_a_bone_that_is_inside_out() {
    for method in [StepMethod::Exact, StepMethod::Field] {
        let world = World::inside_out(method);
        assert!(world.scene.body(world.bone).is_inside_out());
        assert_rests_in(world, method);
    }
}

#[test]
fn a_soft_ball_rests_by_exact_surfaces() {
    assert_rests(StepMethod::Exact);
}

#[test]
fn a_soft_ball_rests_by_coarse_surfaces() {
    assert_rests(StepMethod::Coarse);
}

#[test]
fn a_soft_ball_rests_by_a_field() {
    assert_rests(StepMethod::Field);
}

/// The balls of the soft ball do not follow its dent: their own gaps are off by it, and throw it.
#[test]
fn a_soft_ball_rests_by_balls() {
    assert_rests(StepMethod::Balls);
}

/// Gaps by balls alone are what throws a body: where the ball is dented, they report a depth that
/// is not there.
#[test]
fn balls_that_select_do_not_measure() {
    let mut world = World::new(StepMethod::Balls);
    let mut alone = balls_of(&world.scene, world.ball, 4, MARGIN);
    for _ in 0..300 {
        world.advance();
    }
    let found = world.scene.medial_contacts(world.bone, world.ball, &mut alone).expect("valid");
    let false_depth = found.iter().map(|found| -found.contact.gap).fold(0.0, f64::max);
    println!("measured: false depth of the balls of a dented body | {false_depth:.2} |");
    assert!(false_depth > 0.05, "{false_depth}");
}

/// Balls that a deformed body extends beyond by more than their margin and the tolerance are not
/// used: the pair is detected exactly, and reported.
#[test]
fn balls_that_miss_the_surface_are_not_trusted() {
    let mut world = World::new(StepMethod::Balls);
    let margin = MARGIN + 0.2;
    world.detectors.set_balls(world.ball, balls_of(&world.scene, world.ball, 4, margin));
    world.advance();
    assert_eq!(world.detectors.fallbacks(), []);

    // A spike of one vertex, which no ball follows.
    let first = world.scene.body(world.ball).particles().start as usize;
    let lowest = (0..642).min_by(|a, b| world.rest[*a].z.total_cmp(&world.rest[*b].z));
    world.x[first + lowest.expect("vertices")].z -= 3.0;
    world.advance();
    let [fallback] = world.detectors.fallbacks() else { panic!("one pair") };
    let pair = PairId::new(world.bone, world.ball);
    assert_eq!((fallback.pair, fallback.method), (pair, StepMethod::Balls));
    let FallbackReason::BallDeviation { body, bound, allowed } = fallback.reason else {
        panic!("{fallback:?}")
    };
    assert!(body == world.ball && (allowed - margin - TOLERANCE).abs() < 1e-12, "{fallback:?}");
    assert!((allowed..3.1).contains(&bound), "{fallback:?}");
}

#[test]
fn a_method_without_its_structure_is_reported() {
    for method in [StepMethod::Coarse, StepMethod::Field, StepMethod::Balls] {
        let mut world = World::new(StepMethod::Exact);
        world.detectors.set_default_method(StepMethod::Exact);
        world.detectors.set_method(PairId::new(world.ball, world.bone), method);
        world.advance();
        let [fallback] = world.detectors.fallbacks() else { panic!("one pair") };
        assert_eq!((fallback.method, fallback.reason), (method, FallbackReason::NoStructure));
    }
}

/// Two coarse surfaces may both be inside the bodies' own: an overlap of both bodies that is deeper than
/// the tolerance is in contact, or the pair detected exactly.
#[test]
fn two_coarse_surfaces_share_the_tolerance() {
    let mesh = icosphere(10.0, 4);
    let meshes = [(DVec3::new(1.0, 2.0, 3.0), 0.125), (DVec3::new(3.0, 1.0, 2.0), 0.2125)]
        .map(|(axis, turns)| mesh.clone().rotated(axis, turns));
    for (tolerance, is_exact) in [(0.3, true), (0.6, false)] {
        let params = DetectorParams { margin: 0.0, tolerance };
        let mut detectors = StepDetectors::new(params).expect("in range");
        detectors.set_default_method(StepMethod::Coarse);
        let (mut scene, mut ids) = (Scene::new(), Vec::new());
        for (number, mesh) in meshes.iter().enumerate() {
            let (surface, x) = (mesh.surface(), mesh.positions.clone());
            let id = scene.add(number.to_string(), BodyKind::Deformable, surface, x);
            ids.push(id.expect("a ball"));
            detectors.set_coarse(ids[number], coarse_within(mesh, 0.3));
        }

        for step in 0..10 {
            let at = (19.7 - 0.012 * f64::from(step)) * DVec3::X;
            let x: Vec<DVec3> = meshes[1].positions.iter().map(|p| *p + at).collect();
            scene.move_body(ids[1], &x).expect("a move");
            let reports = scene.check(&CheckParams::new(0.0), Progress::none()).expect("a check");
            let depth = reports[0].max_depth().expect("they overlap").lower;
            let contacts = count_contacts(&mut scene.clone(), &mut detectors);
            let fallbacks = detectors.fallbacks();
            assert!(
                contacts > 0 || !fallbacks.is_empty() || depth <= tolerance,
                "{depth} undetected"
            );

            // The second body is allowed what the first has left.
            assert_eq!(!fallbacks.is_empty(), is_exact);
            for Fallback { reason, .. } in fallbacks {
                let FallbackReason::CoarseDeviation { body, bound, allowed } = *reason else {
                    panic!("{reason:?}")
                };
                assert!(body == ids[1] && bound <= 0.3 && allowed < bound, "{reason:?}");
            }
        }
    }
}

/// Reduces a mesh within a deviation.
fn coarse_within(mesh: &Mesh, deviation: f64) -> CoarseSurface {
    let full = SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("small");
    let decimation = Decimation::new(full, Progress::none()).expect("closed");
    let reduced = decimation.within(deviation, Progress::none()).expect("reduced");
    CoarseSurface::new(reduced, decimation.full()).expect("attached")
}

/// Counts the contacts of the first detection of a step.
fn count_contacts(scene: &mut Scene, detectors: &mut StepDetectors) -> usize {
    let mut step = SceneStep::new(Material::hard(Margins::new(0.0, 0.1).expect("in range")));
    let mut x = scene.particle_positions();
    let (mut v, inverse_mass) = (vec![DVec3::ZERO; x.len()], vec![1.0; x.len()]);
    let loads = ParticleLoads::None;
    let states = SceneStates { x: &mut x, v: &mut v, loads, inverse_mass: &inverse_mass };
    let params = StepParams::new(StepLength::new(H).expect("positive"));
    let mut first = None;
    let corrected = step.correct(scene, states, &params, |scene, contacts| {
        detectors.detect(scene, contacts)?;
        first.get_or_insert(contacts.len());
        Ok::<(), StepError>(())
    });
    corrected.expect("a step");
    first.unwrap_or(0)
}
