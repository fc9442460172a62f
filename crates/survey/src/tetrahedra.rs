//! Spatial hashing of volume meshes: vertices inside tetrahedra.
//!
//! All points are entered into a hash table of cells; each tetrahedron looks
//! up the cells that its box reaches into, and tests the points in them by
//! barycentric coordinates. Points are found inside, edges through faces are not.
//!
//! Source: M. Teschner, B. Heidelberger, M. Müller, D. Pomeranets and M. Gross,
//! "Optimized spatial hashing for collision detection of deformable objects",
//! VMV 2003, sections 3 and 4. Differs in that points and tetrahedra are two
//! lists, so that a tetrahedron never meets its own corners.
//!
//! # Example
//!
//! ```
//! use glam::DVec3;
//! use survey::{spatial_hash::Params, tetrahedra};
//!
//! let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z];
//! let points = [DVec3::splat(0.1), DVec3::splat(0.5)];
//! let params = Params { cell_size: 1.0, ..Params::DEFAULT };
//! let found = tetrahedra::detect(&points, &corners, &[[0, 1, 2, 3]], &params)?;
//! assert_eq!(found.inside.len(), 1);
//! assert_eq!((found.inside[0].point, found.inside[0].tetrahedron), (0, 0));
//! assert!((found.inside[0].weights[0] - 0.7).abs() < 1e-15);
//! # Ok::<(), survey::SurveyError>(())
//! ```

use glam::{DMat3, DVec3};

use crate::boxes::Bounds;
use crate::cells::{CellTable, Grid};
use crate::error::{SurveyError, check_count};
use crate::findings::index;
use crate::spatial_hash::{MOST_SLOTS, Params};

/// A point inside a tetrahedron or on its border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointInside {
    /// The point.
    pub point: u32,
    /// The tetrahedron.
    pub tetrahedron: u32,
    /// Weights of its corners that make up the point: not negative, of sum 1.
    pub weights: [f64; 4],
}

/// What was found, and the tests it took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PointsInside {
    /// By point, then by tetrahedron; a point on a border may be in several.
    pub inside: Vec<PointInside>,
    /// Points against boxes, and against tetrahedra.
    pub tests: u64,
}

/// Finds the points that are in tetrahedra, up to rounding. Tetrahedra without
/// volume hold nothing.
///
/// # Errors
///
/// When a parameter is out of range, a point is not finite, a tetrahedron
/// refers to a point that does not exist, or the cells are so small that
/// tetrahedra reach into too many.
pub fn detect(
    points: &[DVec3],
    corners: &[DVec3],
    tetrahedra: &[[u32; 4]],
    params: &Params,
) -> Result<PointsInside, SurveyError> {
    check_count("slots", params.slots.into(), MOST_SLOTS)?;
    let grid = Grid::new(params.cell_size)?;
    check_finite(points)?;
    check_finite(corners)?;
    let volumes = gather(corners, tetrahedra)?;
    grid.check(volumes.iter().map(|x| Bounds::of(x)))?;
    let items: Vec<(u32, Bounds)> =
        points.iter().enumerate().map(|(i, &p)| (index(i), Bounds::of(&[p]))).collect();
    let table = CellTable::new(grid, params.slots, &items)?;
    let mut found = PointsInside::default();
    for (tetrahedron, x) in volumes.iter().enumerate() {
        let bounds = Bounds::of(x);
        for point in grid.cells(bounds).flat_map(|cell| table.items(cell)) {
            found.tests += 1;
            let p = points[point as usize];
            if bounds.holds(p) {
                found.tests += 1;
                let weights = weights(x, p);
                if weights.iter().all(|weight| *weight >= 0.0) {
                    let tetrahedron = index(tetrahedron);
                    found.inside.push(PointInside { point, tetrahedron, weights });
                }
            }
        }
    }
    found.inside.sort_unstable_by_key(|inside| (inside.point, inside.tetrahedron));
    Ok(found)
}

fn check_finite(points: &[DVec3]) -> Result<(), SurveyError> {
    let bad = points.iter().position(|p| !p.is_finite());
    bad.map_or(Ok(()), |point| Err(SurveyError::NotFinite { point }))
}

/// Corners of each tetrahedron.
fn gather(corners: &[DVec3], tetrahedra: &[[u32; 4]]) -> Result<Vec<[DVec3; 4]>, SurveyError> {
    let points = corners.len();
    let each = tetrahedra.iter().enumerate().map(|(tetrahedron, of)| {
        match of.iter().find(|point| **point as usize >= points) {
            Some(&point) => Err(SurveyError::PointOutOfRange { tetrahedron, point, points }),
            None => Ok(of.map(|point| corners[point as usize])),
        }
    });
    each.collect()
}

/// Barycentric coordinates; not a number where there is no volume.
fn weights(&[x0, x1, x2, x3]: &[DVec3; 4], p: DVec3) -> [f64; 4] {
    let of_rest = DMat3::from_cols(x1 - x0, x2 - x0, x3 - x0).inverse() * (p - x0);
    [1.0 - of_rest.element_sum(), of_rest.x, of_rest.y, of_rest.z]
}
