//! Medial surfaces.

use glam::DVec3;
use musculo_collide::medial::{MedialParams, generate as generate_medial};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{Faces, Points, array, corners, point_array, points, row_array, surface};
use crate::call::{Call, count};
use crate::error::refused;
use crate::record::dict;

/// Generates a medial surface by number of balls or by tolerance.
#[pyfunction]
#[pyo3(name = "generate_medial", signature = (vertices, faces, balls, tolerance, threads, progress))]
pub(crate) fn generate<'py>(
    py: Python<'py>,
    vertices: Points<'py>,
    faces: Faces<'py>,
    balls: Option<i64>,
    tolerance: Option<f64>,
    threads: Option<i64>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let params = match (balls, tolerance) {
        (Some(balls), None) => MedialParams::balls(count(balls, "balls")? as usize),
        (None, Some(tolerance)) => MedialParams::tolerance(tolerance),
        _ => return Err(refused("name either a number of balls or a tolerance")),
    };
    let (positions, corners) = (points(&vertices)?, corners(&faces)?);
    let generated = Call::new(threads, progress)?.run(py, |progress| {
        let surface = surface("the surface", positions.len(), corners)?;
        let x = surface.positions(positions).map_err(|error| error.to_string())?;
        generate_medial(&surface, x, &params, progress).map_err(|error| error.to_string())
    })?;

    let medial = &generated.medial;
    let centers: Vec<DVec3> = medial.balls().iter().map(|ball| ball.center).collect();
    let cones: Vec<[u32; 2]> = medial.cones().collect();
    let deviation = &generated.deviation;
    Ok(dict!(py, {
        centers: point_array(py, &centers),
        radii: array(py, medial.balls().iter().map(|ball| ball.radius).collect()),
        slabs: row_array(py, medial.slabs()),
        cones: row_array(py, &cones),
        rms_deviation: deviation.rms,
        max_deviation: deviation.largest(),
    }))
}
