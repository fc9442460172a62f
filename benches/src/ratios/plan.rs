//! Plans over a walk of 25 bodies, beside exact detection of the same frames by all threads.

use std::error::Error;

use musculo_collide::{
    BodyId, BodyPlace, CheckParams, Detection, Plan, PlanParams, Progress, Scene, SceneError,
    machine_factor,
};

use super::motion_scenes::{BodyState, Walk};
use crate::measure::{Report, as_f64, nanoseconds, wall_time};

/// Tolerances \[mm\], with the aimed and the allowed time of a frame over that of exact detection.
const TOLERANCES: [(f64, f64, f64); 3] = [(0.5, 0.5, 0.5), (1.0, 0.35, 0.37), (2.0, 0.2, 0.22)];

/// Every so many frames of the walk is detected.
const STRIDE: usize = 9;

/// Frames that plans are made for, so that coarse surfaces pay.
const FRAMES: u32 = 10_000;

/// Width of the brackets on exact depths \[tolerances\], as of `plan --compare`.
const EXACT_WIDTH: f64 = 0.01;

/// Rounds over all frames.
const ROUNDS: u32 = 3;

/// Compares the frames of plans; skips without data.
pub(super) fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    let Some(walk) = Walk::read("plans of a walk")? else { return Ok(()) };
    let frames = (0..walk.frame_count()).step_by(STRIDE).map(|frame| walk.states(frame)).collect();
    let mut timed = TimedWalk::new(walk.into_scene(), frames);
    for (tolerance, aim, allowed) in TOLERANCES {
        let times = timed.times(tolerance, report.rounds(ROUNDS))?;
        report.ratio(
            format!("walk within {tolerance} mm / exact depths (aim {aim})"),
            times.map(|time| time * 1e-6),
            "ms",
            allowed,
        );
    }
    Ok(())
}

/// Frames of a walk, with the scene that they are detected in.
struct TimedWalk {
    scene: Scene,
    frames: Vec<Vec<BodyState>>,
}

impl TimedWalk {
    /// Leaves pairs of bones out of both, since no plan detects them.
    fn new(mut scene: Scene, frames: Vec<Vec<BodyState>>) -> Self {
        let rigid: Vec<BodyId> = scene.ids().filter(|&id| scene.body(id).is_rigid()).collect();
        for (k, &a) in rigid.iter().enumerate() {
            for &b in &rigid[k + 1..] {
                scene.ignore(a, b);
            }
        }
        Self { scene, frames }
    }

    /// Returns the mean times of a frame by a plan and by exact detection \[ns\]: the minimum over
    /// the rounds of each.
    fn times(&mut self, tolerance: f64, rounds: u32) -> Result<[f64; 2], Box<dyn Error>> {
        // The plan is made where the walk begins, for all pairs that may ever come near.
        let Self { scene, frames } = self;
        place(scene, &frames[0])?;
        let params = PlanParams {
            frames: FRAMES,
            max_displacement: f64::INFINITY,
            machine_factor: machine_factor(wall_time),
            threads: rayon::current_num_threads(),
            ..PlanParams::with_tolerance(tolerance)
        };
        let mut plan = Plan::new(scene, &params, Progress::none())?;
        let depth_tolerance = Some(EXACT_WIDTH * tolerance);
        let check = CheckParams { depth_tolerance, ..CheckParams::new(0.0) };

        // Both in turns, each with the moves of all bodies.
        let mut least = vec![[f64::INFINITY; 2]; frames.len()];
        let mut detection = Detection::default();
        for _ in 0..rounds {
            for (states, least) in frames.iter().zip(&mut least) {
                let mut outcome: Result<(), Box<dyn Error>> = Ok(());
                let planned = nanoseconds(|| {
                    outcome = detect(&mut plan, scene, states, &mut detection);
                    detection.pairs().len()
                });
                outcome?;
                let mut reports = Ok(Vec::new());
                let exact = nanoseconds(|| {
                    reports =
                        place(scene, states).and_then(|()| scene.check(&check, Progress::none()));
                    states.len()
                });
                reports?;
                *least = [least[0].min(planned), least[1].min(exact)];
            }
        }

        let mut means = [0.0; 2];
        for least in &least {
            for (mean, least) in means.iter_mut().zip(least) {
                *mean += least / as_f64(frames.len());
            }
        }
        Ok(means)
    }
}

fn detect(
    plan: &mut Plan,
    scene: &mut Scene,
    states: &[BodyState],
    detection: &mut Detection,
) -> Result<(), Box<dyn Error>> {
    place(scene, states)?;
    Ok(plan.detect(scene, detection)?)
}

/// Moves all bodies: rigid ones by their poses.
fn place(scene: &mut Scene, states: &[BodyState]) -> Result<(), SceneError> {
    let mut places = Vec::new();
    for state in states {
        places.push(match state {
            BodyState::Pose(body, pose) => (*body, BodyPlace::Pose(*pose)),
            BodyState::Positions(body, positions) => (*body, BodyPlace::Positions(positions)),
        });
    }
    scene.place_bodies(&places)
}
