//! Sequence of coarser surfaces, and the choice among them.

use std::sync::Arc;

use glam::DVec3;
use proximity::SurfaceTree;
use surface::TriangleSurface;
use surface::progress::Progress;

use crate::coarse_map::CoarseMap;
use crate::collapsed::Collapsed;
use crate::map_builder::MapBuilder;
use crate::order::{Collapse, collapses};
use crate::surfaces::{Coarse, Full};
use crate::{DecimateError, ReducedSurface};

/// Edge collapses of a surface into its own vertices, in order of cost: every prefix of the
/// sequence is a coarser surface.
#[derive(Clone, Debug)]
pub struct Decimation {
    full: SurfaceTree,
    collapses: Vec<Collapse>,
}

/// Share of the faces by which successive candidates differ.
///
/// Smaller takes more candidates for the last few faces; larger leaves more of them.
const CANDIDATE_STEP: f64 = 0.02;

impl Decimation {
    /// Collapses edges as far as topology and shape allow.
    ///
    /// # Errors
    ///
    /// - [`DecimateError::Surface`] for a surface that is not closed, manifold and oriented.
    /// - [`DecimateError::RepeatedVertex`] or [`DecimateError::TooSmall`] for one that
    ///   encloses nothing.
    /// - [`DecimateError::Interrupted`] when the progress handler ends the call.
    pub fn new(full: SurfaceTree, progress: Progress<'_>) -> Result<Self, DecimateError> {
        check(full.surface())?;
        let x = full.positions().as_slice();
        let collapses = collapses(full.surface().faces(), x, progress)?;
        Ok(Self { full, collapses })
    }

    /// Returns the full surface.
    #[must_use]
    pub fn full(&self) -> &SurfaceTree {
        &self.full
    }

    /// Finds the coarsest surface of the sequence that is proved to deviate from the full one by
    /// at most `max_deviation` (length, `> 0`, finite), as
    /// [`ReducedSurface::deviation`] says.
    ///
    /// Returns the full surface, with bound 0, where already the first coarser one deviates
    /// more. A larger `max_deviation` never results in more faces.
    ///
    /// # Errors
    ///
    /// - [`DecimateError::MaxDeviation`] for a deviation out of range.
    /// - [`DecimateError::Interrupted`] when the progress handler ends the call.
    pub fn within(
        &self,
        max_deviation: f64,
        progress: Progress<'_>,
    ) -> Result<ReducedSurface, DecimateError> {
        if !max_deviation.is_finite() || max_deviation <= 0.0 {
            return Err(DecimateError::MaxDeviation { value: max_deviation });
        }

        // Bisect between a candidate that passed and one that failed; the full surface passes.
        let candidates = self.candidates();
        let (mut passed, mut failed) = (0, candidates.len());
        let mut coarsest = None;
        let mut done = 0.0;
        while failed - passed > 1 {
            let middle = usize::midpoint(passed, failed);
            let part = progress.part(done, 0.5 + 0.5 * done);
            done = 0.5 + 0.5 * done;
            let reduced = self.reduced(candidates[middle], max_deviation, part)?;
            if reduced.is_some() {
                (passed, coarsest) = (middle, reduced);
            } else {
                failed = middle;
            }
        }
        Ok(coarsest.unwrap_or_else(|| self.unreduced()))
    }

    /// Returns the numbers of collapses that are tried, ascending from none to all.
    ///
    /// They are the same for every deviation, so that a larger one ends at the same or a later
    /// one.
    fn candidates(&self) -> Vec<usize> {
        let (faces, last) = (self.full.surface().faces().len(), self.collapses.len());
        let mut candidates = vec![0];
        let mut at = 0;
        while at < last {
            at = (at + step(faces - 2 * at)).min(last);
            candidates.push(at);
        }
        candidates
    }

    /// Returns the surface after some collapses, if it is proved to deviate by no more than
    /// `max_deviation`.
    fn reduced(
        &self,
        collapses: usize,
        max_deviation: f64,
        progress: Progress<'_>,
    ) -> Result<Option<ReducedSurface>, DecimateError> {
        let (full, x) = (self.full.surface(), self.full.positions().as_slice());
        let collapses = &self.collapses[..collapses];
        let Collapsed { moved_into, kept, faces } =
            Collapsed::new(x.len(), full.faces(), collapses);
        let surface = TriangleSurface::new(kept.len(), faces)?;
        let kept_x: Vec<DVec3> = kept.iter().map(|&vertex| x[vertex as usize]).collect();

        // The map proves the deviation.
        let coarse = Coarse { surface: &surface, x: &kept_x };
        let full = Full { surface: full, x, kept: &kept, moved_into: &moved_into };
        let Some(map) = MapBuilder::build(full, coarse, max_deviation, progress)? else {
            return Ok(None);
        };
        let deviation = map.max_shift(x, &kept_x);
        let reduced = ReducedSurface { surface: Arc::new(surface), kept, deviation, map };
        Ok((deviation <= max_deviation).then_some(reduced))
    }

    /// Returns the full surface, which deviates by nothing.
    fn unreduced(&self) -> ReducedSurface {
        let surface = self.full.shared_surface();
        let kept = (0..).take(surface.vertex_count()).collect();
        let map = CoarseMap::default();
        ReducedSurface { surface, kept, deviation: 0.0, map }
    }
}

/// Returns the number of collapses from a candidate with so many faces to the next one.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "a share of a count"
)]
fn step(faces: usize) -> usize {
    // A collapse removes two faces.
    ((CANDIDATE_STEP * 0.5 * faces as f64) as usize).max(1)
}

/// Checks that a surface is closed, manifold and oriented, and encloses something.
fn check(surface: &TriangleSurface) -> Result<(), DecimateError> {
    for (face, &[a, b, c]) in surface.faces().iter().enumerate() {
        if a == b || b == c || c == a {
            let vertex = if b == c { b } else { a };
            return Err(DecimateError::RepeatedVertex { face, vertex });
        }
    }
    surface.require_closed()?;
    surface.require_manifold()?;
    surface.require_oriented()?;
    let faces = surface.faces().len();
    if faces < 4 { Err(DecimateError::TooSmall { faces }) } else { Ok(()) }
}
