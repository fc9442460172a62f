//! Planned detection over frames: its times, and its differences from exact detection.

use std::fmt;
use std::time::{Duration, Instant};

use glam::DVec3;
use musculo_collide::distance_field::Pose;
use musculo_collide::{
    BodyId, CheckParams, Detection, PairPlan, PairReport, Plan, Progress, Scene, SceneError,
};

use crate::failure::Failure;
use crate::motion::Replay;
use crate::phase::Phase;
use crate::report::fixed;

/// Number of frames without a motion.
const FRAMES: usize = 6;

/// State of a body in a frame.
enum BodyState {
    Pose(Pose),
    Positions(Vec<DVec3>),
}

/// Frames of a motion, or the present state several times.
pub(super) struct FrameSource<'a> {
    replay: Option<&'a Replay>,
}

impl<'a> FrameSource<'a> {
    pub(super) const fn new(replay: Option<&'a Replay>) -> Self {
        Self { replay }
    }

    /// Runs planned detection on every frame, with its comparison if there is one, and
    /// returns the times. The first frame, which reserves memory, is left out.
    pub(super) fn detect(
        &self,
        plan: &mut Plan,
        scene: &mut Scene,
        detection: &mut Detection,
        mut comparison: Option<&mut Comparison>,
    ) -> Result<FrameTimes, Failure> {
        let count = self.replay.map_or(FRAMES, Replay::frame_count);
        let phase = Phase::with_steps("detecting", count);
        let mut times = FrameTimes::default();
        for frame in 0..count {
            // The states are computed before the clock starts: a simulator has them.
            let states = self.states(scene, frame);
            let start = Instant::now();
            place(scene, &states)?;
            plan.detect(scene, detection)?;
            if frame > 0 {
                times.0.push(start.elapsed());
            }

            if let Some(comparison) = &mut comparison {
                comparison.add(plan, scene, detection)?;
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
    for (id, state) in states {
        match state {
            BodyState::Pose(pose) => scene.pose_body(*id, pose)?,
            BodyState::Positions(positions) => scene.move_body(*id, positions)?,
        }
    }
    Ok(())
}

/// Times of frames.
#[derive(Debug, Default)]
pub(super) struct FrameTimes(Vec<Duration>);

impl fmt::Display for FrameTimes {
    /// Writes median, minimum and maximum.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The median is not moved by the few frames in which the system did something else.
        let mut times = Vec::new();
        for time in &self.0 {
            times.push(1e3 * time.as_secs_f64());
        }
        times.sort_by(f64::total_cmp);
        let (Some(min), Some(max)) = (times.first(), times.last()) else {
            return write!(f, "not measured");
        };
        write!(f, "{:.1} ms ({min:.1} to {max:.1})", times[(times.len() - 1) / 2])
    }
}

/// Differences between planned and exact detection.
#[derive(Debug, Default)]
pub(super) struct Comparison {
    exact: FrameTimes,
    /// Largest difference of two depths.
    max_difference: f64,
    /// Pair and depths of that difference.
    place: String,
    /// Number of overlaps that only exact detection has.
    missing: usize,
    /// Depth of the deepest of them.
    max_missing_depth: f64,
}

impl Comparison {
    /// Compares the results of the present frame.
    fn add(
        &mut self,
        plan: &Plan,
        scene: &mut Scene,
        detection: &Detection,
    ) -> Result<(), SceneError> {
        // The time of exact detection is what the plan saves.
        let start = Instant::now();
        let exact = scene.check(&CheckParams::without_measures(0.0), Progress::none())?;
        self.exact.0.push(start.elapsed());

        for pair in plan.pairs() {
            self.add_pair(scene, pair, &exact, detection);
        }
        Ok(())
    }

    fn add_pair(
        &mut self,
        scene: &Scene,
        pair: &PairPlan,
        exact: &[PairReport],
        detection: &Detection,
    ) {
        // Depths by both methods; pairs that are not reported have none.
        let (mut exact_depth, mut overlaps) = (0.0, false);
        for exact in exact {
            if exact.pair == pair.pair {
                (exact_depth, overlaps) = (exact.max_vertex_depth, exact.overlaps);
            }
        }
        let (mut depth, mut is_found) = (0.0, false);
        for planned in detection.pairs() {
            if planned.pair == pair.pair {
                (depth, is_found) = (planned.max_depth, planned.overlaps);
            }
        }

        let difference = (exact_depth - depth).abs();
        if difference >= self.max_difference {
            let [a, b] = pair.pair.bodies().map(|id| scene.body(id).name());
            self.max_difference = difference;
            let [depth, exact_depth] = [depth, exact_depth].map(|depth| fixed(depth, 4));
            self.place = format!("{a} × {b}, {depth} instead of {exact_depth}");
        }

        // An overlap that the plan does not report at all.
        if overlaps && !is_found {
            self.missing += 1;
            self.max_missing_depth = self.max_missing_depth.max(exact_depth);
        }
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { exact, max_difference, place, missing, max_missing_depth } = self;
        writeln!(f, "exact: {exact}")?;
        writeln!(f, "depths differ by at most {} ({place})", fixed(*max_difference, 4))?;
        writeln!(f, "{missing} overlaps are missing, at most {} deep", fixed(*max_missing_depth, 4))
    }
}
