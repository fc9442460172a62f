//! Tests of plans.

mod allocations;
mod budget;
mod complete;
mod growth;
mod interruption;
mod planned;
mod refused;
mod regret;
mod revised;
mod stale;
mod step;
mod thigh;

use fixtures::shapes::icosphere;
use glam::DVec3;
use plan::{Detection, Plan, PlanParams};
use scene::{BodyId, BodyKind, PairId, Scene};
use surface::progress::Progress;

/// Builds a bone and two soft balls of radius 30: the bone and the first overlap by 2, the balls
/// by 3, the bone and the second not.
fn three() -> (Scene, [BodyId; 3]) {
    three_of(4)
}

/// The same, each of so many halvings of an icosahedron's edges.
fn three_of(halvings: u32) -> (Scene, [BodyId; 3]) {
    let mut scene = Scene::new();
    let bodies = [
        ("bone", BodyKind::Rigid, DVec3::ZERO),
        ("first", BodyKind::Deformable, DVec3::X * 58.0),
        ("second", BodyKind::Deformable, DVec3::X * 115.0),
    ];
    let ids = bodies.map(|(name, kind, at)| {
        let mesh = icosphere(30.0, halvings).translated(at);
        scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body")
    });
    (scene, ids)
}

fn plan(scene: &mut Scene, params: &PlanParams) -> Plan {
    Plan::new(scene, params, Progress::none()).expect("a plan")
}

fn detect(plan: &mut Plan, scene: &mut Scene) -> Detection {
    let mut detection = Detection::default();
    plan.detect(scene, &mut detection).expect("a detection");
    detection
}

/// Returns the depth that was detected for a pair, 0 for one that was not.
fn depth(detection: &Detection, a: BodyId, b: BodyId) -> f64 {
    let pair = detection.pairs().iter().find(|found| found.pair == PairId::new(a, b));
    pair.map_or(0.0, |pair| pair.max_depth)
}
