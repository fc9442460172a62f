//! Result of a plan as JSON.

use musculo_collide::{
    Accuracy, DepthBracket, Detection, DetectionMethod, PairDetection, PairPlan, PairState, Plan,
    PlanParams, Scene, Structure, StructureKind,
};
use serde::Serialize;

use super::plan_comparison::Comparison;
use super::plan_times::FrameTimes;

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
        let mut structures = Vec::new();
        for built in plan.structures() {
            structures.push(StructureRecord::new(built, plan.params(), scene));
        }
        // All planned pairs, those without contact as well.
        let mut pairs = Vec::new();
        for planned in plan.pairs() {
            let exact = comparison.and_then(|comparison| comparison.depths.get(&planned.pair));
            pairs.push(PairRecord::new(planned, detection.pair(planned.pair), exact, scene));
        }
        let mut left_out = Vec::new();
        for pair in detection.left_out() {
            let [a, b] = scene.names(pair.pair);
            left_out.push(LeftOutRecord { a, b, depth_upper: pair.upper });
        }

        Self {
            params: plan.params(),
            predicted_ms: 1e3 * plan.predicted_time().as_secs_f64(),
            frame_ms: times.milliseconds().map(|[_, median, _]| median),
            exact_ms: comparison.and_then(Comparison::exact_milliseconds),
            structures,
            pairs,
            left_out,
        }
    }
}

impl<'a> StructureRecord<'a> {
    fn new(built: &Structure, params: &PlanParams, scene: &'a Scene) -> Self {
        let Accuracy { bound, is_proved, measured_error } = built.accuracy;
        Self {
            body: scene.body(built.body).name(),
            kind: built.kind,
            size: built.size,
            spacing: built.spacing,
            bound,
            proved: is_proved,
            measured_error,
            bytes: built.bytes,
            predicted_ms: 1e3 * params.machine_factor * built.operations.seconds(),
        }
    }
}

impl<'a> PairRecord<'a> {
    fn new(
        planned: &PairPlan,
        found: Option<&PairDetection>,
        exact: Option<&DepthBracket>,
        scene: &'a Scene,
    ) -> Self {
        let [a, b] = scene.names(planned.pair);
        let Accuracy { bound, is_proved, measured_error } = planned.accuracy;
        let mut record = Self {
            a,
            b,
            method: planned.method,
            bound,
            proved: is_proved,
            measured_error,
            state: PairState::Apart,
            depth: 0.0,
            depth_lower: 0.0,
            depth_upper: 0.0,
            exact_depth: exact.map(|exact| exact.lower),
            frame_ms: planned.measured_seconds.map(|seconds| 1e3 * seconds),
            predicted_ms: 1e3 * planned.cost,
        };

        // What the last frame has found, by the method that it took.
        if let Some(found) = found {
            (record.method, record.state, record.depth) =
                (found.method, found.state, found.max_depth);
            (record.depth_lower, record.depth_upper) = (found.depth.lower, found.depth.upper);
        }
        record
    }
}
