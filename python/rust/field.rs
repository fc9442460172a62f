//! Signed distance fields.

use std::path::PathBuf;
use std::sync::Arc;

use glam::DVec3;
use mesh_io::FieldFormat;
use musculo_collide::distance_field::{
    DistanceField, FieldParams, Interpolation, MeasuredError, QueryParams, SampleBatch,
};
use musculo_collide::{Interrupted, Progress};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Faces, Points, array, corners, point_array, points, require_finite, surface};
use crate::call::Call;
use crate::error::{refused, unreadable};
use crate::record::{dict, vector};

/// Points that are evaluated between two polls for interruption: some hundredths of a second.
const POLL_INTERVAL: usize = 1 << 18;

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
        let (positions, corners) = (points(&vertices)?, corners(&faces)?);
        let default = FieldParams::new(spacing);
        let padding = padding.unwrap_or(default.padding);
        let params = FieldParams { padding, truncation, ..default };
        let field = Call::new(threads, progress)?.run(py, |progress: Progress<'_>| {
            let surface = surface("the surface", positions.len(), corners)?;
            let x = surface.positions(positions).map_err(|error| error.to_string())?;
            DistanceField::build(&surface, x, &params, progress).map_err(|error| error.to_string())
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
        threads: Option<i64>,
    ) -> PyResult<Samples<'py>> {
        let points = points(&at)?;
        for (number, &point) in points.iter().enumerate() {
            require_finite(number, point).map_err(refused)?;
        }
        let interpolation = if cubic { Interpolation::Cubic } else { Interpolation::Trilinear };
        let params = QueryParams { interpolation, ..QueryParams::default() };
        let call = Call::new(threads, None)?;
        let samples = if points.len() <= POLL_INTERVAL {
            call.run_short(py, || Ok::<_, Interrupted>(self.sample(points, &params)))?
        } else {
            call.run(py, |progress| self.sample_in_pieces(points, &params, progress))?
        };
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
    fn sample(&self, points: &[DVec3], params: &QueryParams) -> SampleBatch {
        let mut samples = SampleBatch::default();
        self.field.query_batch(points, params, &mut samples);
        samples
    }

    /// Evaluates many points, with a poll for interruption before each piece of them.
    fn sample_in_pieces(
        &self,
        points: &[DVec3],
        params: &QueryParams,
        progress: Progress<'_>,
    ) -> Result<SampleBatch, Interrupted> {
        let pieces = points.chunks(POLL_INTERVAL);
        let steps = progress.steps(pieces.len());
        let mut all = SampleBatch::default();
        all.distance.reserve_exact(points.len());
        all.gradient.reserve_exact(points.len());

        let mut samples = SampleBatch::default();
        for piece in pieces {
            steps.advance(1)?;
            self.field.query_batch(piece, params, &mut samples);
            all.distance.append(&mut samples.distance);
            all.gradient.append(&mut samples.gradient);
        }
        Ok(all)
    }

    /// Returns the field, to be held by others too.
    pub(crate) fn shared(&self) -> Arc<DistanceField> {
        Arc::clone(&self.field)
    }
}
