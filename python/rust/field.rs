//! Signed distance fields.

use std::path::PathBuf;
use std::sync::Arc;

use mesh_io::FieldFormat;
use musculo_collide::Progress;
use musculo_collide::distance_field::{
    DistanceField, FieldParams, Interpolation, MeasuredError, QueryParams, SampleBatch,
};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Faces, Points, array, point_array, points, surface};
use crate::call::Call;
use crate::error::{refused, unreadable};
use crate::record::{dict, vector};

/// Distances of points, and their gradients where asked for.
type Samples<'py> = (Bound<'py, PyArray1<f64>>, Option<Bound<'py, PyArray2<f64>>>);

/// Native distance field.
#[pyclass(frozen, module = "musculo_collide._native")]
#[derive(Debug)]
pub(crate) struct Field {
    field: Arc<DistanceField>,
}

#[pymethods]
impl Field {
    #[staticmethod]
    #[pyo3(signature = (vertices, faces, spacing, padding, truncation, threads, progress))]
    #[expect(clippy::too_many_arguments, reason = "named arguments in Python")]
    fn build(
        py: Python<'_>,
        vertices: Points<'_>,
        faces: Faces<'_>,
        spacing: f64,
        padding: Option<f64>,
        truncation: Option<f64>,
        threads: Option<i64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Self> {
        let positions = points(&vertices)?;
        let surface = surface("the surface", positions.len(), &faces)?;
        let x = surface.positions(positions).map_err(refused)?;
        let default = FieldParams::new(spacing);
        let padding = padding.unwrap_or(default.padding);
        let params = FieldParams { padding, truncation, ..default };
        let field = Call::new(threads, progress)?.run(py, |progress: Progress<'_>| {
            DistanceField::build(&surface, x, &params, progress)
        })?;
        Ok(Self { field: Arc::new(field) })
    }

    #[staticmethod]
    fn read(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let field = py.detach(|| mesh_io::read_field(&path)).map_err(unreadable)?;
        Ok(Self { field: Arc::new(field) })
    }

    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let Some(format) = FieldFormat::of(&path) else {
            return Err(unreadable(format!("{}: expected .nrrd or .vti", path.display())));
        };
        let written = py.detach(|| std::fs::write(&path, format.encode(&self.field)));
        written.map_err(|error| unreadable(format!("{}: {error}", path.display())))
    }

    /// Evaluates the field at points, which are read where they are.
    fn query<'py>(
        &self,
        py: Python<'py>,
        at: Points<'py>,
        cubic: bool,
        gradients: bool,
    ) -> PyResult<Samples<'py>> {
        let points = points(&at)?;
        let interpolation = if cubic { Interpolation::Cubic } else { Interpolation::Trilinear };
        let params = QueryParams { interpolation, ..QueryParams::default() };
        let mut samples = SampleBatch::default();
        py.detach(|| self.field.query_batch(points, &params, &mut samples));
        let gradient = gradients.then(|| point_array(py, &samples.gradient));
        Ok((array(py, samples.distance), gradient))
    }

    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f32>> {
        array(py, self.field.values())
    }

    fn grid<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let grid = self.field.grid();
        let [i, j, k] = grid.dims();
        Ok(dict!(py, {
            origin: vector(grid.origin()),
            spacing: grid.spacing(),
            dims: (i, j, k),
            bytes: self.field.bytes(),
        }))
    }

    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let report = self.field.report();
        let error = |measured: Option<MeasuredError>| {
            measured.map(|measured| (measured.points, measured.rms, measured.max))
        };
        let warnings: Vec<String> =
            report.warnings.iter().map(|warning| warning.to_string()).collect();
        Ok(dict!(py, {
            measured_error: error(report.measured_error),
            measured_deep_error: error(report.measured_deep_error),
            error_bound: report.error_bound,
            inside_volume: report.inside_volume,
            warnings: warnings,
        }))
    }
}

impl Field {
    /// Returns the field, to be held by others too.
    pub(crate) fn shared(&self) -> Arc<DistanceField> {
        Arc::clone(&self.field)
    }
}
