//! Pairs, structures and memory of plans over many bodies.

use fixtures::shapes::cube;
use glam::DVec3;
use plan::PlanParams;
use scene::{BodyKind, Scene};

use crate::{detect, plan};

/// Builds a grid of cubes 10 wide, 10 apart, rigid and soft in turn, of which every tenth is
/// shifted so that it enters the next one along x by 1, beside its edges.
fn grid(side: u32, layers: u32) -> Scene {
    let cube = cube(10.0);
    let mut scene = Scene::new();
    for number in 0..side * side * layers {
        let cell = [number % side, number / side % side, number / (side * side)];
        let mut place = 20.0 * DVec3::from_array(cell.map(f64::from));
        if number % 10 == 0 {
            place += DVec3::new(11.0, 0.5, 0.25);
        }
        let kind = if number % 2 == 0 { BodyKind::Rigid } else { BodyKind::Deformable };
        let positions = cube.clone().translated(place).positions;
        scene.add(number.to_string(), kind, cube.surface(), positions).expect("a cube");
    }
    scene
}

#[test]
fn two_thousand_bodies_take_pairs_and_structures_for_those_near_each_other_alone() {
    let mut scene = grid(20, 5);
    let params = PlanParams { max_displacement: 1.0, ..PlanParams::with_tolerance(0.5) };
    let mut made = None;
    let taken = allocation_counter::measure(|| made = Some(plan(&mut scene, &params)));
    let mut plan = made.expect("a plan");

    // Of two million pairs, one per shifted cube, of which each needs two trees.
    assert_eq!(plan.pairs().len(), 200);
    assert_eq!(plan.excluded_pairs(), []);
    assert_eq!(plan.far_pair_count(), 1_999_000 - 200);
    assert!(plan.structures().iter().all(|built| built.body.index() % 10 < 2));
    let detection = detect(&mut plan, &mut scene);
    assert_eq!(detection.pairs().len(), 200);
    assert!(detection.pairs().iter().all(|pair| pair.is_overlapping()), "{detection:?}");

    let per_body = taken.bytes_max / 2000;
    assert!(taken.bytes_max < 2000 * 4096, "{per_body} bytes per body");
}

#[test]
fn bytes_per_body_do_not_grow_with_the_bodies() {
    let bytes = |layers: u32| {
        let mut scene = grid(10, layers);
        let params = PlanParams::with_tolerance(0.5);
        let taken = allocation_counter::measure(|| drop(plan(&mut scene, &params)));
        taken.bytes_max
    };
    let (few, many) = (bytes(2), bytes(20));
    assert!(many < 11 * few, "{few} for 200 bodies, {many} for 2,000");
}
