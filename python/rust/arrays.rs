//! Arrays of numpy as points and faces of the library, and back.

use glam::DVec3;
use musculo_collide::surface::TriangleSurface;
use numpy::ndarray::Array2;
use numpy::{
    BorrowError, IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1,
    PyReadonlyArray2, PyReadwriteArray2, PyUntypedArrayMethods,
};
use pyo3::prelude::*;

use crate::error::refused;

/// Points that numpy holds, n × 3 in row order.
pub(crate) type Points<'py> = PyReadonlyArray2<'py, f64>;

/// Corners of faces that numpy holds, m × 3 in row order.
pub(crate) type Faces<'py> = PyReadonlyArray2<'py, i64>;

/// Array of the caller that a call changes in place, n × 3.
pub(crate) type States<'py> = Bound<'py, PyArray2<f64>>;

/// Borrows an array exclusively, until the result is dropped.
pub(crate) fn borrowed<'py>(
    array: &States<'py>,
    what: &str,
) -> PyResult<PyReadwriteArray2<'py, f64>> {
    array.try_readwrite().map_err(|error| match error {
        BorrowError::NotWriteable => refused(format!("{what} is read-only, but changed in place")),
        _ => refused(format!("{what} is in use: by another call, or as another argument of this")),
    })
}

/// Returns the rows of a borrowed array where they are.
pub(crate) fn vectors<'a>(
    array: &'a mut PyReadwriteArray2<'_, f64>,
    what: &str,
) -> PyResult<&'a mut [DVec3]> {
    let shape = array.shape().to_vec();
    match array.as_slice_mut() {
        Ok(numbers) if shape[1] == 3 => Ok(bytemuck::cast_slice_mut(numbers)),
        _ => Err(not_rows(what, &shape)),
    }
}

/// Returns the numbers of an array where they are.
pub(crate) fn numbers<'a>(array: &'a PyReadonlyArray1<'_, f64>, what: &str) -> PyResult<&'a [f64]> {
    array.as_slice().map_err(|_| refused(format!("{what} are not in one piece of memory")))
}

/// Returns the points of an array where they are, without a copy.
pub(crate) fn points<'a>(array: &'a Points<'_>) -> PyResult<&'a [DVec3]> {
    match array.as_slice() {
        Ok(numbers) if array.shape()[1] == 3 => Ok(bytemuck::cast_slice(numbers)),
        _ => Err(not_rows("points", array.shape())),
    }
}

/// Checks that a point is finite; the error names it by its number.
pub(crate) fn require_finite(number: usize, point: DVec3) -> Result<(), String> {
    if point.is_finite() { Ok(()) } else { Err(format!("point {number} is not finite: {point}")) }
}

/// Returns the corners of faces where they are, without a copy.
pub(crate) fn corners<'a>(array: &'a Faces<'_>) -> PyResult<&'a [[i64; 3]]> {
    match array.as_slice() {
        Ok(numbers) if array.shape()[1] == 3 => Ok(numbers.as_chunks().0),
        _ => Err(not_rows("faces", array.shape())),
    }
}

/// Returns the surface with these faces, or the reason against them. It needs no interpreter.
pub(crate) fn surface(
    name: &str,
    vertex_count: usize,
    faces: &[[i64; 3]],
) -> Result<TriangleSurface, String> {
    // Every corner is the number of a vertex.
    let mut list = Vec::with_capacity(faces.len());
    for (face, corners) in faces.iter().enumerate() {
        let mut own = [0; 3];
        for (own, &corner) in own.iter_mut().zip(corners) {
            *own = match u32::try_from(corner) {
                Ok(corner) if (corner as usize) < vertex_count => corner,
                _ => {
                    return Err(format!(
                        "{name}: face {face} has the corner {corner}, but there are {vertex_count} \
                         vertices, numbered from 0"
                    ));
                }
            };
        }
        list.push(own);
    }
    TriangleSurface::new(vertex_count, list).map_err(|error| format!("{name}: {error}"))
}

fn not_rows(what: &str, shape: &[usize]) -> PyErr {
    refused(format!(
        "{what} are rows of three numbers in row order, not an array of shape {shape:?}"
    ))
}

/// Returns points as an array, n × 3.
pub(crate) fn point_array<'py>(py: Python<'py>, points: &[DVec3]) -> Bound<'py, PyArray2<f64>> {
    rows(py, bytemuck::cast_slice(points))
}

/// Returns rows of numbers as an array.
pub(crate) fn row_array<'py, T: numpy::Element + Copy, const N: usize>(
    py: Python<'py>,
    list: &[[T; N]],
) -> Bound<'py, PyArray2<T>> {
    let flat = list.as_flattened().to_vec();
    let rows = Array2::from_shape_vec((list.len(), N), flat);
    rows.unwrap_or_else(|_| Array2::from_shape_fn((list.len(), N), |(i, j)| list[i][j]))
        .into_pyarray(py)
}

fn rows<'py>(py: Python<'py>, numbers: &[f64]) -> Bound<'py, PyArray2<f64>> {
    let (rows, _) = numbers.as_chunks::<3>();
    row_array(py, rows)
}

/// Returns a list of numbers as an array.
pub(crate) fn array<'py, T: numpy::Element>(
    py: Python<'py>,
    list: Vec<T>,
) -> Bound<'py, PyArray1<T>> {
    list.into_pyarray(py)
}
