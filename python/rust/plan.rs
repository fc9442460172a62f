//! Plans of detection over many frames.

use std::time::Instant;

use musculo_collide::{Detection, DetectionMethod, PairState, PlanParams, machine_factor};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pyo3::{PyTraverseError, PyVisit};

use crate::arrays::{array, point_array};
use crate::call::{Call, count, short};
use crate::exclusive::Exclusive;
use crate::record::dict;
use crate::scene::Scene;

/// Name of a plan in exceptions.
const PLAN: &str = "the plan";

/// Native plan, with the scene that it was made for.
#[pyclass(frozen, module = "musculo_collide._native")]
#[derive(Debug)]
pub(crate) struct Plan {
    scene: Py<Scene>,
    state: Exclusive<State>,
}

/// Library's plan, and what it has detected last.
#[derive(Debug)]
struct State {
    plan: musculo_collide::Plan,
    detection: Detection,
}

#[pymethods]
impl Plan {
    #[new]
    #[expect(clippy::too_many_arguments, reason = "named arguments in Python")]
    fn new(
        py: Python<'_>,
        scene: Py<Scene>,
        tolerance: f64,
        margin: f64,
        max_displacement: f64,
        frames: i64,
        threads: Option<i64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let default = PlanParams::with_tolerance(tolerance);
        let frames = count(frames, "frames")?;
        let call = Call::new(threads, progress)?;
        let threads = call.thread_count();
        let params = PlanParams { margin, max_displacement, frames, threads, ..default };
        let plan = {
            let mut held = scene.get().hold()?;
            let scene = &mut held.scene;
            call.run(py, |progress| {
                // Predicted times are those of this machine, as in the program.
                let start = Instant::now();
                let machine_factor = machine_factor(|| start.elapsed());
                let params = PlanParams { machine_factor, ..params };
                musculo_collide::Plan::new(scene, &params, progress)
            })?
        };
        let state = Exclusive::new(State { plan, detection: Detection::default() });
        Ok(Self { scene, state })
    }

    /// Returns the method of each planned pair, with the bound on its error.
    fn pairs<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let (state, held) = (self.state.hold(PLAN)?, self.scene.get().hold()?);
        let mut pairs = Vec::new();
        for planned in state.plan.pairs() {
            let [a, b] = held.scene.names(planned.pair);
            pairs.push(dict!(py, {
                a: a,
                b: b,
                method: method_name(planned.method),
                bound: planned.accuracy.bound,
                measured_error: planned.accuracy.measured_error,
                predicted_seconds: planned.cost,
            }));
        }
        Ok(pairs)
    }

    /// Describes structures, methods and reasons.
    fn text(&self) -> PyResult<String> {
        Ok(self.state.hold(PLAN)?.plan.to_string())
    }

    /// Detects all pairs in the scene's present state.
    fn detect<'py>(
        &self,
        py: Python<'py>,
        threads: Option<i64>,
    ) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let (mut state, mut held) = (self.state.hold(PLAN)?, self.scene.get().hold()?);
        let State { plan, detection } = &mut *state;
        let library = &mut held.scene;
        Call::new(threads, None)?.run_short(py, || plan.detect(library, detection))?;

        let mut pairs = Vec::new();
        for found in detection.pairs() {
            let [a, b] = library.names(found.pair);
            let contacts = &detection.contacts()[found.contacts.clone()];
            let normals: Vec<_> = contacts.iter().map(|contact| contact.normal).collect();
            let state = match found.state {
                PairState::Apart => "apart",
                PairState::Overlapping => "overlapping",
                PairState::Undecided { .. } => "undecided",
            };
            pairs.push(dict!(py, {
                a: a,
                b: b,
                method: method_name(found.method),
                state: state,
                depth: (found.depth.lower, found.depth.upper),
                min_gap: found.min_gap,
                gaps: array(py, contacts.iter().map(|contact| contact.gap).collect()),
                normals: point_array(py, &normals),
            }));
        }
        Ok(pairs)
    }

    /// Moves soft bodies out of the contacts that were detected last.
    fn respond(&self, py: Python<'_>, clearance: f64) -> PyResult<()> {
        let (mut state, mut held) = (self.state.hold(PLAN)?, self.scene.get().hold()?);
        let State { plan, detection } = &mut *state;
        let library = &mut held.scene;
        let params = musculo_collide::RespondParams { clearance, ..Default::default() };
        short(py, || plan.respond(library, detection, &params).map(|_| ()))
    }

    /// Shows the scene to the collector of cycles: a scene may have an attribute that holds it.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.scene)
    }
}

/// Returns the name that the program's reports have.
fn method_name(method: DetectionMethod) -> &'static str {
    match method {
        DetectionMethod::Exact => "exact",
        DetectionMethod::Coarse => "coarse",
        DetectionMethod::Field => "field",
        DetectionMethod::Balls => "balls",
        _ => "other",
    }
}
