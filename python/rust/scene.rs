//! Scenes of named bodies.

use glam::{DMat3, DQuat, DVec3};
use musculo_collide::ccd::CcdParams;
use musculo_collide::resolve::{ResolveParams, resolve};
use musculo_collide::surface::Pose;
use musculo_collide::{BodyId, BodyKind, BodyMove, CheckParams};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Faces, Points, point_array, points, row_array, surface};
use crate::call::Call;
use crate::error::refused;
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

    /// Places a rigid body by the nine numbers of a rotation, row by row, and a translation.
    fn _pose(&mut self, name: &str, rotation: [f64; 9], translation: [f64; 3]) -> PyResult<()> {
        let body = self.find(name)?;
        let rotation = DQuat::from_mat3(&DMat3::from_cols_array(&rotation).transpose());
        let pose = Pose::new(rotation, DVec3::from_array(translation));
        self.scene.pose_body(body, &pose).map_err(refused)
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

    /// Sweeps bodies, by their names, to the positions they have at the end of a step.
    #[pyo3(signature = (moves, separation, threads, progress))]
    fn _sweep<'py>(
        &mut self,
        py: Python<'py>,
        moves: Vec<(String, Points<'py>)>,
        separation: f64,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let mut ends = Vec::new();
        for (name, vertices) in &moves {
            ends.push(BodyMove { body: self.find(name)?, positions: points(vertices)? });
        }
        let params = CcdParams { min_separation: separation, ..CcdParams::EXACT };
        let scene = &mut self.scene;
        let report = Call::new(threads, progress)?
            .run(py, |progress| scene.sweep(&ends, &params, progress))?;
        record::sweep(py, &report, &self.scene)
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

    fn find(&self, name: &str) -> PyResult<BodyId> {
        self.scene.find(name).ok_or_else(|| {
            let names: Vec<&str> = self.scene.bodies().iter().map(|body| body.name()).collect();
            refused(format!("no body is named {name:?}; there are {names:?}"))
        })
    }
}
