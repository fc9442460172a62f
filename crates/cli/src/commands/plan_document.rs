//! Result of a plan as JSON.

use musculo_collide::{
    Detection, DetectionMethod, PairState, Plan, PlanParams, Scene, StructureKind,
};
use serde::Serialize;

use super::plan_comparison::Comparison;
use super::plan_frames::FrameTimes;

/// Result of a plan, after its last frame.
#[derive(Debug, Serialize)]
pub(super) struct PlanDocument<'a> {
    #[serde(flatten)]
    params: &'a PlanParams,
    /// Predicted and median measured time of a frame.
    predicted_ms: f64,
    frame_ms: Option<f64>,
    /// Median time of exact detection, with a comparison.
    exact_ms: Option<f64>,
    structures: Vec<StructureRecord<'a>>,
    pairs: Vec<PairRecord<'a>>,
    left_out: Vec<LeftOutRecord<'a>>,
}

/// Structure that was built for a body.
#[derive(Debug, Serialize)]
struct StructureRecord<'a> {
    body: &'a str,
    kind: StructureKind,
    size: usize,
    spacing: Option<f64>,
    bound: f64,
    proved: bool,
    measured_error: Option<f64>,
    bytes: usize,
    predicted_ms: f64,
}

/// Planned pair.
#[derive(Debug, Serialize)]
struct PairRecord<'a> {
    a: &'a str,
    b: &'a str,
    method: DetectionMethod,
    bound: f64,
    proved: bool,
    measured_error: Option<f64>,
    state: PairState,
    depth: f64,
    depth_lower: f64,
    depth_upper: f64,
    /// Depth by exact detection, with a comparison.
    exact_depth: Option<f64>,
    frame_ms: Option<f64>,
    predicted_ms: f64,
}

/// Pair that a budget has left out.
#[derive(Debug, Serialize)]
struct LeftOutRecord<'a> {
    a: &'a str,
    b: &'a str,
    depth_upper: f64,
}

impl<'a> PlanDocument<'a> {
    pub(super) fn new(
        scene: &'a Scene,
        plan: &'a Plan,
        detection: &Detection,
        times: &FrameTimes,
        comparison: Option<&Comparison>,
    ) -> Self {
        let params = plan.params();
        let name = |id| scene.body(id).name();
        let mut structures = Vec::new();
        for built in plan.structures() {
            let accuracy = built.accuracy;
            structures.push(StructureRecord {
                body: name(built.body),
                kind: built.kind,
                size: built.size,
                spacing: built.spacing,
                bound: accuracy.bound,
                proved: accuracy.is_proved,
                measured_error: accuracy.measured_error,
                bytes: built.bytes,
                predicted_ms: 1e3 * params.machine_factor * built.operations.seconds(),
            });
        }

        // All planned pairs, those without contact as well.
        let mut pairs = Vec::new();
        for planned in plan.pairs() {
            let (found, accuracy) = (detection.pair(planned.pair), planned.accuracy);
            let depth = found.map(|found| found.depth).unwrap_or_default();
            let exact = comparison.and_then(|comparison| comparison.depths.get(&planned.pair));
            let [a, b] = planned.pair.bodies().map(name);
            pairs.push(PairRecord {
                a,
                b,
                method: found.map_or(planned.method, |found| found.method),
                bound: accuracy.bound,
                proved: accuracy.is_proved,
                measured_error: accuracy.measured_error,
                state: found.map_or(PairState::Apart, |found| found.state),
                depth: found.map_or(0.0, |found| found.max_depth),
                depth_lower: depth.lower,
                depth_upper: depth.upper,
                exact_depth: exact.map(|exact| exact.lower),
                frame_ms: planned.measured_seconds.map(|seconds| 1e3 * seconds),
                predicted_ms: 1e3 * planned.cost,
            });
        }
        let mut left_out = Vec::new();
        for pair in detection.left_out() {
            let [a, b] = pair.pair.bodies().map(name);
            left_out.push(LeftOutRecord { a, b, depth_upper: pair.upper });
        }
        Self {
            params,
            predicted_ms: 1e3 * plan.predicted_time().as_secs_f64(),
            frame_ms: times.milliseconds().map(|[_, median, _]| median),
            exact_ms: comparison.and_then(Comparison::exact_milliseconds),
            structures,
            pairs,
            left_out,
        }
    }
}
