//! Results of overlap removal.

use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;
use scene::{BodyId, DepthBracket, PairId, PairReport, Scene};
use surface::parallel;
use surface::progress::{Interrupted, Progress};

use crate::damage::self_crossings_at;
use crate::exempt::is_surrounded;
use crate::near_pairs::{NearPair, NearPairs};
use crate::obstacle::Obstacle;
use crate::round::Round;
use crate::ties::Ties;
use crate::tissue::{Tissue, fitted_tree};
use crate::{ResolveError, ResolveParams, TiedVertices};

/// State of a scene before a round that opens the gap.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GapRound {
    /// Number of pairs of bodies that are nearer than the gap.
    pub short_pairs: usize,
    /// Number of their pairs of features, vertices and faces or edges, that are.
    pub short_features: usize,
    /// Sum of what these are missing.
    pub missing: f64,
    /// Smallest distance of two features; infinite where none are near, which is serialized as none.
    #[cfg_attr(feature = "serde", serde(with = "crate::infinite"))]
    pub min_distance: f64,
    /// Largest relative change of a soft body's volume.
    pub volume_change: f64,
    /// Weighted sum of missing openings and lost volume. It falls from each accepted round to the
    /// next.
    pub merit: f64,
    /// True if the state is better than all accepted before, and no body is beyond its limits. The
    /// scene is given the last of these.
    pub is_accepted: bool,
}

/// Certified bracket on a distance: `lower <= distance <= upper`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DistanceBracket {
    /// Distance that no two points of the surfaces go below, rounding included.
    pub lower: f64,
    /// Distance of two points of the surfaces.
    pub upper: f64,
}

/// Distances between the surfaces of all pairs, faces and edges included, at the positions that
/// are written.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct GapProof {
    /// The gap that was asked for; with 0 nothing is examined.
    pub gap: f64,
    /// Number of pairs that were examined face by face; all others are farther apart.
    pub examined_pairs: usize,
    /// Pairs that are not proved to keep the gap, the nearest first. Tied and ignored pairs are
    /// left out.
    pub short: Vec<ShortGap>,
}

/// Pair that is not proved to keep the gap.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ShortGap {
    /// The two bodies.
    pub pair: PairId,
    /// Distance of the surfaces, certified; 0 where they overlap.
    pub distance: DistanceBracket,
    /// Reason why the pair is nearer.
    pub obstacle: GapObstacle,
}

/// Reason why a pair is nearer than the gap.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum GapObstacle {
    /// Neither body may move.
    #[error("both are rigid, and neither moves")]
    BothRigid,
    /// The pair overlaps, for the reason that [`Remaining`] names.
    #[error("the surfaces overlap")]
    Overlaps,
    /// A soft body is between two bodies that leave it less room than it is thick.
    #[error(
        "no room: rigid bodies leave {room:.3e}, the body is {thickness:.3e} thick and needs {gap:.3e} on either side"
    )]
    Squeezed {
        /// Distance between the two rigid bodies there.
        room: f64,
        /// Thickness of the soft body there, at the start.
        thickness: f64,
        /// The gap that was asked for.
        gap: f64,
    },
    /// Vertices of the pair that would have to move are fixed.
    #[error("the vertices that would have to move are fixed")]
    Fixed,
    /// No step opens the gap any further.
    #[error("no step opens it any further")]
    Stuck,
}

impl GapRound {
    /// Sums what the round has to do: missing openings in gaps, and volume beyond what is kept in
    /// shares of that.
    pub(crate) fn left(&self, params: &ResolveParams) -> f64 {
        let excess = (self.volume_change - params.volume_tolerance()).max(0.0);
        self.missing / params.gap + excess / params.volume_tolerance()
    }
}

impl GapProof {
    /// Returns true if the surfaces of every pair are proved to keep the gap.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.short.is_empty()
    }
}

/// Displacement and deformation of one body.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyChange {
    /// The body.
    pub body: BodyId,
    /// Displacement of each vertex from its position at the start, |V|.
    pub displacements: Vec<DVec3>,
    /// Number of vertices that moved at all.
    pub moved: usize,
    /// Length of the longest displacement.
    pub max_displacement: f64,
    /// Volume over the volume at the start; `None` where the body has no inside, or no volume beyond rounding.
    pub volume_ratio: Option<f64>,
    /// Largest change of an edge's length over its length, or over the mean edge of the body where
    /// that is longer.
    pub strain: f64,
    /// Number of faces turned by a right angle or more.
    pub flipped_faces: usize,
    /// Number of crossing pairs of the body's own faces, at the start and now.
    pub self_crossings: [usize; 2],
}

/// Body that the best state would have brought beyond its limits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct BrokenLimit {
    /// The body.
    pub body: BodyId,
    /// Relative change of its volume.
    pub volume_change: f64,
    /// Largest displacement of a vertex.
    pub max_displacement: f64,
    /// Largest displacement that is within limits: the gap, and the [allowed](crate::ResolveParams::max_displacement)
    /// multiple of the deepest overlap at the start or the smoothing length.
    pub displacement_limit: f64,
    /// Its largest strain, as in [`BodyChange::strain`].
    pub strain: f64,
    /// Number of its faces turned by a right angle or more.
    pub flipped_faces: usize,
    /// Number of [corners of its cells](crate::CellCorners) that are flat.
    pub flat_corners: usize,
    /// Number of pairs of its own faces that cross, beyond their number at the start.
    pub self_crossings: usize,
}

/// Pair that still overlaps.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Remaining {
    /// The two bodies.
    pub pair: PairId,
    /// Depth of the surfaces, certified. Where they have no inside, both ends are the depth of the
    /// deepest crossing edge, 0 where edges cross too steeply for one.
    pub depth: DepthBracket,
    /// Number of crossing pairs of faces.
    pub crossing_faces: usize,
    /// True if the pair overlapped at the start.
    pub at_first: bool,
    /// Reason why the pair still overlaps.
    pub obstacle: Obstacle,
}

/// Result of overlap removal.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Resolution {
    /// Pairs of bodies within the detection margin at the start, overlaps with their measures.
    pub before: Vec<PairReport>,
    /// Pairs of bodies within the detection margin now, overlaps with their measures.
    pub after: Vec<PairReport>,
    /// State at the start and after each round that removes overlaps.
    pub rounds: Vec<Round>,
    /// State before each round that opens the gap.
    pub gap_rounds: Vec<GapRound>,
    /// Proof of the gap, pair by pair.
    pub gap: GapProof,
    /// Number of the round whose state the scene has now, or from whose state tissue settled and the gap
    /// was opened: the best one that is accepted, which may be earlier than the last; 0 for the start.
    pub final_round: usize,
    /// True if bodies come from where the last state of a walk displaced them to, or went back to rest without a bone on
    /// the way. Without that, they come from where the scene has them, and may end on another side of a bone than in the
    /// last state.
    pub is_continued: bool,
    /// Changes of all bodies, in their order.
    pub bodies: Vec<BodyChange>,
    /// Pairs that still overlap, the deepest first, including those within the tolerance.
    pub remaining: Vec<Remaining>,
    /// Bodies that the best state brings beyond their limits. With any, the scene has an earlier
    /// state, unless [`keep_going`](crate::ResolveParams::keep_going) asks for the best one.
    pub broken_limits: Vec<BrokenLimit>,
    /// Vertices that ties hold in the end, and those that they do not, in the order of the ties.
    pub ties: Vec<TiedVertices>,
    /// Bodies that are to be [uncrossed](crate::Conditions::uncrossed) and still cross themselves.
    pub self_overlaps: Vec<BodyId>,
    /// True if no surface is deeper in another than the tolerance, as far as certain, no pair
    /// overlaps that did not at the start, no limit is broken, the gap [holds](GapProof::holds),
    /// no body that is to be uncrossed crosses itself, and tied vertices are no farther from their
    /// [places](TiedVertices::max_distance) than the tie, the gap and the tolerance together.
    pub resolved: bool,
    /// Pairs that overlap in the round of least [merit](Round::merit), accepted or not.
    #[cfg_attr(feature = "serde", serde(skip))]
    pub(crate) unfreed: Vec<PairId>,
}

impl Remaining {
    /// Lists the pairs that still overlap, the deepest first.
    ///
    /// `after` has the measures of overlaps; `near` are the pairs as rounds see them, without those that are
    /// `exempt`, which ended for the reason of `standstill`.
    pub(crate) fn list(
        scene: &Scene,
        after: &[PairReport],
        near: &NearPairs,
        exempt: &[PairId],
        before: &[PairReport],
        ties: &Ties,
        standstill: Obstacle,
    ) -> Vec<Self> {
        let mut remaining = Vec::new();
        for report in after.iter().filter(|report| report.overlaps) {
            let pushed = near.overlapping().find(|near| near.report.pair == report.pair);
            let PairId { a, b, .. } = report.pair;
            let at_first = overlaps_in(before, report.pair);
            let is_unknown = pushed.is_none() && !exempt.contains(&report.pair);
            let obstacle = if scene.body(a).is_rigid() && scene.body(b).is_rigid() {
                Obstacle::BothRigid
            } else if !at_first && ties.are_around_overlap(scene, report) {
                Obstacle::Tied
            } else if is_unknown && !report.crossing_faces.is_empty() {
                Obstacle::Rounding
            } else if is_unknown && covers_twice(report) {
                Obstacle::CoversTwice
            } else if is_unknown {
                Obstacle::Coincident
            } else if is_enclosed(scene, report) {
                Obstacle::Enclosed
            } else if [a, b].iter().any(|id| scene.body(*id).has_inside().is_err()) {
                Obstacle::Pierced
            } else {
                standstill
            };

            let edge_depth = if is_unknown { 0.0 } else { NearPair::depth_of(scene, report) };
            let of_edges = DepthBracket { lower: edge_depth, upper: edge_depth };
            remaining.push(Self {
                pair: report.pair,
                depth: report.max_depth().unwrap_or(of_edges),
                crossing_faces: report.crossing_faces.len(),
                at_first,
                obstacle,
            });
        }
        remaining.sort_by(|p, q| q.depth.lower.total_cmp(&p.depth.lower));
        remaining
    }

    /// Returns true if the pair may be left as it is.
    ///
    /// A pair that did not overlap at the start may not, but where it is tied. Nor may one whose edges cross too
    /// steeply for a depth, or whose surfaces coincide or nearly do: their distance does not show what they share.
    pub(crate) fn is_within(&self, tolerance: f64) -> bool {
        let DepthBracket { upper, .. } = self.depth;
        let has_no_depth = matches!(
            self.obstacle,
            Obstacle::Coincident | Obstacle::NearlyCoincident | Obstacle::CoversTwice
        );
        let has_depth = upper > 0.0 && !has_no_depth;
        let is_known = self.at_first || self.obstacle == Obstacle::Tied;
        is_known && has_depth && upper <= tolerance
    }
}

/// Returns true if one body covers a place more than once.
pub(crate) fn covers_twice(report: &PairReport) -> bool {
    report.overlap.as_ref().is_some_and(|overlap| overlap.measures.covers_twice.contains(&true))
}

/// Returns true if no face crosses, and all vertices of one body are inside the other.
fn is_enclosed(scene: &Scene, report: &PairReport) -> bool {
    let sides = [(report.pair.a, &report.a_against_b), (report.pair.b, &report.b_against_a)];
    let mut encloses = is_surrounded(report);
    for (id, side) in sides {
        encloses |= side.inside_count == Ok(scene.body(id).positions().len());
    }
    encloses && report.crossing_faces.is_empty()
}

/// Returns true if a pair overlaps in one of these reports.
pub(crate) fn overlaps_in(reports: &[PairReport], pair: PairId) -> bool {
    for report in reports {
        if report.pair == pair {
            return report.overlaps;
        }
    }
    false
}

/// Brackets the deepest of some overlaps; `None` where none has a depth.
pub(crate) fn deepest(reports: &[PairReport]) -> Option<DepthBracket> {
    max_bracket(reports.iter().filter_map(PairReport::max_depth))
}

/// Brackets the sum of the depths of all overlaps, of surfaces.
pub(crate) fn total_depth(reports: &[PairReport]) -> DepthBracket {
    let mut total = DepthBracket::default();
    for depth in reports.iter().filter_map(PairReport::max_depth) {
        total.lower += depth.lower;
        total.upper += depth.upper;
    }
    total
}

/// Brackets the largest of some depths.
pub(crate) fn max_bracket(depths: impl Iterator<Item = DepthBracket>) -> Option<DepthBracket> {
    depths.reduce(|p, q| DepthBracket { lower: p.lower.max(q.lower), upper: p.upper.max(q.upper) })
}

impl BodyChange {
    /// Compares all bodies of a scene with their tissues at rest.
    pub(crate) fn list(
        scene: &Scene,
        tissues: &[Tissue],
        progress: Progress<'_>,
    ) -> Result<Vec<Self>, Interrupted> {
        let new = |i| Self::new(&tissues[i], fitted_tree(&scene.bodies()[i]), progress);
        parallel::map(tissues.len(), new).into_iter().collect()
    }

    /// Measures the change of a body from its positions at the `start` to its present ones, such as those that a
    /// file holds: [`Resolution::bodies`] are of the positions that overlap removal has led to.
    ///
    /// # Errors
    ///
    /// [`ResolveError::Scene`] for a body of another scene, and for positions that do not fit it;
    /// [`ResolveError::Interrupted`] when the handler of `progress` ends the call.
    pub fn since(
        scene: &mut Scene,
        body: BodyId,
        start: &[DVec3],
        progress: Progress<'_>,
    ) -> Result<Self, ResolveError> {
        scene.fit_all()?;
        let (id, body) = (body, scene.get(body)?);
        let mut at_start = Scene::new();
        at_start.add(body.name(), body.kind(), body.surface().clone(), start.to_vec())?;
        at_start.fit_all()?;

        // Parameters change nothing of what is measured.
        let params = ResolveParams::with_smoothing(1.0);
        let tree = fitted_tree(&at_start.bodies()[0]);
        let tissue = Tissue::new(id, body.is_rigid(), tree, &params);
        Ok(Self::new(&tissue, fitted_tree(body), progress)?)
    }

    fn new(
        tissue: &Tissue,
        tree: &SurfaceTree,
        progress: Progress<'_>,
    ) -> Result<Self, Interrupted> {
        // Displacements from the start.
        let x = tree.positions().as_slice();
        let (mut displacements, mut moved) = (Vec::with_capacity(x.len()), 0);
        for (x, rest) in x.iter().zip(&tissue.rest) {
            displacements.push(*x - *rest);
            moved += usize::from(x != rest);
        }

        // Shape: volume, faces that turned over, and crossings of the body with itself.
        let crossings = tree.self_crossings(&mut Workspace::default(), progress)?.len();
        let crossings_at_rest = match moved {
            0 => crossings,
            _ => self_crossings_at(&tissue.rest, tree, progress)?.len(),
        };
        Ok(Self {
            body: tissue.id,
            displacements,
            moved,
            max_displacement: tissue.max_displacement(x),
            strain: tissue.strain(x),
            volume_ratio: tissue.volume.map(|volume| tissue.volume_at(x) / volume),
            flipped_faces: tissue.count_flipped(x),
            self_crossings: [crossings_at_rest, crossings],
        })
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use scene::BodyKind;

    use super::*;

    #[test]
    fn pairs_within_the_tolerance_may_remain() {
        let mut scene = Scene::new();
        let [a, b] = ["a", "b"].map(|name| {
            let cube = shapes::cube(1.0);
            scene.add(name, BodyKind::Deformable, cube.surface(), cube.positions).expect("a cube")
        });
        let pair = PairId::new(a, b);
        let (crossing_faces, obstacle) = (2, Obstacle::Rounds);
        let left = |depth: f64, at_first| {
            // A bracket that may hold more than the tolerance is not within it.
            let depth = DepthBracket { lower: 0.5 * depth, upper: depth };
            Remaining { pair, depth, crossing_faces, at_first, obstacle }.is_within(0.05)
        };
        assert!(left(0.05, true));
        assert!(!left(0.06, true), "too deep");
        assert!(!left(0.01, false), "was not there at first");
        assert!(!left(0.0, true), "crosses, how deep cannot be told");
    }
}
