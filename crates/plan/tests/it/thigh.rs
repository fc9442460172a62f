//! Plans of real anatomy against exact depths, where `MUSCULO_DATA` names a folder of it.

use fixtures::data;
use plan::{Plan, PlanParams};
use scene::{BodyKind, CheckParams, Scene};
use surface::progress::Progress;

use crate::detect;

#[test]
fn all_depths_of_the_thigh_are_within_their_bounds() {
    let Some(folder) = data::anatomy("all_depths_of_the_thigh_are_within_their_bounds") else {
        return;
    };
    let mut scene = Scene::new();
    for path in data::bodies(&folder.join("vhf_left_thigh_lo")) {
        let mesh = data::mesh(&path);
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let is_bone = name.starts_with("bone");
        let kind = if is_bone { BodyKind::Rigid } else { BodyKind::Deformable };
        scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body");
    }
    let check = CheckParams { depth_tolerance: Some(1e-3), ..CheckParams::new(0.0) };
    let exact = scene.check(&check, Progress::none()).expect("a check");

    for (tolerance, frames) in [(2.0, 1), (2.0, 1_000_000), (0.5, 1), (0.5, 1_000_000), (0.1, 1)] {
        let params = PlanParams { frames, ..PlanParams::with_tolerance(tolerance) };
        let mut plan = Plan::new(&mut scene, &params, Progress::none()).expect("a plan");
        let detection = detect(&mut plan, &mut scene);
        let mut compared = 0;
        for report in &exact {
            let planned = plan.pairs().iter().find(|planned| planned.pair == report.pair);
            let (Some(planned), Some(depth)) = (planned, report.max_depth()) else { continue };
            let found = detection.pair(report.pair).map_or(0.0, |found| found.max_depth);
            let error = (depth.lower - found).max(found - depth.upper);
            assert!(planned.accuracy.is_proved && planned.accuracy.bound <= tolerance);
            assert!(
                error <= planned.accuracy.bound,
                "{tolerance}: {found}, {depth:?}, {planned:?}"
            );
            compared += 1;
        }
        assert!(compared > 30, "{compared} overlapping pairs");
    }
}
