//! Contact step of a simulator, over arrays of numpy in place.

use glam::DVec3;
use musculo_collide::ccd::CcdParams;
use musculo_collide::distance_field::FieldDetector;
use musculo_collide::scene::{DetectorParams, PermanentParams};
use musculo_collide::{
    Friction, Margins, Material, PairId, ParticleLoads, Restraint, RigidMotion, SceneStates,
    SceneStep, SpringDamper, StepDetectors, StepError, StepLength, StepMethod, StepParams,
    StepReport, SweptReport,
};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{States, borrowed, numbers, vectors};
use crate::call::Call;
use crate::error::refused;
use crate::field::Field;
use crate::motion::Placement;
use crate::record::{dict, vector};
use crate::scene::Scene;

/// Native contact step, with the scene that it was made for.
#[pyclass(module = "musculo_collide._native")]
#[derive(Debug)]
pub(crate) struct Step {
    scene: Py<Scene>,
    step: SceneStep,
    detectors: StepDetectors,
    margin: f64,
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

/// Settings of one step, in the order in which Python gives them.
#[derive(Debug, FromPyObject)]
pub(crate) struct StepSettings(f64, f64, u32, u32, bool);

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
        Ok(Self { scene, step, detectors, margin })
    }

    fn set_material(
        &mut self,
        py: Python<'_>,
        a: &str,
        b: &str,
        material: PairMaterial,
    ) -> PyResult<()> {
        let scene = self.scene.try_borrow(py)?;
        let pair = scene.pair(a, b)?;
        let in_library = material.with_margin(self.margin)?;
        if let Some(restraint) = in_library.permanent {
            let (skin, attach_within) = (self.margin, material.attach_within);
            let params = PermanentParams { restraint, skin, attach_within };
            self.detectors.set_permanent(pair, params).map_err(refused)?;
        }
        self.step.set_material(pair, in_library);
        Ok(())
    }

    /// Detects all pairs of a bone by its field.
    fn set_field(&mut self, py: Python<'_>, name: &str, field: &Field) -> PyResult<()> {
        let scene = self.scene.try_borrow(py)?;
        let bone = scene.find(name)?;
        let detector = FieldDetector::new(field.shared(), self.margin).map_err(refused)?;
        self.detectors.set_field(bone, detector);
        for other in scene.library().ids().filter(|other| *other != bone) {
            self.detectors.set_method(PairId::new(bone, other), StepMethod::Field);
        }
        Ok(())
    }

    /// Places a bone, and sets its velocities there.
    fn move_bone(
        &mut self,
        py: Python<'_>,
        name: &str,
        placement: Placement,
        velocity: [f64; 3],
        spin: [f64; 3],
        about: [f64; 3],
    ) -> PyResult<()> {
        let mut scene = self.scene.try_borrow_mut(py)?;
        let bone = scene.find(name)?;
        let [velocity, spin, about] = [velocity, spin, about].map(DVec3::from_array);
        let motion = RigidMotion { about, velocity, spin, ..RigidMotion::default() };
        let moved = self.step.move_bone(scene.library_mut(), bone, &placement.pose(), motion);
        moved.map_err(refused)
    }

    /// Corrects the states of all particles where they are.
    #[expect(clippy::too_many_arguments, reason = "named arguments in Python")]
    fn correct<'py>(
        &mut self,
        py: Python<'py>,
        x: States<'py>,
        v: States<'py>,
        inverse_mass: PyReadonlyArray1<'py, f64>,
        accelerations: Option<States<'py>>,
        forces: Option<States<'py>>,
        settings: StepSettings,
        threads: Option<usize>,
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
        let StepSettings(.., swept) = settings;
        let params = settings.params(!matches!(loads, ParticleLoads::None))?;

        let Self { scene, step, detectors, .. } = self;
        let mut held = scene.try_borrow_mut(py)?;
        let scene = held.library_mut();
        let (report, swept) = Call::new(threads, None)?.run_short(py, || {
            let states = SceneStates { x: &mut *x, v: &mut *v, loads, inverse_mass };
            let mut report = step.correct(scene, states, &params, |scene, contacts| {
                detectors.detect(scene, contacts)
            })?;
            if !swept {
                return Ok::<_, StepError>((report, None));
            }
            let states = SceneStates { x, v, loads: ParticleLoads::None, inverse_mass };
            let found =
                step.correct_swept(scene, states, &params, &CcdParams::DEFAULT, &mut report)?;
            Ok((report, Some(found)))
        })?;
        drop(held);
        self.record(py, &report, swept.as_ref())
    }
}

impl Step {
    fn record<'py>(
        &self,
        py: Python<'py>,
        report: &StepReport,
        swept: Option<&SweptReport>,
    ) -> PyResult<Bound<'py, PyDict>> {
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
            fallbacks: self.detectors.fallbacks().len(),
            unheld_overlaps: self.detectors.unheld_overlaps().len(),
            swept_contacts: swept.map(|swept| swept.contacts),
            free_share: swept.map(|swept| swept.free_share),
        }))
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
        let &Self(h, depth_tolerance, max_rounds, iterations, _) = self;
        let mut params = StepParams::new(StepLength::new(h).map_err(refused)?);
        params.depth_tolerance = Some(depth_tolerance);
        params.push_tolerance = has_loads.then_some(0.0);
        params.max_rounds = max_rounds;
        params.solver.max_iterations = iterations;
        Ok(params)
    }
}
