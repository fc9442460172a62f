//! Nodes that give way to what lies between them.
//!
//! Between exact values, linear interpolation errs to one side: over a convex part
//! of a surface each straight piece lies above the distance that it stands for, by a
//! twelfth of the second difference on average along each axis. Here every node
//! takes that off. What is then interpolated is too high at the nodes and too low
//! between them, and right on average: a curvature's error falls to two fifths.
//!
//! What is taken off is bounded, by [`MOST`] and by half of the value itself, so
//! that no node changes its side. Only nodes whose neighbours are exact change: not
//! those that touch what is truncated or lies beyond the band, nor those on the
//! border.
//!
//! Source: L. Condat, T. Blu and M. Unser, "Beyond interpolation: optimal
//! reconstruction by quasi-interpolation", IEEE International Conference on Image
//! Processing, 2005, for the filter of linear splines. Differs in taking its terms
//! axis by axis, which reads 7 nodes rather than 27, and in its bounds.

use crate::grid::FieldGrid;
use crate::num::single;
use crate::par;

/// Most that a node gives way \[spacings\]: what a fold of 100° asks for.
pub(crate) const MOST: f64 = 0.125;

/// Planes of nodes that are worked on together.
const SLAB: usize = 32;

/// Replaces signed distances by the values of a quasi-interpolation, where they and all
/// that it needs are nearer than `limit`.
pub(crate) fn quasi_interpolate(values: &mut [f32], grid: &FieldGrid, limit: f32) {
    let [nx, ny, _] = grid.dims();
    let plane = nx * ny;
    let row = Row { nx, most: single(MOST * grid.spacing()), limit };
    let borders = borders(values, plane);
    par::for_each(values.chunks_mut(plane * SLAB).collect(), |s, slab| {
        let below = s.checked_sub(1).map(|s| &borders[s][..plane]);
        let above = borders.get(s).map(|planes| &planes[plane..]);
        row.in_slab(slab, ny, [below, above]);
    });
}

/// The last plane of each slab but the last and the plane above it, before any
/// changes.
fn borders(values: &[f32], plane: usize) -> Vec<Vec<f32>> {
    let slabs = (values.len() / plane).div_ceil(SLAB);
    par::map(slabs.saturating_sub(1), |s| {
        let above = (s + 1) * SLAB * plane;
        values[above - plane..above + plane].to_vec()
    })
}

/// What the nodes of a row are changed by.
#[derive(Clone, Copy)]
struct Row {
    nx: usize,
    most: f32,
    limit: f32,
}

impl Row {
    /// Changes the planes of a slab in turn, keeping what the one and the one below it
    /// were; `below` and `above` are the planes beside the slab.
    fn in_slab(self, slab: &mut [f32], ny: usize, [below, above]: [Option<&[f32]>; 2]) {
        let plane = self.nx * ny;
        let mut was_below = below.map_or_else(Vec::new, <[f32]>::to_vec);
        let mut was = vec![0.0; plane];
        let mut rest = slab;
        while !rest.is_empty() {
            let (here, higher) = rest.split_at_mut(plane);
            was.copy_from_slice(here);
            let next = if higher.is_empty() { above } else { Some(&higher[..plane]) };
            if let Some(next) = next.filter(|_| !was_below.is_empty()) {
                self.in_plane(here, [&was_below, &was, next]);
            }
            was_below.resize(plane, 0.0);
            std::mem::swap(&mut was_below, &mut was);
            rest = higher;
        }
    }

    /// Changes the rows of a plane but for its first and last; the planes below, of it
    /// and above are as they were.
    fn in_plane(self, out: &mut [f32], [below, was, above]: [&[f32]; 3]) {
        let nx = self.nx;
        for start in (nx..out.len() - nx).step_by(nx) {
            let row = start..start + nx;
            let [south, north] = [&was[start - nx..start], &was[row.end..row.end + nx]];
            let [below, above] = [below, above].map(|plane| &plane[row.clone()]);
            self.change(&mut out[row.clone()], &was[row], [south, north, below, above]);
        }
    }

    /// Changes a row but for its ends.
    #[inline]
    fn change(self, out: &mut [f32], was: &[f32], [south, north, below, above]: [&[f32]; 4]) {
        let inner = 1..self.nx - 1;
        let lists = was[..self.nx - 2].iter().zip(&was[2..]).zip(&was[inner.clone()]);
        let across = south[inner.clone()].iter().zip(&north[inner.clone()]);
        let upward = below[inner.clone()].iter().zip(&above[inner.clone()]);
        let all = lists.zip(across).zip(upward);
        for (out, ((((west, east), value), (south, north)), (below, above))) in
            out[inner].iter_mut().zip(all)
        {
            *out = self.value(*value, [*west, *east, *south, *north, *below, *above]);
        }
    }

    /// Written as selections without a branch, so that it works on many nodes at once.
    #[inline]
    fn value(self, value: f32, [west, east, south, north, below, above]: [f32; 6]) -> f32 {
        let bend = (west + east) + (south + north) + (below + above) - 6.0 * value;
        let allowed = least(self.most, 0.5 * value.abs());
        let change = most(least(bend / 12.0, allowed), -allowed);
        let far = [east, south, north, below, above, value];
        let farthest = far.into_iter().fold(west.abs(), |far, value| most(far, value.abs()));
        // Not beyond what may be truncated.
        let changed = most(least(value - change, self.limit), -self.limit);
        if farthest < self.limit { changed } else { value }
    }
}

#[inline]
fn least(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

#[inline]
fn most(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::coordinate;

    fn grid(dims: [usize; 3]) -> FieldGrid {
        FieldGrid::new(glam::DVec3::ZERO, 1.0, dims).expect("a small grid")
    }

    /// What one node becomes, straight from all nodes as they were.
    fn slowly(values: &[f32], dims: [usize; 3], node: [usize; 3], limits: [f32; 2]) -> f32 {
        let [spacing, limit] = limits;
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
        let allowed = (single(MOST) * spacing).min(0.5 * here.abs());
        (here - (bend / 12.0).clamp(-allowed, allowed)).clamp(-limit, limit)
    }

    /// On grids of one slab, of several, and with nothing inside.
    #[test]
    fn nodes_become_what_their_neighbours_ask_for() {
        arbtest::arbtest(|u| {
            let dims = [u.int_in_range(2..=9)?, u.int_in_range(2..=6)?, u.int_in_range(2..=70)?];
            let limit = 2.0;
            // Mostly bent a little, some across the surface, some truncated.
            let value = |_| Ok(f32::from(u.int_in_range(-36..=100_i16)?.clamp(-20, 20)) / 10.0);
            let before: Result<Vec<f32>, _> = (0..dims.iter().product()).map(value).collect();
            let before: Vec<f32> = before?;
            let mut after = before.clone();
            quasi_interpolate(&mut after, &grid(dims), limit);
            for (n, value) in after.iter().enumerate() {
                let node = [n % dims[0], n / dims[0] % dims[1], n / (dims[0] * dims[1])];
                let expected = slowly(&before, dims, node, [1.0, limit]);
                assert!(
                    (value - expected).abs() < 1e-6,
                    "{node:?} of {dims:?}: {value} {expected}"
                );
                assert_eq!(value.is_sign_negative(), before[n].is_sign_negative(), "{node:?}");
                assert!((value - before[n]).abs() <= single(MOST) + 1e-6, "{node:?}");
            }
            Ok(())
        })
        .budget_ms(1000);
    }

    /// Of a paraboloid, linear interpolation errs by nothing on average.
    #[test]
    fn squares_are_right_on_average() {
        let dims = [8, 7, 9];
        let height =
            |p: [f64; 3]| 20.0 + (p[0] * p[0] - 0.5 * p[1] * p[1] + 2.0 * p[2] * p[2]) / 40.0;
        let position = |n: usize| {
            [n % dims[0], n / dims[0] % dims[1], n / (dims[0] * dims[1])].map(coordinate)
        };
        let mut values: Vec<f32> =
            (0..dims.iter().product()).map(|n| single(height(position(n)))).collect();
        let error = |values: &[f32]| {
            // Points at the middles of 4³ parts of an inner cell.
            let places = [0.125, 0.375, 0.625, 0.875];
            let mut sum = 0.0;
            for (z, y) in places.into_iter().flat_map(|z| places.map(|y| (z, y))) {
                for x in places {
                    let first = 3 + dims[0] * (2 + dims[1] * 4);
                    let [low, high] =
                        crate::store::corners(values, first, [dims[0], dims[0] * dims[1]]);
                    let place = glam::DVec3::new(x, y, z);
                    let value = crate::interpolate::trilinear(low, high, place).0;
                    sum += value - height([3.0 + x, 2.0 + y, 4.0 + z]);
                }
            }
            sum / 64.0
        };
        let before = error(&values);
        quasi_interpolate(&mut values, &grid(dims), 100.0);
        let after = error(&values);
        // The middles of quarters see the mean of x (1 - x) as 5 / 32 rather than 1 / 6.
        assert!(before > 0.009 && after.abs() < 0.07 * before, "{before} {after}");
    }
}
