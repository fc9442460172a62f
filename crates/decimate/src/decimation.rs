//! The sequence of coarser surfaces, and the choice among them.

use glam::DVec3;
use kdop::Tree;
use surface::{Positions, TriangleSurface};

use crate::deviation::{MAX_SPLITS, MIN_SLACK};
use crate::measure::Measure;
use crate::one_sided::Aim;
use crate::order::{Collapse, collapses};
use crate::prefix::Prefix;
use crate::triangles::{Target, Triangles};
use crate::{DecimateError, Deviation, ReducedSurface};

/// Edge collapses of a surface into its own vertices, in order of cost: every prefix
/// is a coarser surface.
///
/// ```
/// use decimate::Decimation;
///
/// let ball = fixtures::shapes::icosphere(30.0, 4);
/// let (surface, x) = (ball.surface(), ball.positions);
/// let decimation = Decimation::new(&surface, surface.positions(&x)?)?;
///
/// let reduced = decimation.within(0.5)?;
/// assert!(reduced.deviation.largest() <= 0.5);
/// assert!(reduced.surface.faces().len() < surface.faces().len() / 5);
///
/// // It follows whatever the full surface does.
/// let squeezed: Vec<_> = x.iter().map(|p| *p * 0.9).collect();
/// let mut follows = Vec::new();
/// reduced.gather(&squeezed, &mut follows);
/// assert_eq!(follows[7], squeezed[reduced.kept[7] as usize]);
/// # Ok::<(), decimate::DecimateError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Decimation {
    surface: TriangleSurface,
    x: Vec<DVec3>,
    tree: Tree,
    across: Vec<[u32; 3]>,
    collapses: Vec<Collapse>,
}

/// Share of the faces by which surfaces that are tried differ.
///
/// Smaller takes more tries for the last few faces; larger leaves more of them.
const STEP: f64 = 0.02;

/// Largest distance of a vertex, relative to the deviation asked for, at which the rest
/// of the surface is taken to be near enough while searching.
///
/// Smaller measures surfaces that are far finer than needed; larger, and the search ends
/// at surfaces that deviate more, from which it steps back one by one.
const PRESUMED: f64 = 0.3;

/// Splits before a surface that is tried is passed over.
const SPLITS_OF_A_TRY: usize = 5_000;

impl Decimation {
    /// Collapses as far as topology and shape allow.
    ///
    /// # Errors
    ///
    /// - [`DecimateError::Surface`] for a surface that is not closed, manifold and
    ///   oriented.
    /// - [`DecimateError::RepeatedVertex`] or [`DecimateError::TooSmall`] for one that
    ///   encloses nothing.
    /// - [`DecimateError::Tree`] where bounds cannot be stored.
    pub fn new(surface: &TriangleSurface, x: Positions<'_>) -> Result<Self, DecimateError> {
        let x = surface.positions(x.as_slice())?.as_slice();
        check(surface)?;
        let triangles = Triangles { surface, x };
        let (tree, across) = (triangles.tree()?, triangles.across());
        let collapses = collapses(surface.faces(), x);
        Ok(Self { surface: surface.clone(), x: x.to_vec(), tree, across, collapses })
    }

    /// The coarsest surface of the sequence found whose deviation bound is at most
    /// `deviation` (length units, `> 0`, finite).
    ///
    /// It is the full surface, with bound 0, where already the first that is coarser
    /// deviates more. A larger `deviation` never has more faces.
    ///
    /// # Errors
    ///
    /// - [`DecimateError::Parameter`] for a deviation out of range.
    /// - [`DecimateError::Tree`] where bounds cannot be stored.
    pub fn within(&self, deviation: f64) -> Result<ReducedSurface, DecimateError> {
        if !deviation.is_finite() || deviation <= 0.0 {
            let range = "positive and finite";
            return Err(DecimateError::Parameter { name: "deviation", value: deviation, range });
        }
        let tries = self.tries();
        // Bisects between what passed and what did not; the full surface passes.
        let (mut passed, mut failed) = (0, tries.len());
        while failed - passed > 1 {
            let middle = usize::midpoint(passed, failed);
            if self.may_be_within(tries[middle], deviation)? {
                passed = middle;
            } else {
                failed = middle;
            }
        }
        loop {
            let reduced = self.reduced(tries[passed], deviation)?;
            if reduced.deviation.largest() <= deviation {
                return Ok(reduced);
            }
            passed -= 1;
        }
    }

    /// Whether the surface after some collapses is likely to deviate by no more than
    /// this: certain where it matters.
    fn may_be_within(&self, collapses: usize, deviation: f64) -> Result<bool, DecimateError> {
        let prefix = self.prefix(collapses);
        let measure = Measure::new(self.target(), &prefix)?;
        let farthest = measure.farthest_vertex();
        if farthest > deviation || farthest <= PRESUMED * deviation {
            return Ok(farthest <= deviation);
        }
        let aim = Aim { slack: deviation, at_most: deviation, splits: SPLITS_OF_A_TRY };
        Ok(measure.deviation(aim).largest() <= deviation)
    }

    /// The finest surface of the sequence with at most this many faces.
    ///
    /// # Errors
    ///
    /// - [`DecimateError::TooFewFaces`] when topology and shape allow none.
    /// - [`DecimateError::Tree`] where bounds cannot be stored.
    pub fn with_faces(&self, at_most: usize) -> Result<ReducedSurface, DecimateError> {
        let count = self.face_count().saturating_sub(at_most).div_ceil(2);
        if count > self.collapses.len() {
            let fewest = self.faces_after(self.collapses.len());
            return Err(DecimateError::TooFewFaces { asked: at_most, fewest });
        }
        self.reduced(count, f64::INFINITY)
    }

    fn face_count(&self) -> usize {
        self.surface.faces().len()
    }

    /// Each collapse takes the two faces at its edge.
    fn faces_after(&self, collapses: usize) -> usize {
        self.face_count() - 2 * collapses
    }

    /// Numbers of collapses that are tried, ascending from none to all: the same for
    /// every deviation, so that a larger one ends at the same or farther on.
    fn tries(&self) -> Vec<usize> {
        let last = self.collapses.len();
        let mut tries = vec![0];
        let mut at = 0;
        while at < last {
            at = (at + step(self.faces_after(at))).min(last);
            tries.push(at);
        }
        tries
    }

    fn prefix(&self, collapses: usize) -> Prefix {
        Prefix::new(self.x.len(), self.surface.faces(), &self.collapses[..collapses])
    }

    fn target(&self) -> Target<'_> {
        let triangles = Triangles { surface: &self.surface, x: &self.x };
        Target { triangles, tree: &self.tree, across: &self.across }
    }

    /// The surface after some collapses; its deviation is infinite if it is more than
    /// `at_most`.
    fn reduced(&self, collapses: usize, at_most: f64) -> Result<ReducedSurface, DecimateError> {
        let prefix = self.prefix(collapses);
        let deviation = if collapses == 0 {
            Deviation::NONE // what rounding shows of equal surfaces is not theirs
        } else {
            let slack = MIN_SLACK * self.target().triangles.size();
            let aim = Aim { slack, at_most, splits: MAX_SPLITS };
            Measure::new(self.target(), &prefix)?.deviation(aim)
        };
        let surface = TriangleSurface::new(prefix.kept.len(), prefix.faces)?;
        Ok(ReducedSurface { surface, kept: prefix.kept, deviation })
    }
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    clippy::cast_precision_loss,
    reason = "a share of a count"
)]
fn step(faces: usize) -> usize {
    // Two faces a collapse, and one collapse at least.
    ((STEP * 0.5 * faces as f64) as usize).max(1)
}

fn check(surface: &TriangleSurface) -> Result<(), DecimateError> {
    for (face, &[a, b, c]) in surface.faces().iter().enumerate() {
        if a == b || b == c || c == a {
            let vertex = if a == b || c == a { a } else { b };
            return Err(DecimateError::RepeatedVertex { face, vertex });
        }
    }
    surface.require_closed()?;
    surface.require_manifold()?;
    surface.require_oriented()?;
    let faces = surface.faces().len();
    if faces < 4 { Err(DecimateError::TooSmall { faces }) } else { Ok(()) }
}
