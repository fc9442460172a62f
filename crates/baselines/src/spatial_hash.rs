//! Spatial hashing of surfaces: crossing faces by the cells that they cover.
//!
//! The faces of the second surface are entered into a hash table of cells, and those of the first
//! are looked up in it. Faces that share a cell are tested, first their boxes, then the triangles,
//! exactly, each pair in one cell only. Vertices inside and their depths spread from the crossing
//! edges over both surfaces. A surface wholly inside the other crosses nothing and is not found.
//!
//! Sources: M. Teschner, B. Heidelberger, M. Müller, D. Pomeranets and M. Gross, "Optimized
//! spatial hashing for collision detection of deformable objects", VMV 2003; B. Heidelberger,
//! M. Teschner, R. Keiser, M. Müller and M. Gross, "Consistent penetration depth estimation for
//! deformable collision response", VMV 2004 (depths). The paper hashes vertices against
//! tetrahedra; here faces are hashed against faces, which finds every crossing, edges through
//! faces included.
//!
//! The front page of the crate has an example.

use surface::{Aabb, Meeting, triangles_meet};

use crate::cells::{BoxedItem, CellGrid, CellTable};
use crate::error::{BaselineError, check};
use crate::findings::{PairFindings, PlacedSurface};
use crate::propagation;

/// Parameters of spatial hashing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpatialHashParams {
    /// Edge of a cell \[length unit\], `> 0`. Twice the mean edge of the faces is fastest; larger
    /// cells hold more pairs to test, smaller ones more entries.
    pub cell_size: f64,
    /// Slots of the table, in `1..=2^26`: about as many as there are faces.
    pub slots: u32,
}

/// Maximum number of slots: 2^26 take half a gigabyte.
const MAX_SLOTS: u32 = 1 << 26;

impl SpatialHashParams {
    /// Returns parameters with cells of a size, and a prime number of slots.
    #[must_use]
    pub const fn new(cell_size: f64) -> Self {
        Self { cell_size, slots: 65_521 }
    }

    /// Checks that all parameters are in range.
    ///
    /// # Errors
    ///
    /// Names the first parameter out of range.
    pub fn validate(&self) -> Result<(), BaselineError> {
        let Self { cell_size, slots } = *self;
        check("slots", slots.into(), (1..=MAX_SLOTS).contains(&slots), "in 1..=2^26")?;
        let is_length = cell_size > 0.0 && cell_size.is_finite();
        check("cell size", cell_size, is_length, "a finite length above 0")
    }
}

/// Finds the faces of two surfaces that cross, and the vertices inside that follow from the
/// crossings. The crossings are exact, whatever the cells.
///
/// Vertices inside are right for closed, outward surfaces, except those of parts that cross
/// nothing.
///
/// # Errors
///
/// When a parameter is out of range, or the cells are so small that the table does not fit.
pub fn detect(
    a: PlacedSurface<'_>,
    b: PlacedSurface<'_>,
    params: &SpatialHashParams,
) -> Result<PairFindings, BaselineError> {
    params.validate()?;
    let (crossing, tests) = crossing_faces(a, b, params)?;
    Ok(PairFindings {
        overlap: !crossing.is_empty(),
        inside: Some(propagation::vertices_inside(a, b, &crossing)),
        crossing_faces: Some(crossing),
        tests,
        ..PairFindings::default()
    })
}

/// Finds the pairs of faces that cross, ascending; returns them with the number of tests.
fn crossing_faces(
    a: PlacedSurface<'_>,
    b: PlacedSurface<'_>,
    params: &SpatialHashParams,
) -> Result<(Vec<[u32; 2]>, u64), BaselineError> {
    // Only faces in the intersection of both boxes can cross.
    let shared = a.bounds().intersection(b.bounds());
    let (of_a, of_b) = (faces_in(a, shared), faces_in(b, shared));
    let grid = CellGrid::new(params.cell_size);
    grid.check_cells(&of_a)?;
    let table = CellTable::new(grid, params.slots, &of_b)?;

    // Boxes first, then the exact predicate.
    let (mut crossing, mut tests) = (Vec::new(), 0);
    for &BoxedItem { item: face, bounds } in &of_a {
        table.for_each_near(bounds, |other| {
            tests += 1;
            if bounds.overlaps(other.bounds) {
                tests += 1;
                if triangles_meet(a.corners(face), b.corners(other.item)) == Meeting::Crossing {
                    crossing.push([face, other.item]);
                }
            }
        });
    }
    crossing.sort_unstable();
    Ok((crossing, tests))
}

/// Returns the faces whose boxes overlap a box.
fn faces_in(body: PlacedSurface<'_>, region: Aabb) -> Vec<BoxedItem> {
    let mut items = Vec::new();
    for item in 0..body.face_count() {
        let bounds = body.face_bounds(item);
        if bounds.overlaps(region) {
            items.push(BoxedItem { item, bounds });
        }
    }
    items
}
