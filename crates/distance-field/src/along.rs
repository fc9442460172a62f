//! The lowest value on a straight way.
//!
//! Within a cell a trilinear value changes along a line as a cubic, whose lowest
//! point has a closed form. So the cells that a way goes through are visited one
//! after the other, and most are left after a look at their corners, between
//! which every value lies.
//!
//! Source: J. Amanatides and A. Woo, "A fast voxel traversal algorithm for ray
//! tracing", Eurographics 1987, for the order of the cells.

use glam::DVec3;

use crate::field::DistanceField;
use crate::frame::Frame;
use crate::store::{Nodes, Store};

/// Where on a way a field is lowest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentMinimum {
    /// Place along the segment, from 0 at its start to 1 at its end.
    pub t: f64,
    /// The trilinear value there, in the length unit.
    pub distance: f64,
}

impl DistanceField {
    /// The lowest trilinear value on the straight way between two points of the
    /// field's own frame, found in closed form; the first where several are equally
    /// low. None where no value is as low as `at_most`, and none of what is outside
    /// the grid.
    ///
    /// ```
    /// use distance_field::{DistanceField, FieldGrid, Storage};
    /// use glam::DVec3;
    ///
    /// // A value that is 2 at the ends of the cell's diagonal, and 9 / 8 in its middle.
    /// let grid = FieldGrid::new(DVec3::ZERO, 1.0, [2, 2, 2])?;
    /// let values = vec![2.0, 1.0, 1.0, 0.5, 0.5, 1.0, 1.0, 2.0];
    /// let field = DistanceField::from_values(grid, values, Storage::Float)?;
    /// let lowest = field.min_along_segment([DVec3::ZERO, DVec3::ONE], 1.5).expect("it is below 1.5");
    /// assert!(lowest.distance < 1.13 && (0.4..0.6).contains(&lowest.t));
    /// assert_eq!(field.min_along_segment([DVec3::ZERO, DVec3::ONE], 0.5), None);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn min_along_segment(&self, ends: [DVec3; 2], at_most: f64) -> Option<SegmentMinimum> {
        let frame = &self.frame;
        match &self.store {
            Store::Floats(nodes) => lowest(nodes, frame, ends, at_most),
            Store::Steps(nodes) => lowest(nodes, frame, ends, at_most),
        }
    }
}

fn lowest<N: Nodes>(
    nodes: &N,
    frame: &Frame,
    ends: [DVec3; 2],
    at_most: f64,
) -> Option<SegmentMinimum> {
    let [a, b] = ends.map(|end| frame.units(end));
    let [mut from, to] = clip([a, b], frame.last())?;
    let mut way = Way::new([a, b], frame.cell(a.lerp(b, from)));
    let step = nodes.step();
    let mut best: Option<SegmentMinimum> = None;
    loop {
        let exit = way.exit();
        let upto = exit.share.min(to);
        let corners = nodes.cell(way.cell).map(|plane| plane.map(|value| step * value.into()));
        let bound = best.map_or(at_most, |lowest| lowest.distance);
        if corners.iter().flatten().any(|&corner| corner <= bound) {
            let [enter, leave] = [from, upto].map(|share| a.lerp(b, share) - way.cell);
            let (place, distance) = Cubic::between(corners, enter, leave - enter).lowest();
            if distance < bound || (best.is_none() && distance <= bound) {
                best = Some(SegmentMinimum { t: from + place * (upto - from), distance });
            }
        }
        way.cross(&exit);
        // Rounding may carry the way out of the last cell before its end.
        if upto >= to || !frame.has_cell(way.cell) {
            return best;
        }
        from = upto;
    }
}

/// From where to where, in shares, a way is between 0 and `last`.
fn clip([a, b]: [DVec3; 2], last: DVec3) -> Option<[f64; 2]> {
    let along = b - a;
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..3 {
        let [lo, hi] = [0.0, last[axis]].map(|side| side - a[axis]);
        if along[axis] == 0.0 {
            if lo > 0.0 || hi < 0.0 {
                return None;
            }
            continue;
        }
        let [s, t] = [lo / along[axis], hi / along[axis]];
        (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
    }
    (from <= to && a.is_finite() && b.is_finite()).then_some([from, to])
}

/// A straight way in units of the grid, in one of its cells.
struct Way {
    start: DVec3,
    along: DVec3,
    cell: DVec3,
}

/// Where a way leaves a cell: the share of it, and the axis it crosses along.
struct Exit {
    share: f64,
    axis: usize,
}

impl Way {
    fn new([start, end]: [DVec3; 2], cell: DVec3) -> Self {
        Self { start, along: end - start, cell }
    }

    fn exit(&self) -> Exit {
        let exit = |axis: usize| {
            let side = self.cell[axis] + if self.along[axis] > 0.0 { 1.0 } else { 0.0 };
            let is_still = self.along[axis] == 0.0;
            let share = (side - self.start[axis]) / self.along[axis];
            Exit { share: if is_still { f64::INFINITY } else { share }, axis }
        };
        let [x, y, z] = [exit(0), exit(1), exit(2)];
        let first = if y.share < x.share { y } else { x };
        if z.share < first.share { z } else { first }
    }

    fn cross(&mut self, exit: &Exit) {
        self.cell[exit.axis] += self.along[exit.axis].signum();
    }
}

/// `c0 + c1 t + c2 t² + c3 t³` for `t` in `0.0..=1.0`.
struct Cubic([f64; 4]);

impl Cubic {
    /// Trilinear values of a cell with these corners from a place in it along a way.
    fn between([low, high]: [[f64; 4]; 2], enter: DVec3, along: DVec3) -> Self {
        // Along x these are linear; two such over y are quadratic, two of these over z cubic.
        let edge = |a: f64, b: f64| [a + (b - a) * enter.x, (b - a) * along.x];
        let face = |[a, b, c, d]: [f64; 4]| {
            let ([p0, p1], [q0, q1]) = (edge(a, b), edge(c, d));
            let [d0, d1] = [q0 - p0, q1 - p1];
            [p0 + d0 * enter.y, p1 + d1 * enter.y + d0 * along.y, d1 * along.y]
        };
        let (p, q) = (face(low), face(high));
        let [d0, d1, d2] = [q[0] - p[0], q[1] - p[1], q[2] - p[2]];
        Self([
            p[0] + d0 * enter.z,
            p[1] + d1 * enter.z + d0 * along.z,
            p[2] + d2 * enter.z + d1 * along.z,
            d2 * along.z,
        ])
    }

    fn at(&self, t: f64) -> f64 {
        let [c0, c1, c2, c3] = self.0;
        ((c3 * t + c2) * t + c1) * t + c0
    }

    /// Where it is lowest, and how low.
    fn lowest(&self) -> (f64, f64) {
        let [_, c1, c2, c3] = self.0;
        // Of the two places where the slope is 0, the one where it rises:
        // (-c2 + root) / 3 c3, by the form that does not cancel.
        let root = (c2 * c2 - 3.0 * c1 * c3).max(0.0).sqrt();
        let valley = if c2 > 0.0 { -c1 / (c2 + root) } else { (root - c2) / (3.0 * c3) };
        let inner = if valley > 0.0 && valley < 1.0 { valley } else { 0.0 };
        let candidates = [0.0, inner, 1.0].map(|t| (t, self.at(t)));
        let [first, middle, last] = candidates;
        let best = if middle.1 < first.1 { middle } else { first };
        if last.1 < best.1 { last } else { best }
    }
}
