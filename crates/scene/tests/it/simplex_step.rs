//! Contact steps of simplex bodies: contacts on the fans of polygons move their vertices.

use fixtures::shapes::{icosphere, plate};
use glam::DVec3;
use response::{
    Margins, Material, ParticleLoads, ResponseError, SolverMethod, SolverParams, StepLength,
    StepParams, StepReport,
};
use scene::{
    BodyId, BodyKind, CheckParams, DetectorParams, Progress, Scene, SceneStates, SceneStep,
    StepDetectors, StepError,
};
use surface::SimplexSurface;

const H: f64 = 1e-3;

/// Adds the dual of a ball: 80 vertices, of which three polygons meet at each.
fn add_ball(scene: &mut Scene, name: &str, center: DVec3) -> BodyId {
    let ball = icosphere(10.0, 1);
    let simplex = SimplexSurface::dual_of(&ball.surface()).expect("closed");
    let mut x = Vec::new();
    for corners in ball.surface().faces() {
        let sum: DVec3 = corners.iter().map(|corner| ball.positions[*corner as usize]).sum();
        x.push(10.0 * sum.normalize() + center);
    }
    scene.add_simplex(name, BodyKind::Deformable, simplex, &x).expect("a body")
}

/// States of a scene: masses of vertices between 1 and 5, none of centers.
struct World {
    scene: Scene,
    step: SceneStep,
    x: Vec<DVec3>,
    v: Vec<DVec3>,
    w: Vec<f64>,
}

impl World {
    fn new(scene: Scene) -> Self {
        let x = scene.particle_positions();
        let mut w = vec![0.0; x.len()];
        for body in scene.bodies() {
            let vertices = body.simplex().map_or(0, SimplexSurface::vertex_count);
            for (k, particle) in (0_u8..).zip(body.particles().take(vertices)) {
                w[particle as usize] = 1.0 / f64::from(1 + k % 5);
            }
        }
        let step = SceneStep::new(Material::hard(Margins::new(0.0, 0.3).expect("in range")));
        Self { scene, step, v: vec![DVec3::ZERO; x.len()], x, w }
    }

    fn push(&mut self, body: BodyId, velocity: DVec3) {
        for particle in self.scene.body(body).particles() {
            self.v[particle as usize] = velocity;
        }
    }

    fn correct(&mut self) -> Result<StepReport, StepError> {
        let params = DetectorParams { margin: 0.3, tolerance: 0.0 };
        let mut detectors = StepDetectors::new(params)?;
        let method = SolverMethod::ConjugateGradient;
        let solver = SolverParams { method, max_iterations: 1000, tolerance: 1e-9 };
        let h = StepLength::new(H)?;
        let params = StepParams { solver, max_rounds: 10, ..StepParams::new(h) };
        let Self { scene, step, x, v, w } = self;
        let loads = ParticleLoads::None;
        let states = SceneStates { x, v, loads, inverse_mass: w };
        step.correct(scene, states, &params, |scene, contacts| detectors.detect(scene, contacts))
    }

    /// Σ m v and Σ m x × v of the vertices.
    fn momenta(&self) -> [DVec3; 2] {
        let (mut linear, mut angular) = (DVec3::ZERO, DVec3::ZERO);
        for ((x, v), w) in self.x.iter().zip(&self.v).zip(&self.w).filter(|(_, w)| **w > 0.0) {
            linear += *v / *w;
            angular += x.cross(*v) / *w;
        }
        [linear, angular]
    }

    /// Asserts that each center is the mean of its polygon, in place and velocity.
    fn assert_centered(&self) {
        for body in self.scene.bodies() {
            let Some(simplex) = body.simplex() else { continue };
            let first = body.particles().start;
            for polygon in 0..u32::try_from(simplex.polygon_count()).expect("few") {
                let vertices = simplex.polygon(polygon);
                let center = first as usize + simplex.vertex_count() + polygon as usize;
                let count = f64::from(u32::try_from(vertices.len()).expect("few"));
                for q in [&self.x, &self.v] {
                    let sum: DVec3 = vertices.iter().map(|v| q[(first + v) as usize]).sum();
                    assert!((sum / count - q[center]).length() < 1e-9, "polygon {polygon}");
                }
            }
        }
    }
}

#[test]
fn simplex_bodies_exchange_momentum() {
    let mut scene = Scene::new();
    let low = add_ball(&mut scene, "low", DVec3::ZERO);
    let high = add_ball(&mut scene, "high", DVec3::new(1.5, -0.7, 18.6));
    let mut world = World::new(scene);
    world.push(low, DVec3::new(0.0, 10.0, 300.0));
    world.push(high, DVec3::new(-50.0, 0.0, -500.0));

    // Whatever the corrected positions are, velocities are corrected there.
    let before = world.v.clone();
    let report = world.correct().expect("valid");
    assert!(report.contacts > 3 && report.rounds > 0, "{report:?}");
    assert!(report.depth_before > 0.1 && report.depth < 1e-9, "{report:?}");
    let solved = report.velocities.expect("they approach");
    assert!(report.approach_before > 100.0 && solved.converged, "{report:?}");
    world.assert_centered();

    let after = world.momenta();
    let corrected = std::mem::replace(&mut world.v, before);
    let before = world.momenta();
    let scale = before[0].length() + after[0].length();
    assert!(before[0].distance(after[0]) < 1e-12 * scale, "{before:?} {after:?}");
    assert!(before[1].distance(after[1]) < 1e-9 * before[1].length(), "{before:?} {after:?}");
    assert!(report.kinetic_energy < 0.0 && corrected != world.v, "{report:?}");
}

#[test]
fn a_simplex_body_rests_on_a_bone() {
    let mut scene = Scene::new();
    let bone = plate(DVec3::new(80.0, 60.0, 4.0), [8, 6]);
    let top = bone.positions.iter().fold(f64::MIN, |top, x| top.max(x.z));
    scene.add("bone", BodyKind::Rigid, bone.surface(), bone.positions).expect("a bone");
    let ball = add_ball(&mut scene, "ball", DVec3::Z * (top + 9.0));
    let mut world = World::new(scene);
    world.push(ball, DVec3::Z * -200.0);
    let [before, _] = world.momenta();
    let report = world.correct().expect("valid");
    let [after, _] = world.momenta();
    assert!((after - before - report.impulse).length() < 1e-12 * before.length(), "{report:?}");
    assert!(report.impulse.z > 0.0, "{report:?}");
    world.assert_centered();

    // The scene is at the corrected positions, free of the bone.
    let reports =
        world.scene.check(&CheckParams::without_measures(0.0), Progress::none()).expect("valid");
    let depth = reports.iter().map(|report| report.max_vertex_depth).fold(0.0, f64::max);
    assert!(depth < 1e-6, "{depth}");
}

#[test]
fn centers_have_no_mass() {
    let mut scene = Scene::new();
    add_ball(&mut scene, "ball", DVec3::ZERO);
    let mut world = World::new(scene);
    world.w.fill(1.0);
    let what = "inverse mass of a combination";
    let refused = world.correct().expect_err("centers have a mass");
    let StepError::Response(ResponseError::Parameter(error)) = &refused else {
        panic!("{refused:?}")
    };
    assert!(refused.to_string().contains(what), "{error:?}");
}
