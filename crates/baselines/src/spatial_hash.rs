//! Spatial hashing of surfaces: faces that cross, by the cells they reach into.
//!
//! The faces of the second body are entered into a hash table of cells, those
//! of the first looked up in it; of faces that share a cell, boxes and then
//! triangles are tested, exactly. Each pair is tested in one cell only. From
//! the edges that cross, vertices inside and their depths spread over both
//! surfaces; a body wholly inside the other crosses nothing and is not found.
//!
//! Sources: M. Teschner, B. Heidelberger, M. Müller, D. Pomeranets and M. Gross,
//! "Optimized spatial hashing for collision detection of deformable objects",
//! VMV 2003; B. Heidelberger, M. Teschner, R. Keiser, M. Müller and M. Gross,
//! "Consistent penetration depth estimation for deformable collision response",
//! VMV 2004 (depths). The paper hashes vertices against tetrahedra;
//! here faces are hashed against faces, which finds every crossing, edges
//! through faces included.
//!
//! See the crate's example for how to use it.

use surface::{Meeting, triangles_meet};

use crate::boxes::Bounds;
use crate::cells::{CellTable, Grid};
use crate::error::{BaselineError, check_count};
use crate::findings::{PairFindings, PlacedSurface};
use crate::propagation;

/// How fine the cells are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpatialHashParams {
    /// Edge of a cell \[length unit\], `> 0`. Twice the mean length of the
    /// faces' edges is fastest; larger cells hold more pairs to test, smaller
    /// ones more entries.
    pub cell_size: f64,
    /// Slots of the table, in `1..=2^26`: about as many as there are faces.
    pub slots: u32,
}

impl SpatialHashParams {
    /// Cells of 10 (millimetres, for a body of the size of a thigh), and a
    /// prime number of slots.
    pub const DEFAULT: Self = Self { cell_size: 10.0, slots: 65_521 };

    fn grid(&self) -> Result<Grid, BaselineError> {
        check_count("slots", self.slots.into(), MOST_SLOTS)?;
        Grid::new(self.cell_size)
    }
}

impl Default for SpatialHashParams {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// Slots a table may have: 2^26 take half a gigabyte.
pub(crate) const MOST_SLOTS: u64 = 1 << 26;

/// Finds the faces of two bodies that cross, and the vertices inside that the
/// crossings tell of. Exact in the crossings, whatever the cells.
///
/// Vertices inside are right for closed, outward surfaces, but for those of
/// parts that cross nothing.
///
/// # Errors
///
/// When a parameter is out of range, or the cells are so small that the table
/// would not fit.
pub fn detect(
    a: PlacedSurface<'_>,
    b: PlacedSurface<'_>,
    params: &SpatialHashParams,
) -> Result<PairFindings, BaselineError> {
    let (crossing, tests) = crossing_faces(a, b, params)?;
    let inside = propagation::inside(a, b, &crossing);
    Ok(PairFindings {
        overlap: !crossing.is_empty(),
        inside: Some(inside),
        crossing_faces: Some(crossing),
        tests,
        ..PairFindings::default()
    })
}

/// Pairs of faces that cross, ascending, and the tests that it took.
fn crossing_faces(
    a: PlacedSurface<'_>,
    b: PlacedSurface<'_>,
    params: &SpatialHashParams,
) -> Result<(Vec<[u32; 2]>, u64), BaselineError> {
    let grid = params.grid()?;
    let shared = Bounds::of(a.x.as_slice()).intersection(Bounds::of(b.x.as_slice()));
    let boxes = |body: PlacedSurface<'_>| -> Vec<(u32, Bounds)> {
        let each = (0..body.face_count()).map(|face| (face, Bounds::of(&body.corners(face))));
        each.filter(|(_, bounds)| bounds.overlaps(shared)).collect()
    };
    let (of_a, of_b) = (boxes(a), boxes(b));
    grid.check(of_a.iter().map(|item| item.1))?;
    let table = CellTable::new(grid, params.slots, &of_b)?;
    let bounds_of = |face: u32| Bounds::of(&b.corners(face));
    let (mut crossing, mut tests) = (Vec::new(), 0);
    for &(face, bounds) in &of_a {
        table.near(bounds, bounds_of, |other| {
            tests += 1;
            if bounds.overlaps(bounds_of(other)) {
                tests += 1;
                if triangles_meet(a.corners(face), b.corners(other)) == Meeting::Crossing {
                    crossing.push([face, other]);
                }
            }
        });
    }
    crossing.sort_unstable();
    Ok((crossing, tests))
}
