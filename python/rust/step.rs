//! Contact step of a simulator, over arrays of numpy in place.

use glam::DVec3;
use musculo_collide::ccd::CcdParams;
use musculo_collide::decimate::{CoarseSurface, DecimateError, Decimation};
use musculo_collide::distance_field::FieldDetector;
use musculo_collide::medial::{MedialDetector, MedialParams};
use musculo_collide::proximity::SurfaceTree;
use musculo_collide::scene::{DetectorParams, PermanentParams};
use musculo_collide::{
    Body, BodyId, BodyKind, FallbackReason, Friction, Margins, Material, PairId, ParticleLoads,
    Progress, Restraint, RigidMotion, SceneStates, SceneStep, SpringDamper, StepDetectors,
    StepError, StepLength, StepMethod, StepParams, StepReport, SweptReport,
};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pyo3::{PyTraverseError, PyVisit};

use crate::arrays::{States, borrowed, numbers, vectors};
use crate::call::{Call, count, short};
use crate::error::refused;
use crate::exclusive::Exclusive;
use crate::field::Field;
use crate::motion::Placement;
use crate::record::{dict, vector};
use crate::scene::{Bodies, Scene};

/// Deviation of a coarse surface unless given, over the tolerance: the rest is left for how the body
/// deforms.
const COARSE_SHARE: f64 = 0.5;

/// Name of a step in exceptions.
const STEP: &str = "the contact step";

/// Native contact step, with the scene that it was made for.
#[pyclass(frozen, module = "musculo_collide._native")]
#[derive(Debug)]
pub(crate) struct Step {
    scene: Py<Scene>,
    params: DetectorParams,
    state: Exclusive<State>,
}

/// Library's step and detectors, with what they carry from step to step.
#[derive(Debug)]
struct State {
    step: SceneStep,
    detectors: StepDetectors,
}

/// Material of a pair, as Python has it.
#[derive(Debug, FromPyObject)]
pub(crate) struct PairMaterial {
    clearance: f64,
    friction: f64,
    dynamic_friction: Option<f64>,
    stiffness: Option<f64>,
    damping: f64,
    permanent: Option<String>,
    attach_within: f64,
}

/// Settings of one step, as Python has them.
#[derive(Debug, FromPyObject)]
pub(crate) struct StepSettings {
    h: f64,
    depth_tolerance: f64,
    max_rounds: i64,
    iterations: i64,
    swept: bool,
}

#[pymethods]
impl Step {
    #[new]
    fn new(
        scene: Py<Scene>,
        margin: f64,
        tolerance: f64,
        material: PairMaterial,
    ) -> PyResult<Self> {
        if material.permanent.is_some() {
            return Err(refused("permanent contacts are those of one pair: use set_material"));
        }
        let params = DetectorParams { margin, tolerance };
        let detectors = StepDetectors::new(params).map_err(refused)?;
        let step = SceneStep::new(material.with_margin(margin)?);
        Ok(Self { scene, params, state: Exclusive::new(State { step, detectors }) })
    }

    fn set_material(&self, a: &str, b: &str, material: PairMaterial) -> PyResult<()> {
        let (mut state, held) = (self.state.hold(STEP)?, self.scene.get().hold()?);
        let pair = held.pair(a, b)?;
        let in_library = material.with_margin(self.params.margin)?;
        match in_library.permanent {
            Some(restraint) => {
                let (skin, attach_within) = (self.params.margin, material.attach_within);
                let params = PermanentParams { restraint, skin, attach_within };
                state.detectors.set_permanent(pair, params).map_err(refused)?;
            }
            None => state.detectors.clear_permanent(pair),
        }
        state.step.set_material(pair, in_library);
        Ok(())
    }

    /// Detects all pairs of a bone by its field.
    fn set_field(&self, name: &str, field: &Field) -> PyResult<()> {
        let (mut state, held) = (self.state.hold(STEP)?, self.scene.get().hold()?);
        let bone = held.find(name)?;
        let detector = FieldDetector::new(field.shared(), self.params.margin).map_err(refused)?;
        state.detectors.set_field(bone, detector);
        set_method(&mut state.detectors, &held, bone, StepMethod::Field);
        Ok(())
    }

    /// Detects all pairs of a body by a coarse surface of it.
    fn set_coarse(
        &self,
        py: Python<'_>,
        name: &str,
        deviation: Option<f64>,
        threads: Option<i64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let deviation = deviation.unwrap_or(COARSE_SHARE * self.params.tolerance);
        if !deviation.is_finite() || deviation <= 0.0 {
            let origin = format!("; without one it is {COARSE_SHARE} of the step's tolerance");
            let problem = format!("deviation is {deviation}, but must be positive and finite");
            return Err(refused(format!("body {name:?}: {problem}{origin}")));
        }
        let (mut state, held) = (self.state.hold(STEP)?, self.scene.get().hold()?);
        let id = held.find(name)?;
        let body = held.scene.body(id);
        let coarse = Call::new(threads, progress)?.run(py, |progress| {
            coarse_surface(body, deviation, progress)
                .map_err(|error| format!("body {name:?}: {error}"))
        })?;
        state.detectors.set_coarse(id, coarse);
        set_method(&mut state.detectors, &held, id, StepMethod::Coarse);

        // Vertices that were left out follow those that were kept.
        let followers = state.detectors.followers(&held.scene).map_err(refused)?;
        state.step.set_followers(followers);
        Ok(())
    }

    /// Detects all pairs of a body by balls within a tolerance of its surface.
    fn set_balls(
        &self,
        py: Python<'_>,
        name: &str,
        tolerance: f64,
        threads: Option<i64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<()> {
        let (mut state, held) = (self.state.hold(STEP)?, self.scene.get().hold()?);
        let id = held.find(name)?;
        let body = held.scene.body(id);
        if !(tolerance.is_finite() && tolerance > 0.0) {
            let message = format!("tolerance is {tolerance}, but must be positive and finite");
            return Err(refused(format!("body {name:?}: {message}")));
        }

        // The surface is at most the tolerance outside of its balls.
        let margin = self.params.margin + tolerance;
        let params = MedialParams::tolerance(tolerance);
        let balls = Call::new(threads, progress)?.run(py, |progress| {
            let (surface, x) = (body.surface(), body.checked_positions());
            MedialDetector::new(surface, x, margin, &params, progress)
                .map_err(|error| format!("body {name:?}: {error}"))
        })?;
        state.detectors.set_balls(id, balls);
        set_method(&mut state.detectors, &held, id, StepMethod::Balls);
        Ok(())
    }

    /// Places a bone, and sets its velocities there.
    fn move_bone(
        &self,
        py: Python<'_>,
        name: &str,
        placement: Placement,
        velocity: [f64; 3],
        spin: [f64; 3],
        about: [f64; 3],
    ) -> PyResult<()> {
        let (mut state, mut held) = (self.state.hold(STEP)?, self.scene.get().hold()?);
        let bone = held.find(name)?;
        let [velocity, spin, about] = [velocity, spin, about].map(DVec3::from_array);
        let motion = RigidMotion { about, velocity, spin, ..RigidMotion::default() };
        let (step, scene) = (&mut state.step, &mut held.scene);
        short(py, || step.move_bone(scene, bone, &placement.pose(), motion))
    }

    /// Corrects the states of all particles where they are.
    #[expect(clippy::too_many_arguments, reason = "named arguments in Python")]
    fn correct<'py>(
        &self,
        py: Python<'py>,
        x: States<'py>,
        v: States<'py>,
        inverse_mass: PyReadonlyArray1<'py, f64>,
        accelerations: Option<States<'py>>,
        forces: Option<States<'py>>,
        settings: StepSettings,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyDict>> {
        // Arrays are borrowed exclusively: no two of them overlap, and no other call has one.
        let (mut x, mut v) = (borrowed(&x, "x")?, borrowed(&v, "v")?);
        let mut accelerations = match &accelerations {
            Some(array) => Some(borrowed(array, "accelerations")?),
            None => None,
        };
        let mut forces = match &forces {
            Some(array) => Some(borrowed(array, "forces")?),
            None => None,
        };
        let (x, v) = (vectors(&mut x, "x")?, vectors(&mut v, "v")?);
        let loads = match (&mut accelerations, &mut forces) {
            (None, None) => ParticleLoads::None,
            (Some(array), None) => ParticleLoads::Accelerations(vectors(array, "accelerations")?),
            (None, Some(array)) => ParticleLoads::Forces(vectors(array, "forces")?),
            _ => return Err(refused("give either accelerations or forces")),
        };
        let inverse_mass = numbers(&inverse_mass, "inverse_mass")?;
        let params = settings.params(!matches!(loads, ParticleLoads::None))?;

        let (mut state, mut held) = (self.state.hold(STEP)?, self.scene.get().hold()?);
        let State { step, detectors } = &mut *state;
        let scene = &mut held.scene;
        let (report, swept) = Call::new(threads, None)?.run_short(py, || {
            let states = SceneStates { x: &mut *x, v: &mut *v, loads, inverse_mass };
            let mut report = step.correct(scene, states, &params, |scene, contacts| {
                detectors.detect(scene, contacts)
            })?;
            if !settings.swept {
                return Ok::<_, StepError>((report, None));
            }
            let states = SceneStates { x, v, loads: ParticleLoads::None, inverse_mass };
            let found =
                step.correct_swept(scene, states, &params, &CcdParams::DEFAULT, &mut report)?;
            Ok((report, Some(found)))
        })?;
        state.record(py, &report, swept.as_ref(), scene)
    }

    /// Shows the scene to the collector of cycles: a scene may have an attribute that holds it.
    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        visit.call(&self.scene)
    }
}

/// Sets the method of all pairs of a body.
fn set_method(detectors: &mut StepDetectors, bodies: &Bodies, body: BodyId, method: StepMethod) {
    for other in bodies.scene.ids().filter(|other| *other != body) {
        detectors.set_method(PairId::new(body, other), method);
    }
}

/// Builds the coarsest surface of a body within a deviation of its own, where the body is.
fn coarse_surface(
    body: &Body,
    deviation: f64,
    progress: Progress<'_>,
) -> Result<CoarseSurface, DecimateError> {
    let full = SurfaceTree::new(body.surface().clone(), body.positions().to_vec())?;
    let full = if body.kind() == BodyKind::Open { full.declared_open() } else { full };
    let decimation = Decimation::up_to(full, deviation, progress.part(0.0, 0.5))?;
    let reduced = decimation.within(deviation, progress.part(0.5, 1.0))?;
    CoarseSurface::new(reduced, decimation.full())
}

impl State {
    fn record<'py>(
        &self,
        py: Python<'py>,
        report: &StepReport,
        swept: Option<&SweptReport>,
        scene: &musculo_collide::Scene,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut fallbacks = Vec::new();
        for fallback in self.detectors.fallbacks() {
            let [a, b] = scene.names(fallback.pair);
            fallbacks.push((a, b, reason_name(fallback.reason)));
        }
        let mut unheld_overlaps = Vec::new();
        for pair in self.detectors.unheld_overlaps() {
            let [a, b] = scene.names(*pair);
            unheld_overlaps.push((a, b));
        }
        Ok(dict!(py, {
            contacts: report.contacts,
            rounds: report.rounds,
            depth_before: report.depth_before,
            depth: report.depth,
            approach_before: report.approach_before,
            approach: report.approach,
            impulse: vector(report.impulse),
            force: vector(report.force),
            kinetic_energy: report.kinetic_energy,
            rigid_work: report.rigid_work,
            contact_energy: report.contact_energy,
            unknown_sides: self.step.unknown_sides(),
            fallbacks: fallbacks,
            unheld_overlaps: unheld_overlaps,
            swept_contacts: swept.map(|swept| swept.contacts),
            free_share: swept.map(|swept| swept.free_share),
        }))
    }
}

/// Returns the reason against the method of a pair, as Python has it.
fn reason_name(reason: FallbackReason) -> &'static str {
    match reason {
        FallbackReason::NoStructure => "no structure",
        FallbackReason::NoPose => "no pose",
        FallbackReason::BallDeviation { .. } => "balls deviate",
        FallbackReason::CoarseDeviation { .. } => "coarse surface deviates",
        FallbackReason::CrossingEdges => "crossing edges",
        _ => "other",
    }
}

impl PairMaterial {
    /// Returns the library's material, which responds within a margin.
    fn with_margin(&self, margin: f64) -> PyResult<Material> {
        let margins = Margins::new(self.clearance, margin).map_err(refused)?;
        let dynamic = self.dynamic_friction.unwrap_or(self.friction);
        let friction = Friction::static_dynamic(self.friction, dynamic).map_err(refused)?;
        let spring = match self.stiffness {
            Some(stiffness) => Some(SpringDamper::new(stiffness, self.damping).map_err(refused)?),
            None => None,
        };
        let permanent = match self.permanent.as_deref() {
            None => None,
            Some("sticking") => Some(Restraint::Sticking),
            Some("sliding") => Some(Restraint::Sliding),
            Some(other) => {
                let message =
                    format!("permanent is {other:?}, but must be \"sticking\" or \"sliding\"");
                return Err(refused(message));
            }
        };
        let material = Material { margins, friction, spring, permanent };
        material.validate().map_err(refused)?;
        Ok(material)
    }
}

impl StepSettings {
    fn params(&self, has_loads: bool) -> PyResult<StepParams> {
        let mut params = StepParams::new(StepLength::new(self.h).map_err(refused)?);
        params.depth_tolerance = Some(self.depth_tolerance);
        params.push_tolerance = has_loads.then_some(0.0);
        params.max_rounds = count(self.max_rounds, "max_rounds")?;
        params.solver.max_iterations = count(self.iterations, "iterations")?;
        Ok(params)
    }
}
