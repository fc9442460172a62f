//! A hash table of cells: what is where in a grid that is not stored.
//!
//! Source: M. Teschner, B. Heidelberger, M. Müller, D. Pomeranets and M. Gross,
//! "Optimized spatial hashing for collision detection of deformable objects",
//! VMV 2003, section 3 (the hash function). Here each entry keeps its cell, so
//! that two cells that share a slot are told apart, and slots are filled by a
//! counting sort instead of lists with time stamps.

use glam::DVec3;

use crate::boxes::Bounds;
use crate::error::BaselineError;

/// Entries that a table may have: 2^27 take 2 gigabytes.
pub(crate) const MOST_ENTRIES: usize = 1 << 27;

/// A cell by its place along each axis.
pub(crate) type Cell = [i64; 3];

/// Cells are numbered up to this along an axis, far beyond what any table holds.
const FARTHEST: f64 = 9.0e15;

/// A division of space into cubes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Grid {
    size: f64,
}

/// Items by the cells that their boxes reach into.
#[derive(Debug)]
pub(crate) struct CellTable {
    grid: Grid,
    /// Where the entries of each slot start, and one more.
    starts: Vec<usize>,
    entries: Vec<(Cell, u32)>,
}

impl Grid {
    pub(crate) fn new(size: f64) -> Result<Self, BaselineError> {
        if size > 0.0 && size.is_finite() {
            Ok(Self { size })
        } else {
            Err(BaselineError::CellSize(size))
        }
    }

    fn place(self, p: DVec3) -> DVec3 {
        (p / self.size).floor()
    }

    /// The cell that holds a point.
    #[expect(clippy::cast_possible_truncation, reason = "places are checked against FARTHEST")]
    pub(crate) fn cell(self, p: DVec3) -> Cell {
        self.place(p).to_array().map(|place| place as i64)
    }

    /// The cells that a box reaches into.
    pub(crate) fn cells(self, bounds: Bounds) -> impl Iterator<Item = Cell> {
        let ([x0, y0, z0], [x1, y1, z1]) = (self.cell(bounds.low), self.cell(bounds.high));
        (x0..=x1).flat_map(move |x| (y0..=y1).flat_map(move |y| (z0..=z1).map(move |z| [x, y, z])))
    }

    /// Refuses boxes that reach into more cells than a table can hold, or into
    /// cells that cannot be numbered.
    pub(crate) fn check(self, boxes: impl Iterator<Item = Bounds>) -> Result<usize, BaselineError> {
        let mut cells = 0.0;
        for bounds in boxes {
            let (low, high) = (self.place(bounds.low), self.place(bounds.high));
            let numbered = low.abs().max(high.abs()).max_element() < FARTHEST;
            cells += if numbered { (high - low + 1.0).element_product() } else { f64::INFINITY };
        }
        #[expect(clippy::cast_precision_loss, reason = "a power of two")]
        let limit = MOST_ENTRIES as f64;
        if cells > limit {
            return Err(BaselineError::TooManyCells {
                cell_size: self.size,
                cells,
                limit: MOST_ENTRIES,
            });
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a count below the limit"
        )]
        let count = cells as usize;
        Ok(count)
    }
}

impl CellTable {
    /// Enters items, each with its box, into a table with this many slots.
    pub(crate) fn new(
        grid: Grid,
        slots: u32,
        items: &[(u32, Bounds)],
    ) -> Result<Self, BaselineError> {
        let count = grid.check(items.iter().map(|item| item.1))?;
        let all =
            || items.iter().flat_map(|&(item, b)| grid.cells(b).map(move |cell| (cell, item)));
        let mut starts = vec![0; slots as usize + 1];
        for (cell, _) in all() {
            starts[slot_of(cell, slots) + 1] += 1;
        }
        for slot in 0..slots as usize {
            starts[slot + 1] += starts[slot];
        }
        let mut next = starts.clone();
        let mut entries = vec![([0; 3], 0); count];
        for (cell, item) in all() {
            let place = &mut next[slot_of(cell, slots)];
            entries[*place] = (cell, item);
            *place += 1;
        }
        Ok(Self { grid, starts, entries })
    }

    /// The items of a cell, in the order in which they were given.
    pub(crate) fn items(&self, cell: Cell) -> impl Iterator<Item = u32> {
        let slots = crate::findings::index(self.starts.len() - 1);
        let slot = slot_of(cell, slots);
        let entries = &self.entries[self.starts[slot]..self.starts[slot + 1]];
        entries.iter().filter(move |(of, _)| *of == cell).map(|(_, item)| *item)
    }

    /// Visits each item in a cell that a box reaches into, once in the first
    /// cell common to both boxes. `bounds` gives the box of an item.
    pub(crate) fn near(
        &self,
        query: Bounds,
        bounds: impl Fn(u32) -> Bounds,
        mut visit: impl FnMut(u32),
    ) {
        for cell in self.grid.cells(query) {
            for item in self.items(cell) {
                let first_of_both = self.grid.cell(query.low.max(bounds(item).low));
                if first_of_both == cell {
                    visit(item);
                }
            }
        }
    }
}

/// The paper's hash function, of three large primes.
fn slot_of([x, y, z]: Cell, slots: u32) -> usize {
    let hash = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    let slot = hash.cast_unsigned() % u64::from(slots);
    usize::try_from(slot).unwrap_or(0)
}
