//! Sides of a region, which cut rows of nodes off.

use glam::DVec3;

/// Distance by which a region is widened so that rounding loses no node \[spacings\].
///
/// Above the rounding of a plane through a sliver (1e-8 times a few spacings), far below
/// storage precision at the size of a bone (3e-5).
pub(super) const WIDENING: f64 = 1e-6;

/// Neighboring rows that are clipped together.
pub(super) const ROWS: usize = 4;
const ROW_NUMBERS: [f64; ROWS] = [0.0, 1.0, 2.0, 3.0];

/// Stands for 1 / 0: takes a row on the wrong side of a plane along x out of the grid, and
/// leaves any other alone.
const VERTICAL: f64 = 1e30;

/// Plane that bounds a region, as the end of a row: `x = at + per_y · y + per_z · z`.
struct Side {
    at: f64,
    per_y: f64,
    per_z: f64,
}

/// Planes that bound a region, by the end of a row that they cut off.
#[derive(Default)]
pub(super) struct Sides {
    lower: Vec<Side>,
    upper: Vec<Side>,
}

impl Sides {
    pub(super) fn clear(&mut self) {
        self.lower.clear();
        self.upper.clear();
    }

    /// Adds the plane through `at` with the given inward normal, of any length, moved out by
    /// [`WIDENING`] to twice that. A zero normal cuts nothing off.
    #[inline]
    pub(super) fn add(&mut self, normal: DVec3, at: DVec3) {
        self.add_shifted(normal, at, WIDENING * normal.abs().element_sum());
    }

    /// Adds the plane through `at`, moved out by `shift` times the normal's length.
    #[inline]
    pub(super) fn add_shifted(&mut self, normal: DVec3, at: DVec3, shift: f64) {
        let slope = if normal.x == 0.0 { -VERTICAL } else { -1.0 / normal.x };
        let offset = shift - normal.dot(at);
        let side = Side { at: offset * slope, per_y: normal.y * slope, per_z: normal.z * slope };
        if normal.x < 0.0 { self.upper.push(side) } else { self.lower.push(side) }
    }

    /// Clips neighboring rows at `z`, the first of which is at `y`, given by their ends; empty are
    /// those whose first end is after the second.
    #[inline]
    pub(super) fn clip(&self, ends: [f64; 2], y: f64, z: f64) -> [[f64; ROWS]; 2] {
        // Compared so that NaN cuts nothing off; all rows at once, without a branch.
        let [mut from, mut to] = ends.map(|end| [end; ROWS]);
        for side in &self.lower {
            let x = side.rows(y, z);
            for (from, x) in from.iter_mut().zip(x) {
                *from = if x > *from { x } else { *from };
            }
        }
        for side in &self.upper {
            let x = side.rows(y, z);
            for (to, x) in to.iter_mut().zip(x) {
                *to = if x < *to { x } else { *to };
            }
        }
        [from, to]
    }
}

impl Side {
    /// Returns where neighboring rows end.
    #[inline]
    fn rows(&self, y: f64, z: f64) -> [f64; ROWS] {
        let first = self.at + self.per_y * y + self.per_z * z;
        std::array::from_fn(|row| first + self.per_y * ROW_NUMBERS[row])
    }
}
