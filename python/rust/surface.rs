//! Exact questions of points to one surface.

use glam::DVec3;
use musculo_collide::kdop::Workspace;
use musculo_collide::overlap::{DepthParams, Overlap, OverlapDetector};
use musculo_collide::proximity::{ClosestPoint, SurfaceTree};
use musculo_collide::surface::{Aabb, MAX_COORDINATE, parallel};
use musculo_collide::{Interrupted, Progress};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{
    Faces, Points, array, corners, point_array, points, require_finite, row_array, surface,
};
use crate::call::{Call, short};
use crate::error::refused;
use crate::record;

/// Points between two polls for interruption: some milliseconds.
const POLL_INTERVAL: usize = 1024;

/// Native surface with its tree.
#[pyclass(frozen, module = "musculo_collide._native")]
#[derive(Debug)]
pub(crate) struct Surface {
    tree: SurfaceTree,
}

/// Closest points, their faces, and distances.
type Closest<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<f64>>);

#[pymethods]
impl Surface {
    #[new]
    fn new(py: Python<'_>, vertices: Points<'_>, faces: Faces<'_>) -> PyResult<Self> {
        let (x, corners) = (points(&vertices)?, corners(&faces)?);
        if corners.is_empty() {
            return Err(refused("the surface has no faces"));
        }
        let tree = short(py, || {
            let surface = surface("the surface", x.len(), corners)?;
            SurfaceTree::new(surface, x.to_vec()).map_err(|error| error.to_string())
        })?;
        Ok(Self { tree })
    }

    fn vertices<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        point_array(py, self.tree.positions().as_slice())
    }

    fn faces<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        row_array(py, self.tree.surface().faces())
    }

    /// Returns the reason why the surface has no inside.
    fn no_inside(&self) -> Option<String> {
        self.tree.has_inside().err().map(|reason| reason.to_string())
    }

    fn contains<'py>(
        &self,
        py: Python<'py>,
        at: Points<'py>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyArray1<bool>>> {
        self.require_inside()?;
        let points = points(&at)?;
        let contains = |point, workspace: &mut Workspace, _: &mut Option<u32>| {
            self.tree.contains(point, workspace)
        };
        Ok(array(py, self.ask(py, points, threads, contains)?))
    }

    fn signed_distance<'py>(
        &self,
        py: Python<'py>,
        at: Points<'py>,
        threads: Option<i64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.require_inside()?;
        let points = points(&at)?;
        let signed = |point, workspace: &mut Workspace, hint: &mut Option<u32>| {
            let distance =
                self.closest(point, workspace, hint).map_or(f64::INFINITY, |p| p.distance);
            if self.tree.contains(point, workspace) { -distance } else { distance }
        };
        Ok(array(py, self.ask(py, points, threads, signed)?))
    }

    /// Measures what two surfaces share.
    fn overlap<'py>(&self, py: Python<'py>, other: &Self) -> PyResult<Bound<'py, PyDict>> {
        let bodies = [&self.tree, &other.tree];
        let measured = Call::new(Some(1), None)?.run(py, |progress| {
            let mut measured = Overlap::default();
            OverlapDetector::default().try_measure_into(bodies, &mut measured, progress)?;
            Ok::<_, Interrupted>(measured)
        })?;
        record::overlap(py, &measured)
    }

    /// Brackets the depth of each of two surfaces in the other, to a width or to 1 %.
    fn depths<'py>(
        &self,
        py: Python<'py>,
        other: &Self,
        width: Option<f64>,
    ) -> PyResult<[Option<Bound<'py, PyDict>>; 2]> {
        let bodies = [&self.tree, &other.tree];
        let params = depth_params(bodies, width)?;
        let [of_a, of_b] = Call::new(Some(1), None)?.run(py, |progress| {
            let mut detector = OverlapDetector::default();
            detector.try_measure_into(bodies, &mut Overlap::default(), progress)?;
            detector.depths_from(bodies, [&[]; 2], &params, progress)
        })?;
        Ok([record::depth(py, of_a)?, record::depth(py, of_b)?])
    }

    fn closest_points<'py>(
        &self,
        py: Python<'py>,
        at: Points<'py>,
        threads: Option<i64>,
    ) -> PyResult<Closest<'py>> {
        let points = points(&at)?;
        let closest = |point, workspace: &mut Workspace, hint: &mut Option<u32>| {
            self.closest(point, workspace, hint)
        };
        let found = self.ask(py, points, threads, closest)?;
        let (mut feet, mut faces, mut distances) = (Vec::new(), Vec::new(), Vec::new());
        for closest in found.into_iter().flatten() {
            feet.push(closest.foot.point);
            faces.push(closest.face);
            distances.push(closest.distance);
        }
        Ok((point_array(py, &feet), array(py, faces), array(py, distances)))
    }
}

/// Returns parameters for brackets of a width, or of 1 %, but no narrower than a hundred-thousandth
/// of the smaller surface.
fn depth_params(bodies: [&SurfaceTree; 2], width: Option<f64>) -> PyResult<DepthParams> {
    const FLOOR: f64 = 1e-5;

    let sizes =
        bodies.map(|body| Aabb::of_points(body.positions().as_slice().iter().copied()).diagonal());
    let params = DepthParams::with_floor(FLOOR * sizes[0].min(sizes[1]));
    match width {
        None => Ok(params),
        Some(tolerance) if tolerance.is_finite() && tolerance > 0.0 => {
            Ok(DepthParams { relative_tolerance: 0.0, tolerance, ..params })
        }
        Some(other) => {
            Err(refused(format!("the width is {other}, but must be finite and above 0")))
        }
    }
}

impl Surface {
    fn require_inside(&self) -> PyResult<()> {
        self.tree.has_inside().map_err(refused)
    }

    /// Finds the closest point; the face of the last one hints at the next.
    fn closest(
        &self,
        point: DVec3,
        workspace: &mut Workspace,
        hint: &mut Option<u32>,
    ) -> Option<ClosestPoint> {
        let found = self.tree.closest_point(point, f64::INFINITY, *hint, workspace);
        *hint = found.map(|closest| closest.face);
        found
    }

    /// Answers a question at every point, in their order.
    fn ask<T: Send>(
        &self,
        py: Python<'_>,
        points: &[DVec3],
        threads: Option<i64>,
        question: impl Fn(DVec3, &mut Workspace, &mut Option<u32>) -> T + Sync + Send,
    ) -> PyResult<Vec<T>> {
        for (number, &point) in points.iter().enumerate() {
            require_in_range(number, point).map_err(refused)?;
        }
        let pieces: Vec<(usize, &[DVec3])> =
            (0..).step_by(POLL_INTERVAL).zip(points.chunks(POLL_INTERVAL)).collect();
        let answer = |progress: Progress<'_>| {
            let steps = progress.steps(pieces.len());
            let answers = parallel::map_slice_with(
                &pieces,
                Workspace::default,
                |workspace, &(first, piece)| {
                    steps.advance(1).map_err(|interrupted| interrupted.to_string())?;
                    let mut hint = None;
                    let mut answers = Vec::with_capacity(piece.len());
                    for (number, &point) in piece.iter().enumerate() {
                        // Another thread may write to the caller's array meanwhile.
                        require_in_range(first + number, point)?;
                        answers.push(question(point, workspace, &mut hint));
                    }
                    Ok(answers)
                },
            );
            let answers: Result<Vec<Vec<T>>, String> = answers.into_iter().collect();
            Ok::<_, String>(answers?.into_iter().flatten().collect())
        };
        Call::new(threads, None)?.run(py, answer)
    }
}

/// Checks that a point is finite and within the range of coordinates, in which no distance
/// overflows; the error names it by its number.
fn require_in_range(number: usize, point: DVec3) -> Result<(), String> {
    require_finite(number, point)?;
    let largest = point.abs().max_element();
    if largest > MAX_COORDINATE {
        return Err(format!(
            "point {number} has the coordinate {largest:e}, but magnitudes end at \
             {MAX_COORDINATE:e}: products of coordinates would overflow"
        ));
    }
    Ok(())
}
