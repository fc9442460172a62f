//! Planned detection over frames, and its times.

use std::time::{Duration, Instant};

use glam::DVec3;
use musculo_collide::distance_field::Pose;
use musculo_collide::{BodyId, BodyPlace, Detection, FrameBudget, Plan, Scene, SceneError};

use super::plan_comparison::Comparison;
use super::plan_times::FrameTimes;
use crate::failure::Failure;
use crate::motion::Replay;
use crate::phase::Phase;

/// Largest number of times that a state without a motion is detected, to measure times.
const MAX_REPETITIONS: usize = 6;

/// State of a body in a frame.
enum BodyState {
    Pose(Pose),
    Positions(Vec<DVec3>),
}

/// Frames of a motion, or the present state several times.
pub(super) struct FrameSource<'a> {
    replay: Option<&'a Replay>,
    repetitions: usize,
    /// Largest time of a frame.
    budget: Option<Duration>,
}

impl<'a> FrameSource<'a> {
    pub(super) fn new(replay: Option<&'a Replay>, frames: u32, budget: Option<Duration>) -> Self {
        let frames = usize::try_from(frames).unwrap_or(MAX_REPETITIONS);
        Self { replay, repetitions: frames.clamp(1, MAX_REPETITIONS), budget }
    }

    /// Runs planned detection on every frame, with its comparison if there is one, and
    /// returns the times.
    pub(super) fn detect(
        &self,
        plan: &mut Plan,
        scene: &mut Scene,
        detection: &mut Detection,
        mut comparison: Option<&mut Comparison>,
    ) -> Result<FrameTimes, Failure> {
        let count = self.replay.map_or(self.repetitions, Replay::frame_count);
        let phase = Phase::with_steps("detecting", count);
        let mut times = FrameTimes::default();
        for frame in 0..count {
            // The states are computed before the clock starts: a simulator has them.
            let states = self.states(scene, frame);
            let start = Instant::now();
            place(scene, &states)?;
            match self.budget {
                None => plan.detect(scene, detection)?,
                Some(limit) => {
                    let mut now = || start.elapsed();
                    let mut budget = FrameBudget::Clock { limit, now: &mut now };
                    plan.detect_within(scene, &mut budget, detection)?;
                }
            }
            times.add(start.elapsed());

            // Each state counts once.
            let is_new = self.replay.is_some() || frame + 1 == count;
            if let Some(comparison) = comparison.as_deref_mut().filter(|_| is_new) {
                comparison.add(frame, plan, scene, detection)?;
            }
            phase.step();
        }
        Ok(times)
    }

    fn states(&self, scene: &Scene, frame: usize) -> Vec<(BodyId, BodyState)> {
        // Rigid bodies move by their pose, for which their trees and fields need no refit.
        let positions = self.replay.map(|replay| replay.positions(frame));
        let mut states = Vec::new();
        for (number, id) in scene.ids().enumerate() {
            let body = scene.body(id);
            let pose = self.replay.and_then(|replay| replay.pose(number, frame));
            let state = match (pose.or_else(|| body.pose()), &positions) {
                (Some(pose), _) => BodyState::Pose(pose),
                (None, Some(positions)) => BodyState::Positions(positions[number].clone()),
                (None, None) => BodyState::Positions(body.positions().to_vec()),
            };
            states.push((id, state));
        }
        states
    }
}

fn place(scene: &mut Scene, states: &[(BodyId, BodyState)]) -> Result<(), SceneError> {
    let mut places = Vec::new();
    for &(body, ref state) in states {
        places.push(match state {
            BodyState::Pose(pose) => (body, BodyPlace::Pose(*pose)),
            BodyState::Positions(positions) => (body, BodyPlace::Positions(positions)),
        });
    }
    scene.place_bodies(&places)
}

/// Detects the present state once more, with the time of each pair.
pub(super) fn time_pairs(plan: &mut Plan, scene: &mut Scene) -> Result<(), Failure> {
    let start = Instant::now();
    let mut now = || start.elapsed();
    let mut budget = FrameBudget::Clock { limit: Duration::MAX, now: &mut now };
    Ok(plan.detect_within(scene, &mut budget, &mut Detection::default())?)
}
