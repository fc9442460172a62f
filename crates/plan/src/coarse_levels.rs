//! Coarse surfaces of one body, of which the present shape chooses one.
//!
//! A coarse face that spans a part which bends deviates there by more than at rest, and a finer one by
//! less, in about the same ratio. So finer surfaces take the place of the coarsest in frames in which
//! the body is bent, before its own surface has to: they have a few times as many faces, not thirty.

use decimate::CoarseSurface;
use glam::DVec3;
use proximity::ProximityError;
use scene::Body;

/// Part of the tolerance that deviations must leave, in which surfaces that touch are told from those
/// that are deeper. Larger compares bodies that deform by their own surfaces sooner.
pub(crate) const MIN_WIDTH: f64 = 0.02;

/// Deviation that two coarse surfaces may both have \[tolerances\].
pub(crate) const MAX_DEVIATION: f64 = 0.5 * (1.0 - MIN_WIDTH);

/// Deviations of the finer surfaces of bodies that deform, in those of the coarsest.
const FINER_SHARES: [f64; 2] = [0.5, 0.25];

/// Smallest number of frames for which finer surfaces are built: they take as long as some fifty frames
/// of exact detection, whether a body ever bends or not.
const MIN_FRAMES: u32 = 1000;

/// Coarse surfaces of a body: the coarsest that deviates little enough stands for it.
#[derive(Debug)]
pub(crate) struct CoarseLevels {
    /// From the coarsest to the finest, at least one. Those beyond the present one are elsewhere.
    levels: Vec<CoarseSurface>,
    present: usize,
}

impl CoarseLevels {
    /// Makes levels of the coarsest surface and finer ones, in their order.
    pub(crate) fn new(coarsest: CoarseSurface, finer: Vec<CoarseSurface>) -> Self {
        let mut levels = vec![coarsest];
        levels.extend(finer);
        Self { levels, present: 0 }
    }

    /// Returns the surface that stands for the body where it is.
    pub(crate) fn present(&self) -> &CoarseSurface {
        &self.levels[self.present]
    }

    /// Moves to where a body has got by a pose, as it was where they were before.
    pub(crate) fn follow_rigidly(
        &mut self,
        positions: &[DVec3],
        reference: &[DVec3],
    ) -> Result<(), ProximityError> {
        self.levels[self.present].follow_rigidly(positions, reference)
    }

    /// Moves to where the body is, and chooses the coarsest surface that deviates by no more than
    /// `max_deviation` there; the finest where all deviate more.
    pub(crate) fn follow(
        &mut self,
        positions: &[DVec3],
        max_deviation: f64,
    ) -> Result<(), ProximityError> {
        let finest = self.levels.len() - 1;
        for (level, coarse) in self.levels.iter_mut().enumerate() {
            self.present = level;
            let max_deviation = if level < finest { max_deviation } else { f64::INFINITY };
            if coarse.follow_within(positions, max_deviation)? {
                break;
            }
        }
        Ok(())
    }

    /// Returns the number of surfaces finer than the coarsest.
    pub(crate) fn finer_count(&self) -> usize {
        self.levels.len() - 1
    }

    /// Returns the memory of all levels, in bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.levels.iter().map(CoarseSurface::bytes).sum()
    }
}

/// Returns the shares of the deviations of the finer surfaces that a body gets.
pub(crate) fn finer_shares(body: &Body, frames: u32) -> &'static [f64] {
    if body.is_rigid() || frames < MIN_FRAMES { &[] } else { &FINER_SHARES }
}
