//! Endurance: many frames of a small moving scene, and the memory that they leave behind.
//!
//! Each frame is detection by a plan, and the response to its contacts; every tenth also sweeps
//! the way to the next frame.

use std::error::Error;
use std::f64::consts::TAU;

use ccd::CcdParams;
use fixtures::shapes::icosphere;
use glam::{DQuat, DVec3};
use musculo_collide::distance_field::Pose;
use musculo_collide::{
    BodyId, BodyKind, BodyMove, Detection, Plan, PlanParams, Progress, RespondParams, Scene,
};

use crate::measure::{Report, as_f64};

/// Frames until every state was taken, after which memory is watched: the bone's turn repeats after
/// 64 frames, the muscles' sway after 40.
pub const WARM_UP: u32 = 320;

/// Counts over the frames after [`WARM_UP`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Endurance {
    /// Frames.
    pub frames: u32,
    /// Contacts found in all of them.
    pub contacts: usize,
    /// Bytes held at the end beyond those at the start.
    pub grown_bytes: i64,
    /// Maximum of the bytes allocated at once within frames.
    pub peak_bytes: u64,
    /// Frames in which detection allocated.
    pub allocating_detections: u32,
}

/// Bytes that may stay: lists that happened to grow once more.
const MAX_GROWN_BYTES: f64 = 4096.0;

/// Runs a number of frames, and reports the memory that they left behind.
///
/// # Errors
///
/// When detection or response fails, which is a fault.
#[expect(clippy::cast_precision_loss, reason = "bytes far below 2^53")]
pub fn run(frames: u32, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let endurance = soak(frames)?;
    let any = f64::INFINITY;
    report.cost("frames", f64::from(frames), "", any);
    report.cost("contacts", as_f64(endurance.contacts), "", any);
    report.cost("memory grown", endurance.grown_bytes as f64, "B", MAX_GROWN_BYTES);
    report.cost("peak of memory within frames", endurance.peak_bytes as f64, "B", any);
    let detections = f64::from(endurance.allocating_detections);
    report.cost("frames in which detection allocated", detections, "", any);
    Ok(())
}

/// Runs a number of frames after the warm-up, on one thread.
///
/// # Errors
///
/// When detection or response fails, which is a fault.
pub fn soak(frames: u32) -> Result<Endurance, Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let endurance = pool.install(|| soak_on_this_thread(frames).map_err(|error| error.to_string()));
    Ok(endurance?)
}

fn soak_on_this_thread(frames: u32) -> Result<Endurance, Box<dyn Error>> {
    // Every path is taken once before memory is watched.
    let mut scene = SwayingScene::new()?;
    for frame in 0..WARM_UP {
        scene.frame(frame, &mut Endurance::default())?;
    }

    // An error cannot leave the measured call, so that the first one is kept aside.
    let mut endurance = Endurance { frames, ..Endurance::default() };
    let mut error = None;
    let allocated = allocation_counter::measure(|| {
        let mut all = WARM_UP..WARM_UP + frames;
        error = all.find_map(|frame| scene.frame(frame, &mut endurance).err());
    });
    endurance.grown_bytes = allocated.bytes_current;
    endurance.peak_bytes = allocated.bytes_max;
    error.map_or(Ok(endurance), Err)
}

/// A bone that turns, and two muscles that sway beside it, all of them balls.
struct SwayingScene {
    scene: Scene,
    bone: BodyId,
    muscles: [BodyId; 2],
    rest: [Vec<DVec3>; 2],
    plan: Plan,
    detection: Detection,
    next: Vec<DVec3>,
}

impl SwayingScene {
    fn new() -> Result<Self, Box<dyn Error>> {
        // Overlaps of one to two millimeters, which grow and shrink as the muscles sway.
        let ball = icosphere(30.0, 3);
        let rest = [58.0, 115.0].map(|x| ball.clone().translated(DVec3::X * x).positions);

        let mut scene = Scene::new();
        let bone = scene.add("bone", BodyKind::Rigid, ball.surface(), ball.positions.clone())?;
        let mut muscles = [bone; 2];
        for (number, name) in ["first", "second"].into_iter().enumerate() {
            let x = rest[number].clone();
            muscles[number] = scene.add(name, BodyKind::Deformable, ball.surface(), x)?;
        }

        // The muscles sway by 1, and responses push them by some more.
        let params = PlanParams { max_displacement: 10.0, ..PlanParams::with_tolerance(0.5) };
        let plan = Plan::new(&mut scene, &params, Progress::none())?;
        let (detection, next) = (Detection::default(), Vec::new());
        Ok(Self { scene, bone, muscles, rest, plan, detection, next })
    }

    fn frame(&mut self, frame: u32, endurance: &mut Endurance) -> Result<(), Box<dyn Error>> {
        // The bone turns, the muscles sway.
        let turn = DQuat::from_rotation_z(TAU * f64::from(frame % 64) / 64.0);
        self.scene.pose_body(self.bone, &Pose::new(turn, DVec3::ZERO))?;
        for muscle in 0..2 {
            self.sway(muscle, frame);
            self.scene.move_body(self.muscles[muscle], &self.next)?;
        }

        // Detection allocates nothing once every path was taken.
        let Self { scene, plan, detection, .. } = self;
        let mut detected = Ok(());
        let allocated = allocation_counter::measure(|| detected = plan.detect(scene, detection));
        detected?;
        endurance.allocating_detections += u32::from(allocated.count_total > 0);
        endurance.contacts += detection.contacts().len();

        // The response, and at times a sweep to the next frame.
        plan.respond(scene, detection, &RespondParams::default())?;
        if frame.is_multiple_of(10) {
            self.sway(0, frame + 1);
            let moved = [BodyMove { body: self.muscles[0], positions: &self.next }];
            self.plan.sweep(&mut self.scene, &moved, &CcdParams::DEFAULT, Progress::none())?;
        }
        Ok(())
    }

    /// Writes the undisturbed positions of a muscle in a frame to `next`.
    fn sway(&mut self, muscle: usize, frame: u32) {
        let swing = (TAU * f64::from(frame % 40) / 40.0).sin();
        let offset = DVec3::new(0.8, 0.5, 0.3) * swing;
        self.next.clone_from(&self.rest[muscle]);
        for p in &mut self.next {
            *p += offset;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::print_stdout, reason = "a figure for the table of measured values")]
    fn five_hundred_frames_leave_no_memory_behind() {
        let endurance = soak(500).unwrap();
        let grown = endurance.grown_bytes;
        println!("measured: memory grown in 500 frames [bytes] | {grown} | 4096");
        assert!(grown <= 4096, "{endurance:?}");
        assert!(endurance.contacts > 500, "{endurance:?}");
        assert_eq!(endurance.allocating_detections, 0, "{endurance:?}");
    }
}
