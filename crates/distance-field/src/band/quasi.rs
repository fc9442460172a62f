//! Quasi-interpolation prefilter: node values between which linear interpolation is right on
//! average.
//!
//! Between exact values, linear interpolation errs to one side: over a convex part of a
//! surface each straight piece lies above the distance that it stands for, by a twelfth of
//! the second difference on average along each axis. Here every node subtracts that. The
//! interpolant is then too high at the nodes and too low between them, and right on average:
//! the error of a curvature falls to two fifths.
//!
//! A correction is bounded, by [`MAX_CORRECTION`] and by half of the value itself, so that no
//! node changes its sign. Only nodes whose neighbors are exact change: not those next to
//! truncated values or beyond the band, nor those on the border.
//!
//! Source: L. Condat, T. Blu and M. Unser, "Beyond interpolation: optimal reconstruction by
//! quasi-interpolation", IEEE International Conference on Image Processing, 2005, for the
//! filter of linear splines. Differs in taking its terms axis by axis, which reads 7 nodes
//! rather than 27, and in its bounds.

use surface::parallel;
use surface::progress::Progress;

use crate::num::single;
use crate::{FieldError, FieldGrid};

/// Maximum correction of a node \[spacings\]: that of a fold of 100°.
pub(crate) const MAX_CORRECTION: f64 = 0.125;

/// Maximum number of planes per task, each of which copies the planes beside its own.
const SLAB: usize = 32;

/// Nodes of a row that are compared with the limit together. Fewer take a branch more often; of more, some are within
/// the limit more often.
const RUN: usize = 16;

/// Replaces signed distances by the coefficients of a quasi-interpolation, where they and all
/// their neighbors are below `limit`; elsewhere they stay as they are.
///
/// In place, so that no second grid has to come from the system, page by page.
pub(crate) fn quasi_interpolate(
    values: &mut [f32],
    grid: &FieldGrid,
    limit: f32,
    progress: Progress<'_>,
) -> Result<(), FieldError> {
    let [nx, ny, nz] = grid.dims();
    let (plane, max) = (nx * ny, single(MAX_CORRECTION * grid.spacing()));

    // Each slab needs the distances in the planes beside it, which are other slabs'.
    let mut beside = Vec::new();
    for first in (0..nz).step_by(SLAB) {
        let copy = |k: usize| values.get(k * plane..(k + 1) * plane).unwrap_or(&[]).to_vec();
        let below = if first > 0 { copy(first - 1) } else { Vec::new() };
        beside.push([below, copy(first + SLAB)]);
    }

    let mut slabs: Vec<_> = values.chunks_mut(SLAB * plane).zip(beside).collect();
    let steps = progress.steps(nz);
    parallel::try_for_each_mut(&mut slabs, |_, (values, [below, above])| {
        let mut filter = Filter { nx, max, limit, below: std::mem::take(below), here: Vec::new() };
        for k in 0..values.len() / plane {
            steps.advance(1)?;
            let (own, rest) = values[k * plane..].split_at_mut(plane);
            let above = rest.get(..plane).unwrap_or(above);
            filter.plane(own, above);
        }
        Ok::<(), FieldError>(())
    })
}

/// Correction of nodes by their second differences, plane by plane.
struct Filter {
    /// Nodes per row.
    nx: usize,
    /// Maximum correction, in the length unit.
    max: f32,
    limit: f32,
    /// Distances in the plane below, empty for none, and in the plane itself.
    below: Vec<f32>,
    here: Vec<f32>,
}

impl Filter {
    /// Replaces a plane's distances, but for its border, given those in the plane above, empty
    /// for none.
    fn plane(&mut self, plane: &mut [f32], above: &[f32]) {
        self.here.clear();
        self.here.extend_from_slice(plane);
        if !self.below.is_empty() && !above.is_empty() {
            for start in (self.nx..plane.len() - self.nx).step_by(self.nx) {
                self.row(start + 1, above, &mut plane[start + 1..start + self.nx - 1]);
            }
        }
        std::mem::swap(&mut self.below, &mut self.here);
    }

    /// Writes the coefficients of nodes in a row, the first of which is given. Nodes beyond the limit stay as they
    /// are, which most runs of them are as a whole.
    #[inline]
    fn row(&self, first: usize, above: &[f32], out: &mut [f32]) {
        for (start, out) in (first..).step_by(RUN).zip(out.chunks_mut(RUN)) {
            let mut is_any_near = false;
            for value in &*out {
                is_any_near |= value.abs() < self.limit;
            }
            if is_any_near {
                self.run(start, above, out);
            }
        }
    }

    /// Writes the coefficients of nodes that follow each other in a row, the first of which is given.
    ///
    /// Seven runs of one length: no bound is checked within the loop, which vectorizes.
    #[inline]
    fn run(&self, first: usize, above: &[f32], out: &mut [f32]) {
        let count = out.len();
        let here = &self.here[first..][..count];
        let (west, east) = (&self.here[first - 1..][..count], &self.here[first + 1..][..count]);
        let south = &self.here[first - self.nx..][..count];
        let north = &self.here[first + self.nx..][..count];
        let (below, above) = (&self.below[first..][..count], &above[first..][..count]);
        for (i, out) in out.iter_mut().enumerate() {
            let beside = [west[i], east[i], south[i], north[i], below[i], above[i]];
            *out = self.value(here[i], beside);
        }
    }

    /// Filters a value. Selections without a branch, which vectorize.
    #[inline]
    fn value(&self, value: f32, [west, east, south, north, below, above]: [f32; 6]) -> f32 {
        let bend = (west + east) + (south + north) + (below + above) - 6.0 * value;
        let allowed = min(self.max, 0.5 * value.abs());
        let correction = max(min(bend / 12.0, allowed), -allowed);
        let others = [east, south, north, below, above, value];
        let largest =
            others.into_iter().fold(west.abs(), |largest, value| max(largest, value.abs()));
        // Not beyond what may be truncated.
        let corrected = max(min(value - correction, self.limit), -self.limit);
        if largest < self.limit { corrected } else { value }
    }
}

#[inline]
fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline]
fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::coordinate;
    use crate::{DistanceField, Interpolation, Storage};
    use fixtures::generate::cases;
    use glam::DVec3;

    fn grid(dims: [usize; 3]) -> FieldGrid {
        FieldGrid::new(DVec3::ZERO, 1.0, dims).expect("a small grid")
    }

    fn place(node: usize, dims: [usize; 3]) -> [usize; 3] {
        [node % dims[0], node / dims[0] % dims[1], node / (dims[0] * dims[1])]
    }

    /// Reference implementation: one node from all nodes as they were.
    fn reference(values: &[f32], dims: [usize; 3], node: [usize; 3], limit: f32) -> f32 {
        let at = |[i, j, k]: [usize; 3]| values[i + dims[0] * (j + dims[1] * k)];
        let here = at(node);
        if (0..3).any(|axis| node[axis] == 0 || node[axis] + 1 == dims[axis]) {
            return here;
        }
        let beside = |axis: usize, up: usize| {
            let mut other = node;
            other[axis] = other[axis] + 2 * up - 1;
            at(other)
        };
        let pairs = [0, 1, 2].map(|axis| [beside(axis, 0), beside(axis, 1)]);
        if pairs.as_flattened().iter().chain([&here]).any(|value| value.abs() >= limit) {
            return here;
        }
        let bend: f32 = pairs.iter().map(|[a, b]| a + b).sum::<f32>() - 6.0 * here;
        let allowed = single(MAX_CORRECTION).min(0.5 * here.abs());
        (here - (bend / 12.0).clamp(-allowed, allowed)).clamp(-limit, limit)
    }

    /// On grids of few planes and of many, and without interior nodes.
    #[test]
    fn nodes_are_corrected_by_their_neighbors() {
        cases(1, 200, |u| {
            let nx = [2, 3, 5, 9, RUN + 2, RUN + 3, 2 * RUN + 7][u.choose_index(7)?];
            let dims = [nx, u.int_in_range(2..=6)?, u.int_in_range(2..=70)?];
            let limit = 2.0;
            // Mostly bent a little, some across the surface, some truncated.
            let value = |_| Ok(f32::from(u.int_in_range(-36..=100_i8)?.clamp(-20, 20)) / 10.0);
            let before: Result<Vec<f32>, _> = (0..dims.iter().product()).map(value).collect();
            let before = before?;

            let mut after = before.clone();
            quasi_interpolate(&mut after, &grid(dims), limit, Progress::none()).unwrap();
            for (n, value) in after.iter().enumerate() {
                let node = place(n, dims);
                let expected = reference(&before, dims, node, limit);
                assert!((value - expected).abs() < 1e-6, "{node:?} of {dims:?}");
                assert_eq!(value.is_sign_negative(), before[n].is_sign_negative(), "{node:?}");
                assert!((value - before[n]).abs() <= single(MAX_CORRECTION) + 1e-6, "{node:?}");
            }
            Ok(())
        });
    }

    /// Over a paraboloid, the mean error of linear interpolation vanishes.
    #[test]
    fn squares_are_right_on_average() {
        let dims = [8, 7, 9];
        let height = |p: DVec3| 20.0 + (p * p).dot(DVec3::new(1.0, -0.5, 2.0)) / 40.0;
        let position = |node: usize| DVec3::from_array(place(node, dims).map(coordinate));
        let heights = (0..dims.iter().product()).map(|node| single(height(position(node))));
        let mut values: Vec<f32> = heights.collect();
        let mean_error = |values: &[f32]| {
            let field = DistanceField::from_values(grid(dims), values.to_vec(), Storage::Float);
            let field = field.expect("finite values");
            // The middles of 4³ parts of an inner cell.
            let parts = (0..64).map(|part| [part % 4, part / 4 % 4, part / 16]);
            let error = |part: [usize; 3]| {
                let local = DVec3::from_array(part.map(coordinate)) / 4.0 + 0.125;
                let p = DVec3::new(3.0, 2.0, 4.0) + local;
                field.evaluate(p, Interpolation::Trilinear).expect("inside").distance - height(p)
            };
            parts.map(error).sum::<f64>() / 64.0
        };

        let before = mean_error(&values);
        quasi_interpolate(&mut values, &grid(dims), 100.0, Progress::none()).unwrap();
        let after = mean_error(&values);
        // Over the middles of quarters, the mean of x (1 - x) is 5 / 32 rather than 1 / 6.
        assert!(before > 0.009 && after.abs() < 0.07 * before, "{before} {after}");
    }
}
