//! Generation of several sizes from one surface.

use std::cell::OnceCell;
use std::cmp::Reverse;

use surface::Inspection;
use surface::progress::{Interrupted, Progress};

use super::collapse::Collapse;
use super::refit::{Refit, initial_balls};
use super::seeds::Seeds;
use super::shrink::{self, MaximalBall};
use super::{Generated, MedialParams};
use crate::surface_distance::SurfaceDistance;
use crate::{Deviation, MedialError};

/// Number of vertices per initial ball up to which all vertices start with a ball.
///
/// Below, more sizes start from few balls, which do not merge as well; above, more start from all,
/// which takes longer.
const DENSE: usize = 80;

/// Number of vertices per ball that a tolerance may take at least: with fewer, the balls follow the
/// noise of the vertices.
const MIN_VERTICES_PER_BALL: usize = 8;

/// Thickness of a sheet, in mean edges, below which it is refused.
///
/// At half an edge the balls of neighbors still overlap into a sheet; at a tenth they are beads, and
/// it is a coincidence which vertex faces which.
const MIN_THICKNESS: f64 = 0.5;

/// Number of balls that the search for a tolerance starts from.
const MIN_BALLS: usize = 8;

/// Fraction of the whole at which the maximal balls are computed.
const SHRUNK: f64 = 0.1;

/// Fraction of one size at which its balls have merged.
const COLLAPSED: f64 = 0.1;

/// Fraction of one size at which its balls are fitted.
const FITTED: f64 = 0.9;

/// One surface, checked, from which medial surfaces of several sizes are generated.
pub(super) struct Generator<'a> {
    distance: &'a SurfaceDistance<'a>,
    inspection: &'a Inspection,
    params: &'a MedialParams,
    sparse: OnceCell<Start>,
    dense: OnceCell<Start>,
}

/// Balls that merge first, with the vertices that they are at.
struct Start {
    seeds: Seeds,
    maximal: Vec<MaximalBall>,
}

impl<'a> Generator<'a> {
    pub(super) const fn new(
        distance: &'a SurfaceDistance<'a>,
        inspection: &'a Inspection,
        params: &'a MedialParams,
    ) -> Self {
        Self { distance, inspection, params, sparse: OnceCell::new(), dense: OnceCell::new() }
    }

    /// Generates one size.
    pub(super) fn with_balls(
        &self,
        count: usize,
        progress: Progress<'_>,
    ) -> Result<Generated, MedialError> {
        let mut collapse = self.start_collapse(count, progress.part(0.0, SHRUNK))?;
        self.collapse_and_fit(&mut collapse, count, progress.part(SHRUNK, 1.0))
    }

    /// Generates several sizes by one collapse, from the largest down; returns them in the order of
    /// `counts`.
    pub(super) fn with_each(
        &self,
        counts: &[usize],
        progress: Progress<'_>,
    ) -> Result<Vec<Generated>, MedialError> {
        let mut order: Vec<usize> = (0..counts.len()).collect();
        order.sort_by_key(|&k| Reverse(counts[k]));
        let Some(&first) = order.first() else { return Ok(Vec::new()) };

        // Each size goes on from where the collapse of the larger one ended.
        let mut collapse = self.start_collapse(counts[first], progress.part(0.0, SHRUNK))?;
        let mut generated = Vec::with_capacity(counts.len());
        for (done, &k) in order.iter().enumerate() {
            let (done, count) = (crate::real(done), crate::real(order.len()));
            let part = progress.part(SHRUNK, 1.0).part(done / count, (done + 1.0) / count);
            generated.push((k, self.collapse_and_fit(&mut collapse, counts[k], part)?));
        }
        generated.sort_by_key(|&(k, _)| k);
        Ok(generated.into_iter().map(|(_, generated)| generated).collect())
    }

    /// Generates the smallest size that meets a tolerance: doubles the balls until it is met, then
    /// halves the difference between the size that met it and the one that did not.
    pub(super) fn within(
        &self,
        tolerance: f64,
        progress: Progress<'_>,
    ) -> Result<Generated, MedialError> {
        let vertices = self.distance.surface.vertex_count();
        let max_balls = (vertices / MIN_VERTICES_PER_BALL).max(MIN_BALLS);

        // The number of sizes is unknown: each takes a quarter of the bar that is left.
        let mut rest = progress;
        let mut generate = |balls| {
            let part = rest.part(0.0, 0.25);
            rest = rest.part(0.25, 1.0);
            self.with_balls(balls, part)
        };

        // Doubling. More balls may deviate by more.
        let (mut low, mut high) = (0, MIN_BALLS);
        let mut best = generate(high)?;
        let (mut reached, mut balls) = (f64::INFINITY, 0);
        while best.deviation.largest() > tolerance {
            if best.deviation.largest() < reached {
                (reached, balls) = (best.deviation.largest(), high);
            }
            if high >= max_balls {
                return Err(MedialError::ToleranceNotReached { tolerance, reached, balls });
            }
            (low, high) = (high, (2 * high).min(max_balls));
            best = generate(high)?;
        }

        // Bisection, within a tenth of the number; from no balls at all where the first size did.
        while high - low > (high / 10).max(1) {
            let middle = low.midpoint(high);
            let found = generate(middle)?;
            if found.deviation.largest() > tolerance {
                low = middle;
            } else {
                (high, best) = (middle, found);
            }
        }
        Ok(best)
    }

    /// Prepares the balls that merge, for medial surfaces of up to `count`.
    fn start_collapse(
        &self,
        count: usize,
        progress: Progress<'_>,
    ) -> Result<Collapse<'a>, MedialError> {
        let start = self.start(count, progress)?;
        self.check_thickness(&start.maximal)?;
        Ok(Collapse::new(self.distance, &start.seeds, &start.maximal))
    }

    /// Returns the balls that merge first: at few of the vertices where these are many.
    fn start(&self, count: usize, progress: Progress<'_>) -> Result<&Start, Interrupted> {
        let distance = self.distance;
        let sparse = get_or_try_init(&self.sparse, || {
            let seeds = Seeds::sparse(distance.surface, distance.x);
            let maximal = shrink::maximal_balls(distance, &seeds, progress.part(0.0, 0.5))?;
            Ok(Start { seeds, maximal })
        })?;
        if distance.surface.vertex_count() > DENSE * initial_balls(distance, count) {
            return Ok(sparse);
        }

        get_or_try_init(&self.dense, || {
            let (seeds, balls) = (&sparse.seeds, &sparse.maximal);
            let progress = progress.part(0.5, 1.0);
            let maximal = shrink::maximal_balls_between(distance, seeds, balls, progress)?;
            Ok(Start { seeds: Seeds::all(distance.surface), maximal })
        })
    }

    /// Merges balls down to a few more than `count`, and fits them.
    fn collapse_and_fit(
        &self,
        collapse: &mut Collapse<'_>,
        count: usize,
        progress: Progress<'_>,
    ) -> Result<Generated, MedialError> {
        collapse.run(initial_balls(self.distance, count), progress.part(0.0, COLLAPSED))?;
        let mut medial = collapse.medial_surface()?;

        let refit = Refit {
            distance: self.distance,
            balls: count,
            steps: self.params.fit_steps,
            inscribed_weight: self.params.inscribed_weight,
        };
        refit.run(&mut medial, progress.part(COLLAPSED, FITTED))?;

        let progress = progress.part(FITTED, 1.0);
        let deviation = Deviation::from_surface(&medial, self.distance, progress)?;
        progress.report(1.0)?;
        Ok(Generated { medial, deviation })
    }

    /// Checks that the balls are not much smaller than the faces: the vertices do not show then
    /// where the other side of the sheet is.
    fn check_thickness(&self, maximal: &[MaximalBall]) -> Result<(), MedialError> {
        let mut radii: Vec<f64> = maximal.iter().map(|maximal| maximal.ball.radius).collect();
        radii.sort_by(f64::total_cmp);
        let thickness = 2.0 * radii[radii.len() / 2];
        let edge = self.inspection.mean_edge;
        if thickness < MIN_THICKNESS * edge {
            Err(MedialError::TooThin { thickness, edge })
        } else {
            Ok(())
        }
    }
}

/// Returns the value of a cell, which is computed at the first use.
fn get_or_try_init<T>(
    cell: &OnceCell<T>,
    compute: impl FnOnce() -> Result<T, Interrupted>,
) -> Result<&T, Interrupted> {
    let value = match cell.get() {
        Some(value) => return Ok(value),
        None => compute()?,
    };
    Ok(cell.get_or_init(|| value))
}
