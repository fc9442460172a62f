//! Many frames of a small moving scene, and whether memory grows.
//!
//! Detection by a plan, the response to what it found, and every tenth frame the way to the next
//! frame: what a simulation does for hours.

use std::error::Error;

use ccd::CcdParams;
use fixtures::shapes::icosphere;
use glam::{DQuat, DVec3};
use musculo_collide::distance_field::Pose;
use musculo_collide::{BodyId, BodyKind, Detection, Plan, PlanParams, RespondParams, Scene};

/// Frames until every path was taken, after which memory is watched.
pub const WARM_UP: u32 = 100;

/// What happened in the frames after [`WARM_UP`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Soaked {
    /// Frames.
    pub frames: u32,
    /// Contacts found in all of them.
    pub contacts: usize,
    /// Bytes held at the end beyond those at the start.
    pub grown: i64,
    /// Bytes taken at once within frames, at most.
    pub peak: u64,
    /// Frames in which detection took any memory.
    pub detections_that_took: u32,
}

/// Runs so many frames after the warm-up, on one thread.
///
/// # Errors
///
/// When a frame cannot be looked at, which is a fault.
pub fn soak(frames: u32) -> Result<Soaked, Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let done = pool.install(|| on_this_thread(frames).map_err(|error| error.to_string()));
    Ok(done?)
}

fn on_this_thread(frames: u32) -> Result<Soaked, Box<dyn Error>> {
    let mut sway = Sway::new()?;
    let mut soaked = Soaked { frames, ..Soaked::default() };
    for frame in 0..WARM_UP {
        sway.frame(frame, &mut Soaked::default())?;
    }
    let mut failed = None;
    let taken = allocation_counter::measure(|| {
        let mut all = WARM_UP..WARM_UP + frames;
        failed = all.find_map(|frame| sway.frame(frame, &mut soaked).err());
    });
    (soaked.grown, soaked.peak) = (taken.bytes_current, taken.bytes_max);
    failed.map_or(Ok(soaked), Err)
}

/// A bone that turns, and two muscles that sway beside it, all of them balls.
struct Sway {
    scene: Scene,
    ids: Vec<BodyId>,
    rest: [Vec<DVec3>; 2],
    plan: Plan,
    detection: Detection,
    next: Vec<DVec3>,
}

impl Sway {
    fn new() -> Result<Self, Box<dyn Error>> {
        let ball = icosphere(30.0, 3);
        let mut scene = Scene::new();
        let at = |along: f64| ball.positions.iter().map(|p| *p + DVec3::X * along).collect();
        let rest: [Vec<DVec3>; 2] = [at(58.0), at(115.0)];
        let mut ids =
            vec![scene.add("bone", BodyKind::Rigid, ball.surface(), ball.positions.clone())?];
        for (name, x) in ["first", "second"].into_iter().zip(&rest) {
            ids.push(scene.add(name, BodyKind::Deformable, ball.surface(), x.clone())?);
        }
        let plan = Plan::new(&mut scene, &PlanParams::with_tolerance(0.5))?;
        Ok(Self { scene, ids, rest, plan, detection: Detection::default(), next: Vec::new() })
    }

    fn frame(&mut self, frame: u32, soaked: &mut Soaked) -> Result<(), Box<dyn Error>> {
        let turned = f64::from(frame % 64) / 64.0;
        let turn = DQuat::from_rotation_z(std::f64::consts::TAU * turned);
        self.scene.pose_body(self.ids[0], &Pose::new(turn, DVec3::ZERO))?;
        for muscle in 0..2 {
            self.place(muscle, frame);
            self.scene.move_body(self.ids[muscle + 1], &self.next)?;
        }
        let Self { scene, plan, detection, .. } = self;
        let mut found = Ok(());
        let taken = allocation_counter::measure(|| found = plan.detect(scene, detection));
        found?;
        soaked.detections_that_took += u32::from(taken.count_total > 0);
        soaked.contacts += detection.contacts().len();
        plan.respond(scene, detection, &RespondParams::default())?;
        if frame.is_multiple_of(10) {
            self.place(0, frame + 1);
            self.plan.sweep(&mut self.scene, &[(self.ids[1], &self.next)], &CcdParams::DEFAULT)?;
        }
        Ok(())
    }

    /// Where a muscle is in a frame, as far as nothing pushes it.
    fn place(&mut self, muscle: usize, frame: u32) {
        let swing = (std::f64::consts::TAU * f64::from(frame % 40) / 40.0).sin();
        let sway = DVec3::new(0.8, 0.5, 0.3) * swing;
        self.next.clear();
        self.next.extend(self.rest[muscle].iter().map(|p| *p + sway));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[expect(clippy::print_stdout, reason = "a figure for the table of all that is measured")]
    fn five_hundred_frames_take_no_memory_that_is_kept() {
        let soaked = soak(500).unwrap();
        println!("measured: memory grown in 500 frames [bytes] | {} | 4096", soaked.grown);
        assert!(soaked.grown <= 4096, "{soaked:?}");
        assert!(soaked.contacts > 500, "{soaked:?}");
        assert_eq!(soaked.detections_that_took, 0, "{soaked:?}");
    }
}
