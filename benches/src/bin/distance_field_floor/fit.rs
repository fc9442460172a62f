//! The values at nodes that fit best: least squares over points, by conjugate gradients.

use std::ops::Range;

use distance_field::Grid;
use fixtures::sampling::Truth;
use glam::DVec3;
use rayon::prelude::*;

use crate::spline::{Place, Spline};

/// How much the squares of errors count.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Aim {
    /// Of distances, in spacings.
    pub(crate) distance: f64,
    /// Of gradients, beside unit vectors along the true directions.
    pub(crate) slope: f64,
}

/// Points at which the truth is known, and the nodes that have to do with them.
pub(crate) struct Fit<'a, const N: usize> {
    spline: Spline<N>,
    grid: Grid,
    truths: &'a [Truth],
    slabs: Vec<Slab>,
    /// Nodes that have to do with a point, in the grid's order.
    free: Vec<usize>,
    /// Which of these a node is; [`FIXED`] for others.
    rank: Vec<u32>,
}

const FIXED: u32 = u32::MAX;

/// Truths whose cells begin in one plane of nodes, and the free nodes that have to do with them.
struct Slab {
    truths: Range<usize>,
    free: Range<usize>,
}

/// A value and its gradient.
type Jet = (f64, DVec3);

/// Brings truths into the order that a fit works in: plane by plane, cell by cell.
pub(crate) fn sort(truths: &mut [Truth], grid: &Grid) {
    truths.par_sort_by_cached_key(|truth| {
        let [i, j, k] = grid.locate(truth.point)?.node;
        Some([k, j, i])
    });
}

impl<'a, const N: usize> Fit<'a, N> {
    /// To truths well within the grid, as [`sort`] left them.
    pub(crate) fn new(spline: Spline<N>, grid: Grid, truths: &'a [Truth]) -> Self {
        let rank = vec![FIXED; grid.node_count()];
        let mut fit = Self { spline, grid, truths, slabs: Vec::new(), free: Vec::new(), rank };
        for truth in truths {
            let place = fit.spline.place(&grid, truth.point);
            for first in place.rows().map(|row| place.node(&grid, row)) {
                fit.rank[first..first + N].fill(0);
            }
        }
        for (node, rank) in fit.rank.iter_mut().enumerate().filter(|(_, rank)| **rank != FIXED) {
            *rank = u32::try_from(fit.free.len()).expect("fewer nodes than a grid may have");
            fit.free.push(node);
        }
        fit.slabs = fit.slabs();
        fit
    }

    fn slabs(&self) -> Vec<Slab> {
        let plane = |truth: &Truth| self.spline.place(&self.grid, truth.point).first[2];
        let [nx, ny, _] = self.grid.dims();
        let below = |plane: usize| self.free.partition_point(|&node| node < plane * nx * ny);
        let mut start = 0;
        let slab = |truths: &[Truth]| {
            let first = plane(&truths[0]);
            let range = start..start + truths.len();
            start = range.end;
            Slab { truths: range, free: below(first)..below(first + N) }
        };
        self.truths.chunk_by(|a, b| plane(a) == plane(b)).map(slab).collect()
    }

    /// `values` of all nodes, with what fits best after so many steps at those that are free.
    ///
    /// The same bits for any number of threads.
    pub(crate) fn best(&self, aim: &Aim, values: &[f64], steps: u64, done: impl Fn()) -> Vec<f64> {
        let mut x: Vec<f64> = self.free.iter().map(|&node| values[node]).collect();
        let per_spacing = self.grid.spacing().powi(-2);
        let weigh =
            |(value, gradient): Jet| (aim.distance * per_spacing * value, aim.slope * gradient);
        let mut rest = self.normal(&x, |truth, (value, gradient)| {
            weigh((truth.distance - value, truth.direction - gradient))
        });
        let mut way = rest.clone();
        let mut left = dot(&rest, &rest);
        for _ in 0..steps {
            let product = self.normal(&way, |_, jet| weigh(jet));
            let length = left / dot(&way, &product).max(f64::MIN_POSITIVE);
            add(&mut x, length, &way);
            add(&mut rest, -length, &product);
            let now = dot(&rest, &rest);
            let kept = now / left.max(f64::MIN_POSITIVE);
            way.iter_mut().zip(&rest).for_each(|(way, rest)| *way = rest + kept * *way);
            left = now;
            done();
        }
        let mut values = values.to_vec();
        self.free.iter().zip(x).for_each(|(&node, x)| values[node] = x);
        values
    }

    /// Takes value and gradient at each truth from the nodes, changes them, and gives them back
    /// to the nodes, as many times as each had to do with them.
    fn normal(&self, x: &[f64], change: impl Fn(&Truth, Jet) -> Jet + Sync) -> Vec<f64> {
        let part = |slab: &Slab| self.in_slab(slab, &x[slab.free.clone()], &change);
        let parts: Vec<Vec<f64>> = self.slabs.par_iter().map(part).collect();
        let mut sum = vec![0.0; x.len()];
        for (slab, part) in self.slabs.iter().zip(parts) {
            add(&mut sum[slab.free.clone()], 1.0, &part);
        }
        sum
    }

    fn in_slab(&self, slab: &Slab, x: &[f64], change: &impl Fn(&Truth, Jet) -> Jet) -> Vec<f64> {
        let mut sum = vec![0.0; x.len()];
        for truth in &self.truths[slab.truths.clone()] {
            let place = self.spline.place(&self.grid, truth.point);
            let first = |row| self.rank[place.node(&self.grid, row)] as usize - slab.free.start;
            let jet = place.read(|row| &x[first(row)..]);
            place.add(change(truth, jet), &mut sum, first);
        }
        sum
    }
}

/// Value and gradient at each truth, of values at all nodes.
pub(crate) fn answers<const N: usize>(
    spline: Spline<N>,
    grid: &Grid,
    values: &[f64],
    truths: &[Truth],
) -> Vec<Jet> {
    let answer = |truth: &Truth| {
        let place: Place<N> = spline.place(grid, truth.point);
        place.read(|row| &values[place.node(grid, row)..])
    };
    truths.par_iter().map(answer).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn add(to: &mut [f64], times: f64, what: &[f64]) {
    to.iter_mut().zip(what).for_each(|(to, what)| *to += times * what);
}
