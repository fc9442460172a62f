//! Structures that cannot pay, or are not exact enough.

use fixtures::shapes;
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
