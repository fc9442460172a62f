//! Structures that cannot pay, or are not exact enough.

use fixtures::shapes;
use glam::DVec3;
use scene::BodyKind;

use super::*;

#[test]
fn fields_coarser_than_the_tolerance_are_left_out() {
    // With bounded memory, a field of a body so large has nodes about 1 apart.
    let bone = shapes::icosphere(100.0, 2);
    let mut scene = Scene::new();
    scene.add("bone", BodyKind::Rigid, bone.surface(), bone.positions).expect("a body");
    for (tolerance, is_left_out) in [(0.6, true), (0.9, true), (1.5, false)] {
        let params = PlanParams::with_tolerance(tolerance);
        let planner = Planner::new(&scene, &params, Vec::new(), vec![FIELD]);
        let is_useless = planner.useless[0].has(StructureKind::Field);
        assert_eq!(is_useless, is_left_out, "{tolerance}");
    }
}

#[test]
fn coarse_surfaces_are_left_out_where_all_counted_work_is_less_than_their_construction() {
    // Two balls of 20,480 faces that are 0.2 deep in each other: little work for so many faces.
    let mut scene = Scene::new();
    for x in [0.0, 59.8] {
        let ball = shapes::icosphere(30.0, 5).translated(DVec3::X * x);
        let name = format!("at {x}");
        scene.add(name, BodyKind::Deformable, ball.surface(), ball.positions).expect("a body");
    }
    for (frames, is_left_out) in [(100, true), (100_000, false)] {
        let params = PlanParams { frames, ..PlanParams::with_tolerance(2.0) };
        let near = NearPairs::find(&mut scene, &params, &[]).expect("pairs");
        let mut planner =
            Planner::new(&scene, &params, near.planned, vec![StructureSet::default(); 2]);
        assert!(!planner.useless[0].has(StructureKind::Coarse), "by faces alone, they may pay");
        planner.count_work(&mut scene, Progress::none()).expect("work");
        let is_useless = planner.useless[0].has(StructureKind::Coarse);
        assert_eq!(is_useless, is_left_out, "{frames} frames");
        assert_eq!(planner.kept[0] >= 1.0, is_left_out, "sizes are predicted where they matter");
    }
}
