//! Spatial hash table: items by the cells of an infinite grid that their boxes cover.
//!
//! Source: M. Teschner, B. Heidelberger, M. Müller, D. Pomeranets and M. Gross, "Optimized spatial
//! hashing for collision detection of deformable objects", VMV 2003, section 3 (the hash
//! function). Here each entry keeps its cell, so that cells that share a slot stay distinct, and
//! slots are filled by a counting sort instead of lists with time stamps.

use glam::DVec3;
use surface::Aabb;

use crate::error::BaselineError;
use crate::findings::index;

/// Maximum number of entries: 2^27 take 2 gigabytes.
pub(crate) const MAX_ENTRIES: usize = 1 << 27;

/// Maximum number of a cell along an axis, far beyond any table.
const MAX_CELL: f64 = 9.0e15;

/// A cell by its integer coordinates.
pub(crate) type Cell = [i64; 3];

/// Division of space into cubes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CellGrid {
    size: f64,
}

impl CellGrid {
    pub(crate) const fn new(size: f64) -> Self {
        Self { size }
    }

    fn coordinates(self, p: DVec3) -> DVec3 {
        (p / self.size).floor()
    }

    /// Returns the cell that holds a point.
    #[expect(clippy::cast_possible_truncation, reason = "boxes are checked against MAX_CELL")]
    pub(crate) fn cell(self, p: DVec3) -> Cell {
        self.coordinates(p).to_array().map(|coordinate| coordinate as i64)
    }

    /// Returns the cells that a box covers.
    pub(crate) fn cells(self, bounds: Aabb) -> impl Iterator<Item = Cell> {
        let ([x0, y0, z0], [x1, y1, z1]) = (self.cell(bounds.min), self.cell(bounds.max));
        (x0..=x1).flat_map(move |x| (y0..=y1).flat_map(move |y| (z0..=z1).map(move |z| [x, y, z])))
    }

    /// Refuses boxes that cover more cells than a table holds, or cells that cannot be numbered.
    pub(crate) fn check_cells(self, items: &[BoxedItem]) -> Result<(), BaselineError> {
        // In floating point, which neither wraps nor ends.
        let mut cells = 0.0;
        for BoxedItem { bounds, .. } in items {
            let (min, max) = (self.coordinates(bounds.min), self.coordinates(bounds.max));
            let is_numbered = min.abs().max(max.abs()).max_element() < MAX_CELL;
            cells += if is_numbered { (max - min + 1.0).element_product() } else { f64::INFINITY };
        }

        #[expect(clippy::cast_precision_loss, reason = "a power of two")]
        let limit = MAX_ENTRIES as f64;
        if cells > limit {
            let (cell_size, limit) = (self.size, MAX_ENTRIES);
            return Err(BaselineError::TooManyCells { cell_size, cells, limit });
        }
        Ok(())
    }
}

/// An item with its bounding box.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxedItem {
    pub(crate) item: u32,
    pub(crate) bounds: Aabb,
}

/// Hash table of items by the cells that their boxes cover.
#[derive(Debug)]
pub(crate) struct CellTable<'a> {
    grid: CellGrid,
    items: &'a [BoxedItem],
    /// Offsets of the slots' entries, and the number of entries.
    offsets: Vec<usize>,
    /// Cells with their items, by their places in the list.
    entries: Vec<(Cell, u32)>,
}

impl<'a> CellTable<'a> {
    /// Builds a table with a number of slots.
    pub(crate) fn new(
        grid: CellGrid,
        slots: u32,
        items: &'a [BoxedItem],
    ) -> Result<Self, BaselineError> {
        grid.check_cells(items)?;

        // Counting sort: first the number of entries per slot, then their offsets.
        let mut offsets = vec![0; slots as usize + 1];
        for item in items {
            for cell in grid.cells(item.bounds) {
                offsets[slot_of(cell, slots) + 1] += 1;
            }
        }
        for slot in 0..slots as usize {
            offsets[slot + 1] += offsets[slot];
        }

        // Each entry goes to the next free place of its slot.
        let mut next = offsets.clone();
        let mut entries = vec![([0; 3], 0); offsets[slots as usize]];
        for (number, item) in (0..).zip(items) {
            for cell in grid.cells(item.bounds) {
                let place = &mut next[slot_of(cell, slots)];
                entries[*place] = (cell, number);
                *place += 1;
            }
        }
        Ok(Self { grid, items, offsets, entries })
    }

    /// Visits the items in cells that a box covers, each once: in the first cell common to both
    /// boxes.
    pub(crate) fn for_each_near(&self, query: Aabb, mut visit: impl FnMut(BoxedItem)) {
        for cell in self.grid.cells(query) {
            // A slot also holds the items of other cells.
            let slot = slot_of(cell, index(self.offsets.len() - 1));
            for (of, number) in &self.entries[self.offsets[slot]..self.offsets[slot + 1]] {
                let item = self.items[*number as usize];
                let first_common = || self.grid.cell(query.min.max(item.bounds.min));
                if *of == cell && first_common() == cell {
                    visit(item);
                }
            }
        }
    }
}

/// Computes the paper's hash function, of three large primes.
fn slot_of([x, y, z]: Cell, slots: u32) -> usize {
    let hash = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    let slot = hash.cast_unsigned() % u64::from(slots);
    usize::try_from(slot).unwrap_or(0)
}
