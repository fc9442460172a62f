//! Time of construction and of all frames by the chosen plan, over that of forced plans, in
//! operations: the same in every run.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use plan::{DetectionMethod, ForcedMethod, OperationCounts, Plan, PlanParams};
use scene::{BodyKind, PairId, Scene};
use surface::progress::Progress;

use crate::{detect, three_of};

/// Numbers of frames that plans are made for.
const FRAMES: [u32; 4] = [1, 100, 10_000, 1_000_000];

/// Times of a plan by its operations \[s\].
#[derive(Clone, Copy, Debug)]
struct PlanSeconds {
    build: f64,
    frame: f64,
}

impl PlanSeconds {
    /// Adds up the construction and one frame of a plan, as counted.
    fn of(plan: &mut Plan, scene: &mut Scene) -> Self {
        detect(plan, scene);
        let mut build = OperationCounts::default();
        for structure in plan.structures() {
            build = build + structure.operations;
        }
        Self { build: build.seconds(), frame: plan.operations().seconds() }
    }

    fn over(self, frames: u32) -> f64 {
        self.build + f64::from(frames) * self.frame
    }
}

/// Builds a bone and a muscle.
fn pair_of(bone: &Mesh, muscle: &Mesh) -> Scene {
    let mut scene = Scene::new();
    for (name, kind, mesh) in
        [("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle)]
    {
        scene.add(name, kind, mesh.surface(), mesh.positions.clone()).expect("a body");
    }
    scene
}

/// Builds the scenes of the table.
fn scenes() -> Vec<(&'static str, Scene)> {
    let muscle = shapes::ellipsoid(DVec3::new(20.0, 20.0, 40.0), 4);
    let spike = shapes::ellipsoid(DVec3::new(15.0, 1.0, 1.0), 2).translated(DVec3::X * 29.0);
    let plate = shapes::plate(DVec3::new(60.0, 60.0, 40.0), [1, 1]).translated(DVec3::Z * -20.0);
    let rod = shapes::capsule(2.0, 30.0, 16).translated(DVec3::new(12.0, 3.0, 8.0));
    vec![
        ("three balls, 1,280 faces each", three_of(3).0),
        ("three balls, 20,480 faces each", three_of(5).0),
        ("spike in an ellipsoid", pair_of(&spike, &muscle)),
        ("rod in a box", pair_of(&rod, &plate)),
    ]
}

/// Makes a plan in which a method is forced on all pairs that it suits.
fn forced(scene: &mut Scene, pairs: &[PairId], method: DetectionMethod, tolerance: f64) -> Plan {
    let mut forced = Vec::new();
    for &pair in pairs {
        let has_bone = pair.bodies().iter().any(|&id| scene.body(id).is_rigid());
        if method != DetectionMethod::Field || has_bone {
            forced.push(ForcedMethod { pair, method });
        }
    }
    let params = PlanParams::with_tolerance(tolerance);
    Plan::with_forced(scene, &params, &forced, Progress::none()).expect("a plan")
}

#[test]
#[expect(clippy::print_stdout, reason = "the table of docs/choosing.md")]
fn the_chosen_plan_is_no_more_than_a_quarter_dearer_than_the_best() {
    println!("| scene | tolerance | frames | chosen [s] | over best | over exact |");
    for (name, mut scene) in scenes() {
        for tolerance in [2.0, 0.5, 0.1] {
            let (mut chosen, mut pairs) = (Vec::new(), Vec::new());
            for frames in FRAMES {
                let params = PlanParams { frames, ..PlanParams::with_tolerance(tolerance) };
                let mut plan = Plan::new(&mut scene, &params, Progress::none()).expect("a plan");
                pairs = plan.pairs().iter().map(|planned| planned.pair).collect();
                let seconds = PlanSeconds::of(&mut plan, &mut scene).over(frames);
                chosen.push((frames, seconds, plan.to_string()));
            }

            let [exact, coarse, field] =
                [DetectionMethod::Exact, DetectionMethod::Coarse, DetectionMethod::Field].map(
                    |method| {
                        PlanSeconds::of(
                            &mut forced(&mut scene, &pairs, method, tolerance),
                            &mut scene,
                        )
                    },
                );
            for (frames, chosen, plan) in chosen {
                let exact = exact.over(frames);
                let best = exact.min(coarse.over(frames)).min(field.over(frames));
                let (of_best, of_exact) = (chosen / best, chosen / exact);
                println!(
                    "| {name} | {tolerance} | {frames} | {chosen:.4} | {of_best:.2} | {of_exact:.2} |"
                );
                assert!(of_exact <= 1.1, "{name}, {tolerance}, {frames}: {plan}");
                assert!(of_best <= 1.25, "{name}, {tolerance}, {frames}: {plan}");
            }
        }
    }
}
