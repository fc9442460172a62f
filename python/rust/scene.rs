//! Scenes of named bodies.

use musculo_collide::ccd::CcdParams;
use musculo_collide::resolve::{ResolveParams, resolve};
use musculo_collide::{BodyId, BodyKind, CheckParams, JointContactParams, PairId, PathMove};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Faces, Points, point_array, points, row_array, surface};
use crate::call::Call;
use crate::error::refused;
use crate::joint::{self, Cartilage};
use crate::motion::{Motion, Placement};
use crate::{record, resolution};

/// Bodies of a scene, with the native calls on them.
#[pyclass(subclass, module = "musculo_collide._native")]
#[derive(Debug, Default)]
pub(crate) struct Scene {
    scene: musculo_collide::Scene,
}

#[pymethods]
impl Scene {
    #[new]
    fn new() -> Self {
        Self::default()
    }

    /// Adds a body of kind "rigid", "deformable" or "open".
    fn _add(
        &mut self,
        name: &str,
        kind: &str,
        vertices: Points<'_>,
        faces: Faces<'_>,
    ) -> PyResult<()> {
        let kind = match kind {
            "rigid" => BodyKind::Rigid,
            "open" => BodyKind::Open,
            _ => BodyKind::Deformable,
        };
        let positions = points(&vertices)?.to_vec();
        let surface = surface(&format!("body {name:?}"), positions.len(), &faces)?;
        self.scene.add(name, kind, surface, positions).map_err(refused)?;
        Ok(())
    }

    /// Returns the names of all bodies, in the order they were added.
    fn _names(&self) -> Vec<String> {
        self.scene.bodies().iter().map(|body| body.name().to_owned()).collect()
    }

    fn _kind(&self, name: &str) -> PyResult<&'static str> {
        Ok(match self.scene.body(self.find(name)?).kind() {
            BodyKind::Rigid => "rigid",
            BodyKind::Deformable => "deformable",
            BodyKind::Open => "open",
        })
    }

    fn _vertices<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(point_array(py, self.scene.body(self.find(name)?).positions()))
    }

    fn _faces<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray2<u32>>> {
        Ok(row_array(py, self.scene.body(self.find(name)?).surface().faces()))
    }

    fn _move(&mut self, name: &str, vertices: Points<'_>) -> PyResult<()> {
        let body = self.find(name)?;
        self.scene.move_body(body, points(&vertices)?).map_err(refused)
    }

    fn _pose(&mut self, name: &str, placement: Placement) -> PyResult<()> {
        let body = self.find(name)?;
        self.scene.pose_body(body, &placement.pose()).map_err(refused)
    }

    /// Returns the numbers of a body's particles: the first, and the one after the last.
    fn _particles(&self, name: &str) -> PyResult<(u32, u32)> {
        let particles = self.scene.body(self.find(name)?).particles();
        Ok((particles.start, particles.end))
    }

    fn _ignore(&mut self, a: &str, b: &str) -> PyResult<()> {
        let [a, b] = [self.find(a)?, self.find(b)?];
        self.scene.ignore(a, b);
        Ok(())
    }

    #[pyo3(signature = (margin, measures, depth_tolerance, threads, progress))]
    fn _check<'py>(
        &mut self,
        py: Python<'py>,
        margin: f64,
        measures: bool,
        depth_tolerance: Option<f64>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let params = CheckParams { margin, measures, depth_tolerance };
        let scene = &mut self.scene;
        let reports =
            Call::new(threads, progress)?.run(py, |progress| scene.check(&params, progress))?;
        reports.iter().map(|report| record::pair(py, report, &self.scene)).collect()
    }

    /// Sweeps bodies, by their names, on their ways during a step.
    #[pyo3(signature = (moves, first_of_pairs, separation, threads, progress))]
    fn _sweep<'py>(
        &mut self,
        py: Python<'py>,
        moves: Vec<(String, Motion<'py>)>,
        first_of_pairs: bool,
        separation: f64,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        // Bodies are moved while their ways are swept: paths keep where they were.
        let mut starts = Vec::with_capacity(moves.len());
        for (name, _) in &moves {
            let body = self.find(name)?;
            starts.push((body, self.scene.body(body).positions().to_vec()));
        }
        let mut paths = Vec::with_capacity(moves.len());
        for ((_, motion), (body, start)) in moves.iter().zip(&starts) {
            paths.push(motion.paths(self.scene.body(*body), start)?);
        }
        let mut ways = Vec::with_capacity(moves.len());
        for ((body, _), path) in starts.iter().zip(&paths) {
            ways.push(PathMove { body: *body, path: path.as_ref() });
        }

        let params = CcdParams { min_separation: separation, ..CcdParams::EXACT };
        let scene = &mut self.scene;
        let report = Call::new(threads, progress)?.run(py, |progress| {
            if first_of_pairs {
                scene.first_contacts(&ways, &params, progress)
            } else {
                scene.sweep_paths(&ways, &params, progress)
            }
        })?;
        record::sweep(py, &report, &self.scene)
    }

    /// Measures the contact of pairs of bodies, named in order.
    #[pyo3(signature = (pairs, margin, resolution, cartilage, threads, progress))]
    #[expect(clippy::too_many_arguments, reason = "named arguments in Python")]
    fn _joint_contacts<'py>(
        &mut self,
        py: Python<'py>,
        pairs: Vec<(String, String)>,
        margin: f64,
        resolution: f64,
        cartilage: Option<Cartilage>,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Vec<(Bound<'py, PyDict>, Bound<'py, PyDict>)>> {
        let mut ids = Vec::with_capacity(pairs.len());
        for (a, b) in &pairs {
            ids.push(self.pair(a, b)?);
        }
        let foundation = cartilage.map(|layer| layer.foundation()).transpose()?;
        let params = JointContactParams { margin, resolution, foundation };
        let scene = &mut self.scene;
        let found = Call::new(threads, progress)?
            .run(py, |progress| scene.joint_contacts(&ids, &params, progress))?;

        // The library has the body that was added first as the first of a pair.
        let mut contacts = Vec::with_capacity(found.len());
        for ((pair, (a, _)), [of_a, of_b]) in ids.iter().zip(&pairs).zip(&found) {
            let [of_a, of_b] = [joint::contact(py, of_a)?, joint::contact(py, of_b)?];
            let is_in_order = self.find(a)? == pair.a;
            contacts.push(if is_in_order { (of_a, of_b) } else { (of_b, of_a) });
        }
        Ok(contacts)
    }

    #[pyo3(signature = (smoothing, tolerance, gap, max_rounds, threads, progress))]
    #[expect(clippy::too_many_arguments, reason = "named arguments in Python")]
    fn _resolve<'py>(
        &mut self,
        py: Python<'py>,
        smoothing: f64,
        tolerance: Option<f64>,
        gap: f64,
        max_rounds: u32,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let default = ResolveParams::with_smoothing(smoothing);
        let params = ResolveParams {
            tolerance: tolerance.unwrap_or(default.tolerance),
            gap,
            max_rounds,
            ..default
        };
        let scene = &mut self.scene;
        let found =
            Call::new(threads, progress)?.run(py, |progress| resolve(scene, &params, progress))?;
        resolution::record(py, &found, &self.scene)
    }
}

impl Scene {
    /// Returns the library's scene.
    pub(crate) fn library(&self) -> &musculo_collide::Scene {
        &self.scene
    }

    /// Returns the library's scene, which a call may change.
    pub(crate) fn library_mut(&mut self) -> &mut musculo_collide::Scene {
        &mut self.scene
    }

    /// Finds the pair of two bodies.
    pub(crate) fn pair(&self, a: &str, b: &str) -> PyResult<PairId> {
        let pair = PairId::new(self.find(a)?, self.find(b)?);
        if pair.a == pair.b {
            return Err(refused(format!("both bodies of a pair are {a:?}")));
        }
        Ok(pair)
    }

    /// Finds a body by its name.
    pub(crate) fn find(&self, name: &str) -> PyResult<BodyId> {
        self.scene.find(name).ok_or_else(|| {
            let names: Vec<&str> = self.scene.bodies().iter().map(|body| body.name()).collect();
            refused(format!("no body is named {name:?}; there are {names:?}"))
        })
    }
}
