//! Detection by a plan allocates nothing after its first few frames, where no depth is searched for.

use fixtures::shapes::icosphere;
use glam::{DQuat, DVec3};
use plan::{Detection, PlanParams};
use scene::{BodyKind, Scene};
use surface::Pose;

use crate::plan;

/// Turns the bone and sways the muscles, with a period of four frames.
fn pose(scene: &mut Scene, frame: u32, x: &mut [Vec<DVec3>; 2]) {
    let phase = f64::from(frame % 4);
    let ids: Vec<_> = scene.ids().collect();
    let turned = Pose::new(DQuat::from_rotation_z(0.1 * phase), DVec3::Y * 0.2 * phase);
    scene.pose_body(ids[0], &turned).expect("a pose");
    for (&id, x) in ids[1..].iter().zip(x) {
        let sway = DVec3::new(0.1, 0.05, 0.0) * (phase - 1.5);
        x.iter_mut().for_each(|p| *p += sway);
        scene.move_body(id, x).expect("a move");
    }
}

#[test]
fn no_frame_after_the_first_few_allocates() {
    let mut scene = Scene::new();
    let ball = icosphere(30.0, 4);
    let mut x = [58.0, 115.0]
        .map(|along| ball.positions.iter().map(|p| *p + DVec3::X * along).collect::<Vec<_>>());
    scene.add("bone", BodyKind::Rigid, ball.surface(), ball.positions.clone()).expect("a bone");
    for (name, x) in ["first", "second"].into_iter().zip(&x) {
        scene.add(name, BodyKind::Deformable, ball.surface(), x.clone()).expect("a muscle");
    }
    let params = PlanParams { max_displacement: 10.0, ..PlanParams::with_tolerance(2.0) };
    let mut plan = plan(&mut scene, &params);
    let mut detection = Detection::default();

    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread");
    one.install(|| {
        let mut contacts = 0;
        for frame in 0..200 {
            pose(&mut scene, frame, &mut x);
            let taken = allocation_counter::measure(|| {
                plan.detect(&mut scene, &mut detection).expect("a detection");
            });
            contacts += detection.contacts().len();
            assert!(frame < 8 || taken.count_total == 0, "frame {frame} allocated {taken:?}");
        }
        assert!(contacts > 1000, "{contacts}");
    });
}
