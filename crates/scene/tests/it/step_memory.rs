//! Memory of contact steps: after a few, nothing is allocated by any detector.

use glam::{DQuat, DVec3};
use response::{Restraint, RigidMotion};
use scene::{PairId, PermanentParams, Renewal, StepMethod};
use surface::Pose;

use crate::step_detectors::{H, World};

/// Steps in one oscillation, and oscillations before memory is counted.
const PERIOD: u32 = 16;
const BEFORE: u32 = 3;

/// Presses a ball into a bone that oscillates across and along its surface, from the same state in each
/// period, and counts allocations in the last; returns the contacts of the last step.
fn assert_no_allocations(world: &mut World, name: &str) -> usize {
    let pressed: Vec<DVec3> = world.x.iter().map(|x| *x - DVec3::Z * 0.5).collect();
    let rate = std::f64::consts::TAU / f64::from(PERIOD);

    // Threads would allocate by themselves.
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    one.install(|| {
        for step in 0..(BEFORE + 1) * PERIOD {
            world.x.copy_from_slice(&pressed);
            world.v.fill(DVec3::ZERO);
            let (sin, cos) = (rate * f64::from(step % PERIOD)).sin_cos();
            let way = DVec3::new(3.0, 0.0, 0.05);
            let motion = RigidMotion { velocity: way * rate / H * cos, ..RigidMotion::default() };
            let pose = Pose::new(DQuat::IDENTITY, way * sin);

            let taken = allocation_counter::measure(|| {
                let moved = world.step.move_bone(&mut world.scene, world.bone, &pose, motion);
                moved.expect("a rigid body");
                world.advance();
            });
            let is_counted = step >= BEFORE * PERIOD;
            assert!(!is_counted || taken.count_total == 0, "{name}, step {step}: {taken:?}");
        }
    });
    world.step.contact_step().contacts().contacts().len()
}

#[test]
fn no_detector_allocates_after_a_few_steps() {
    for method in [StepMethod::Exact, StepMethod::Coarse, StepMethod::Field, StepMethod::Balls] {
        let mut world = World::new(method);
        let contacts = assert_no_allocations(&mut world, &format!("{method:?}"));
        assert!(contacts > 10, "{method:?}: {contacts}");
        assert!(world.detectors.fallbacks().is_empty(), "{method:?}");
    }
}

#[test]
fn lists_of_kept_contacts_are_renewed_in_place() {
    for restraint in [Restraint::Sticking, Restraint::Sliding] {
        let mut world = World::new(StepMethod::Exact);
        let pair = PairId::new(world.bone, world.ball);
        let params = PermanentParams { restraint, skin: 0.2, attach_within: 0.0 };
        world.detectors.set_permanent(pair, params).expect("in range");
        let contacts = assert_no_allocations(&mut world, &format!("{restraint:?}"));
        assert!(contacts > 10, "{restraint:?}: {contacts}");

        // In doubt again and again: the list is not that of the first steps.
        let list = world.detectors.kept().next().expect("a kept pair");
        let is_renewed = list.since > u64::from(BEFORE * PERIOD) && list.renewal != Renewal::First;
        assert!(is_renewed, "{restraint:?}: {list:?}");
    }
}
