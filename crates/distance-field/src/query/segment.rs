//! Minimum of a field along a segment.
//!
//! Within a cell, a trilinear value is a cubic along a line, whose minimum has a closed
//! form. So the cells of a segment are visited one after the other, and most are skipped by
//! their corners, between which every value lies.
//!
//! Source: J. Amanatides and A. Woo, "A fast voxel traversal algorithm for ray tracing",
//! Eurographics 1987, for the order of the cells.

use glam::DVec3;

use crate::DistanceField;
use crate::frame::Frame;
use crate::store::{Corners, NodeArray, NodeStore};

/// Point of a segment at which a field is minimal.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SegmentMinimum {
    /// Place along the segment, from 0 at its start to 1 at its end.
    pub t: f64,
    /// Trilinear value there, in the length unit.
    pub distance: f64,
}

impl DistanceField {
    /// Computes the minimum of the trilinear value on the segment between two points of the
    /// field's own frame, in closed form; the first where several are equal.
    ///
    /// Returns `None` where all values exceed `max_distance`. The part of the segment outside
    /// the grid is ignored.
    ///
    /// ```
    /// use distance_field::{DistanceField, FieldGrid, Storage};
    /// use glam::DVec3;
    ///
    /// // A value that is 2 at the ends of the cell's diagonal, and 9 / 8 in its middle.
    /// let grid = FieldGrid::new(DVec3::ZERO, 1.0, [2, 2, 2])?;
    /// let values = vec![2.0, 1.0, 1.0, 0.5, 0.5, 1.0, 1.0, 2.0];
    /// let field = DistanceField::from_values(grid, values, Storage::Float)?;
    ///
    /// let minimum = field.min_along_segment([DVec3::ZERO, DVec3::ONE], 1.5).expect("below 1.5");
    /// assert!(minimum.distance < 1.13 && (0.4..0.6).contains(&minimum.t));
    /// assert_eq!(field.min_along_segment([DVec3::ZERO, DVec3::ONE], 0.5), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn min_along_segment(&self, ends: [DVec3; 2], max_distance: f64) -> Option<SegmentMinimum> {
        let frame = &self.frame;
        match &self.store {
            NodeStore::Floats(nodes) => minimum(nodes, frame, ends, max_distance),
            NodeStore::Steps(nodes) => minimum(nodes, frame, ends, max_distance),
        }
    }
}

fn minimum<T: Copy + Into<f64>>(
    nodes: &NodeArray<T>,
    frame: &Frame,
    [a, b]: [DVec3; 2],
    max_distance: f64,
) -> Option<SegmentMinimum> {
    let (a, b) = (frame.grid_coordinates(a), frame.grid_coordinates(b));
    let [mut from, last] = clip([a, b], frame.last())?;
    let mut walk = CellWalk { start: a, along: b - a, cell: frame.nearest_cell(a.lerp(b, from)) };
    let mut best: Option<SegmentMinimum> = None;

    loop {
        let exit = walk.exit();
        let to = exit.t.min(last);

        // No value of a cell is below that of all its corners: most cells end here.
        let corners = nodes.corner_lengths(walk.cell);
        let limit = best.map_or(max_distance, |best| best.distance);
        if has_at_most(&corners, limit) {
            // On a long segment, rounding may carry both out of the cell.
            let enter = (a.lerp(b, from) - walk.cell).clamp(DVec3::ZERO, DVec3::ONE);
            let leave = (a.lerp(b, to) - walk.cell).clamp(DVec3::ZERO, DVec3::ONE);
            let (t, distance) = Cubic::along(corners, enter, leave - enter).minimum();
            if distance < limit || (best.is_none() && distance <= limit) {
                best = Some(SegmentMinimum { t: from + t * (to - from), distance });
            }
        }

        // Rounding may carry the walk out of the last cell before its end.
        walk.cross(&exit);
        if to >= last || !frame.has_cell(walk.cell) {
            return best;
        }
        from = to;
    }
}

/// Returns true if a value is at most `limit`.
#[inline]
fn has_at_most(corners: &Corners<f64>, limit: f64) -> bool {
    corners.as_flattened().iter().any(|&corner| corner <= limit)
}

/// Returns the part of a segment whose coordinates are between 0 and `last`.
fn clip([a, b]: [DVec3; 2], last: DVec3) -> Option<[f64; 2]> {
    let along = b - a;
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..3 {
        let (lower, upper) = (0.0 - a[axis], last[axis] - a[axis]);
        if along[axis] == 0.0 {
            if lower > 0.0 || upper < 0.0 {
                return None;
            }
            continue;
        }

        // The segment may run either way between the two sides.
        let (s, t) = (lower / along[axis], upper / along[axis]);
        (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
    }
    (from <= to && a.is_finite() && b.is_finite()).then_some([from, to])
}

/// Walk along a line from cell to cell, in units of the grid.
struct CellWalk {
    start: DVec3,
    along: DVec3,
    cell: DVec3,
}

/// Point at which a line leaves a cell.
struct CellExit {
    t: f64,
    /// Axis across which it leaves.
    axis: usize,
}

impl CellWalk {
    fn exit(&self) -> CellExit {
        let (x, y, z) = (self.exit_across(0), self.exit_across(1), self.exit_across(2));
        let first = if y.t < x.t { y } else { x };
        if z.t < first.t { z } else { first }
    }

    #[inline]
    fn exit_across(&self, axis: usize) -> CellExit {
        if self.along[axis] == 0.0 {
            return CellExit { t: f64::INFINITY, axis };
        }
        let side = self.cell[axis] + if self.along[axis] > 0.0 { 1.0 } else { 0.0 };
        CellExit { t: (side - self.start[axis]) / self.along[axis], axis }
    }

    fn cross(&mut self, exit: &CellExit) {
        self.cell[exit.axis] += self.along[exit.axis].signum();
    }
}

/// Cubic polynomial over `0.0..=1.0`, by its coefficients of ascending powers.
struct Cubic([f64; 4]);

impl Cubic {
    /// Returns the trilinear value of a cell along a line from a point in it.
    fn along([low, high]: Corners<f64>, enter: DVec3, along: DVec3) -> Self {
        // Linear along x; products of two over y are quadratic, and of these over z cubic.
        let (p, q) = (quadratic(low, enter, along), quadratic(high, enter, along));
        let [d0, d1, d2] = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
        Self([
            p[0] + d0 * enter.z,
            p[1] + d1 * enter.z + d0 * along.z,
            p[2] + d2 * enter.z + d1 * along.z,
            d2 * along.z,
        ])
    }

    #[inline]
    fn at(&self, t: f64) -> f64 {
        let [c0, c1, c2, c3] = self.0;
        ((c3 * t + c2) * t + c1) * t + c0
    }

    /// Returns the place of the minimum and its value.
    fn minimum(&self) -> (f64, f64) {
        let [_, c1, c2, c3] = self.0;

        // Of the two roots of the derivative the one where it rises,
        // (-c2 + root) / 3 c3, in the form that does not cancel.
        let root = (c2 * c2 - 3.0 * c1 * c3).max(0.0).sqrt();
        let valley = if c2 > 0.0 { -c1 / (c2 + root) } else { (root - c2) / (3.0 * c3) };
        let inner = if valley > 0.0 && valley < 1.0 { valley } else { 0.0 };

        // The first of equal minima.
        let (mut best, mut lowest) = (0.0, self.at(0.0));
        for t in [inner, 1.0] {
            let value = self.at(t);
            if value < lowest {
                (best, lowest) = (t, value);
            }
        }
        (best, lowest)
    }
}

/// Returns the coefficients of a bilinear value along a line, given those at the corners of
/// a cell's face across z.
#[inline]
fn quadratic([a, b, c, d]: [f64; 4], enter: DVec3, along: DVec3) -> [f64; 3] {
    let [p0, p1] = [a + (b - a) * enter.x, (b - a) * along.x];
    let [q0, q1] = [c + (d - c) * enter.x, (d - c) * along.x];
    let [d0, d1] = [q0 - p0, q1 - p1];
    [p0 + d0 * enter.y, p1 + d1 * enter.y + d0 * along.y, d1 * along.y]
}
