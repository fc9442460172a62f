//! Frames looked at as planned: how long they take, and how far from exact
//! detection they are.

use std::time::{Duration, Instant};

use glam::DVec3;
use musculo_collide::distance_field::Pose;
use musculo_collide::{
    BodyId, CheckParams, Detection, PairPlan, PairReport, Plan, PlanError, SceneError,
};

use super::Failure;
use crate::motion::Replay;
use crate::progress::Progress;

type Scene = musculo_collide::Scene;

/// Frames without a motion, the first of which takes memory.
const FRAMES: usize = 6;

/// Where a body is.
enum State {
    Pose(Pose),
    Positions(Vec<DVec3>),
}

/// Frames of a motion, or the present state again and again.
pub(super) struct Frames<'a> {
    replay: Option<&'a Replay<'a>>,
}

/// What some frames took, and how wrong they were.
pub(super) struct Measured {
    /// Of each frame, ascending; the first, which takes memory, is left out.
    planned: Vec<Duration>,
    compared: Option<Compared>,
}

/// Planned detection beside exact detection.
#[derive(Default)]
struct Compared {
    /// Of each frame, ascending.
    exact: Vec<Duration>,
    /// The largest difference of two depths, and where.
    worst: f64,
    place: String,
    /// Overlaps that were not seen, and the deepest of them.
    unseen: usize,
    deepest_unseen: f64,
}

impl<'a> Frames<'a> {
    pub(super) const fn new(replay: Option<&'a Replay<'a>>) -> Self {
        Self { replay }
    }

    fn count(&self) -> usize {
        self.replay.map_or(FRAMES, Replay::frame_count)
    }

    fn states(&self, scene: &Scene, frame: usize) -> Vec<(BodyId, State)> {
        let positions = self.replay.map(|replay| replay.positions(frame));
        let of_body = |(number, id): (usize, BodyId)| {
            let body = scene.body(id);
            let pose = self.replay.and_then(|replay| replay.pose(number, frame));
            let pose = pose.or_else(|| body.pose());
            let at = || positions.as_ref().map_or(body.positions(), |all| &all[number]).to_vec();
            (id, pose.map_or_else(|| State::Positions(at()), State::Pose))
        };
        scene.ids().enumerate().map(of_body).collect()
    }

    /// Looks at every frame; what `detection` holds at the end is of the last.
    pub(super) fn measure(
        &self,
        plan: &mut Plan,
        scene: &mut Scene,
        detection: &mut Detection,
        compare: bool,
    ) -> Result<Measured, Failure> {
        let what = if compare { "comparing with exact detection" } else { "detecting" };
        let progress = Progress::start(what, self.count());
        let mut measured = Measured { planned: Vec::new(), compared: None };
        for frame in 0..self.count() {
            let states = self.states(scene, frame);
            let start = Instant::now();
            go(scene, &states)?;
            plan.detect(scene, detection)?;
            if frame > 0 {
                measured.planned.push(start.elapsed());
            }
            if compare {
                let compared = measured.compared.get_or_insert_default();
                compared.add(plan, scene, detection)?;
            }
            progress.step();
        }
        measured.planned.sort_unstable();
        if let Some(compared) = &mut measured.compared {
            compared.exact.sort_unstable();
        }
        Ok(measured)
    }
}

fn go(scene: &mut Scene, states: &[(BodyId, State)]) -> Result<(), SceneError> {
    for (id, state) in states {
        match state {
            State::Pose(pose) => scene.pose_body(*id, pose)?,
            State::Positions(positions) => scene.move_body(*id, positions)?,
        }
    }
    Ok(())
}

impl Measured {
    pub(super) fn to_text(&self) -> String {
        let planned = format!("a frame takes {}", spread(&self.planned));
        let Some(compared) = &self.compared else {
            return format!("{planned}\n");
        };
        let Compared { exact, worst, place, unseen, deepest_unseen } = compared;
        format!(
            "{planned}; exact detection takes {}\n\
             depths differ by {worst:.4} at most ({place}); \
             {unseen} overlaps are not seen, {deepest_unseen:.4} deep at most\n",
            spread(exact)
        )
    }
}

/// Median and extremes of ascending times.
fn spread(times: &[Duration]) -> String {
    let at = |k: usize| 1e3 * times[k].as_secs_f64();
    let last = times.len() - 1;
    format!("{:.1} ms ({:.1} to {:.1})", at(last / 2), at(0), at(last))
}

impl Compared {
    fn add(
        &mut self,
        plan: &Plan,
        scene: &mut Scene,
        detection: &Detection,
    ) -> Result<(), PlanError> {
        let start = Instant::now();
        let exact = scene.check(&CheckParams { margin: 0.0 }, musculo_collide::Progress::none())?;
        self.exact.push(start.elapsed());
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
        let exact = exact.iter().find(|exact| exact.pair == pair.pair);
        let found = detection.pairs().iter().find(|found| found.pair == pair.pair);
        let right = exact.map_or(0.0, |exact| depth(exact, pair.bone()));
        let seen = found.map_or(0.0, |found| found.max_depth);
        let names = || pair.pair.bodies().map(|id| scene.body(id).name()).join(" and ");
        if (right - seen).abs() >= self.worst {
            self.worst = (right - seen).abs();
            self.place = format!("{}, {seen:.4} for {right:.4}", names());
        }
        if exact.is_some_and(|exact| exact.overlaps) && !found.is_some_and(|found| found.overlaps) {
            self.unseen += 1;
            self.deepest_unseen = self.deepest_unseen.max(right);
        }
    }
}

/// Depth of the deepest vertex that a plan looks at: of both bodies, or of the one
/// that is not the bone whose field is asked.
fn depth(exact: &PairReport, bone: Option<BodyId>) -> f64 {
    let sides = [(exact.pair.a, &exact.a_against_b), (exact.pair.b, &exact.b_against_a)];
    let looked_at = sides.into_iter().filter(|&(id, _)| Some(id) != bone);
    let gaps = looked_at.flat_map(|(_, side)| &side.near).map(|near| near.gap);
    -gaps.fold(0.0, f64::min)
}
