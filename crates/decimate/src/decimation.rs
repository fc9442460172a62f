//! Sequence of coarser surfaces, and the choice among them.

use proximity::SurfaceTree;
use surface::progress::Progress;
use surface::{HausdorffBounds, TriangleSurface};

use crate::collapsed::Collapsed;
use crate::directed::Accuracy;
use crate::hausdorff::certified;
use crate::measure::Measure;
use crate::order::{Collapse, collapses};
use crate::target::{Target, adjacent_faces};
use crate::{DecimateError, ReducedSurface};

/// Edge collapses of a surface into its own vertices, in order of cost: every prefix of the
/// sequence is a coarser surface.
#[derive(Clone, Debug)]
pub struct Decimation {
    full: SurfaceTree,
    adjacent: Vec<[u32; 3]>,
    collapses: Vec<Collapse>,
}

/// Share of the faces by which successive candidates differ.
///
/// Smaller takes more candidates for the last few faces; larger leaves more of them.
const CANDIDATE_STEP: f64 = 0.02;

/// Largest distance of a vertex, relative to the requested deviation, at which the rest of the
/// surface is presumed near enough during the search.
///
/// Smaller measures surfaces that are far finer than needed; larger, and the search ends at
/// surfaces that deviate more, from which it steps back one by one.
const PRESUMED: f64 = 0.3;

/// Splits before a candidate is given up during the search.
const MAX_SEARCH_SPLITS: usize = 5_000;

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
        let adjacent = adjacent_faces(full.surface());
        let x = full.positions().as_slice();
        let collapses = collapses(full.surface().faces(), x, progress)?;
        Ok(Self { full, adjacent, collapses })
    }

    /// Returns the full surface.
    #[must_use]
    pub fn full(&self) -> &SurfaceTree {
        &self.full
    }

    /// Finds the coarsest surface of the sequence whose Hausdorff distance from the full one
    /// is certified to be at most `max_deviation` (length, `> 0`, finite).
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
        let mut done = 0.0;
        while failed - passed > 1 {
            let middle = usize::midpoint(passed, failed);
            let part = progress.part(done, 0.5 + 0.5 * done);
            done = 0.5 + 0.5 * done;
            if self.may_be_within(candidates[middle], max_deviation, part)? {
                passed = middle;
            } else {
                failed = middle;
            }
        }

        // Certify, stepping back where the presumption was wrong.
        loop {
            let part = progress.part(done, 1.0);
            let reduced = self.reduced(candidates[passed], max_deviation, part)?;
            if reduced.deviation.upper() <= max_deviation {
                return Ok(reduced);
            }
            passed -= 1;
        }
    }

    /// Returns true if the surface after some collapses probably deviates by no more than
    /// `max_deviation`.
    fn may_be_within(
        &self,
        collapses: usize,
        max_deviation: f64,
        progress: Progress<'_>,
    ) -> Result<bool, DecimateError> {
        progress.report(0.0)?;
        let measure = Measure::new(self.target(), self.collapsed(collapses))?;

        // Most candidates are decided by their vertices alone.
        let distance = measure.max_vertex_distance(progress)?;
        if distance > max_deviation || distance <= PRESUMED * max_deviation {
            return Ok(distance <= max_deviation);
        }

        let (min_slack, limit) = (max_deviation, max_deviation);
        let accuracy = Accuracy { min_slack, limit, max_splits: MAX_SEARCH_SPLITS };
        Ok(measure.deviation(accuracy, progress)?.upper() <= max_deviation)
    }

    /// Returns the numbers of collapses that are tried, ascending from none to all.
    ///
    /// They are the same for every deviation, so that a larger one ends at the same or a later
    /// one.
    fn candidates(&self) -> Vec<usize> {
        let last = self.collapses.len();
        let mut candidates = vec![0];
        let mut at = 0;
        while at < last {
            at = (at + step(self.adjacent.len() - 2 * at)).min(last);
            candidates.push(at);
        }
        candidates
    }

    /// Returns the surface after the first collapses.
    fn collapsed(&self, collapses: usize) -> Collapsed {
        let surface = self.full.surface();
        Collapsed::new(surface.vertex_count(), surface.faces(), &self.collapses[..collapses])
    }

    /// Returns the full surface as the target of distances.
    fn target(&self) -> Target<'_> {
        Target { tree: &self.full, adjacent: &self.adjacent }
    }

    /// Returns the surface after some collapses with its certified deviation, which is
    /// infinite where it exceeds `limit`.
    fn reduced(
        &self,
        collapses: usize,
        limit: f64,
        progress: Progress<'_>,
    ) -> Result<ReducedSurface, DecimateError> {
        let collapsed = self.collapsed(collapses);
        let kept = collapsed.kept.clone();
        let measure = Measure::new(self.target(), collapsed)?;
        let deviation = if collapses == 0 {
            HausdorffBounds::default() // equal surfaces do not deviate by rounding errors
        } else {
            measure.deviation(certified(&self.full, limit), progress)?
        };
        Ok(ReducedSurface { surface: measure.surface(), kept, deviation })
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
