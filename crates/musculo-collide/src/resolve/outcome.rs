//! What a resolution did, and what it left.

use glam::DVec3;
use kdop::Workspace;
use surface::Contact;

use super::sight::Sight;
use super::tissue::{Tissue, volume};
use super::{ResolveParams, guard};
use crate::scene::Body;
use crate::{BodyId, BodyKind, PairReport, Scene, parallel};

/// Change of a volume, as a share, after which rounds go on to give it back:
/// below what is promised, by what the last pushes may take.
pub(super) const ALLOWED_VOLUME_CHANGE: f64 = 0.008;

/// How things stood after a round.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Round {
    /// Pairs that overlapped.
    pub overlapping_pairs: usize,
    /// Pairs of faces that crossed, of all pairs together.
    pub crossing_faces: usize,
    /// Depth of the deepest overlap, of vertices or of edges.
    pub max_depth: f64,
    /// Pairs that overlapped and did not at first.
    pub new_pairs: usize,
    /// Pairs of faces of one body that crossed though they did not at first;
    /// looked for only once bodies are apart.
    pub self_crossings: usize,
    /// Faces that were turned by a right angle or more.
    pub flipped_faces: usize,
    /// Largest change of a soft body's volume, as a share.
    pub volume_change: f64,
}

/// What became of one body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyChange {
    /// Which body.
    pub body: BodyId,
    /// From where each vertex was at first to where it is.
    pub displacements: Vec<DVec3>,
    /// Vertices that moved at all.
    pub moved: usize,
    /// Length of the longest displacement.
    pub max_displacement: f64,
    /// Volume now over volume at first; `None` where the body has no inside.
    pub volume_ratio: Option<f64>,
    /// Faces that were turned by a right angle or more.
    pub flipped_faces: usize,
    /// Pairs of the body's own faces that cross, at first and now.
    pub self_crossings: [usize; 2],
}

/// Why a pair still overlaps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Obstacle {
    /// Neither body may move.
    #[error("both are rigid")]
    BothRigid,
    /// No push made anything better any more.
    #[error(
        "no push helped any more: there is no room to yield to, or the way there is too far at once"
    )]
    Stuck,
    /// The rounds were over before they were apart.
    #[error("still yielding when the rounds were over: more may part them")]
    Rounds,
}

/// A pair that still overlaps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Remaining {
    /// The first body.
    pub a: BodyId,
    /// The second body.
    pub b: BodyId,
    /// How deep, by vertices or by edges; 0 where only edges cross, too steeply
    /// for a depth to be told.
    pub depth: f64,
    /// Pairs of faces that cross.
    pub crossing_faces: usize,
    /// Whether the pair overlapped at first.
    pub at_first: bool,
    /// Why.
    pub obstacle: Obstacle,
}

/// What a resolution did.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolution {
    /// Every pair within the margin at first.
    pub before: Vec<PairReport>,
    /// Every pair within the margin now.
    pub after: Vec<PairReport>,
    /// How things stood at first and after each round.
    pub rounds: Vec<Round>,
    /// All bodies, in their order.
    pub bodies: Vec<BodyChange>,
    /// Pairs that still overlap, the deepest first; those within the tolerance
    /// included.
    pub remaining: Vec<Remaining>,
    /// Whether no pair overlaps by more than the tolerance, and none that did
    /// not overlap at first.
    pub resolved: bool,
}

impl Round {
    pub(super) fn new(now: &Sight, before: &[PairReport]) -> Self {
        let overlapping = || now.pairs.iter().zip(&now.edges).filter(|(pair, _)| pair.overlaps);
        Self {
            overlapping_pairs: overlapping().count(),
            crossing_faces: overlapping().map(|(pair, _)| pair.crossing_faces.len()).sum(),
            max_depth: overlapping().map(|(pair, edges)| depth(pair, edges)).fold(0.0, f64::max),
            new_pairs: overlapping().filter(|(pair, _)| !overlapped(pair, before)).count(),
            self_crossings: 0,
            flipped_faces: 0,
            volume_change: 0.0,
        }
    }

    /// Whether there is nothing more to do.
    pub(super) fn is_clean(&self) -> bool {
        let spoilt = self.self_crossings + self.flipped_faces > 0 || self.excess_volume() > 0.0;
        self.overlapping_pairs == 0 && !spoilt
    }

    fn excess_volume(&self) -> f64 {
        (self.volume_change - ALLOWED_VOLUME_CHANGE).max(0.0)
    }

    /// Whether bodies overlap less deep, measured in what is tolerated, or fewer
    /// of them, weighing both.
    pub(super) fn is_better_than(&self, other: &Self, tolerance: f64) -> bool {
        let badness = |round: &Self| {
            let pairs = round.overlapping_pairs + 2 * round.new_pairs;
            // A face that was turned over counts as ten that cross, and so do two of a body;
            // a fiftieth of what is tolerated, in one pair, as one.
            let crossings =
                round.crossing_faces + 10 * (round.self_crossings + round.flipped_faces);
            let count = |n: usize| f64::from(u32::try_from(n).unwrap_or(u32::MAX));
            round.max_depth / (20.0 * tolerance) * count(pairs)
                + 1e-3 * count(crossings)
                + round.excess_volume()
        };
        badness(self) < badness(other)
    }
}

impl Resolution {
    pub(super) fn new(
        scene: &Scene,
        params: &ResolveParams,
        tissues: &[Tissue],
        [before, after]: [Vec<PairReport>; 2],
        now: &Sight,
        (rounds, stuck): (Vec<Round>, bool),
    ) -> Self {
        let mut remaining: Vec<Remaining> = now
            .pairs
            .iter()
            .zip(&now.edges)
            .filter(|(pair, _)| pair.overlaps)
            .map(|(pair, edges)| Remaining::new(scene, pair, edges, &before, stuck))
            .collect();
        remaining.sort_by(|p, q| q.depth.total_cmp(&p.depth));
        let resolved = remaining.iter().all(|pair| pair.is_within(params.tolerance));
        let bodies: Vec<_> = scene.ids().zip(tissues).collect();
        let bodies = parallel::map_with(&bodies, Workspace::default, |traversal, &(id, tissue)| {
            BodyChange::new(id, scene.body(id), tissue, traversal)
        });
        Self { before, after, rounds, bodies, remaining, resolved }
    }
}

impl Remaining {
    fn new(
        scene: &Scene,
        pair: &PairReport,
        edges: &[Contact],
        before: &[PairReport],
        stuck: bool,
    ) -> Self {
        let rigid = |id: BodyId| scene.body(id).kind() == BodyKind::Rigid;
        let obstacle = match stuck {
            _ if rigid(pair.a) && rigid(pair.b) => Obstacle::BothRigid,
            true => Obstacle::Stuck,
            false => Obstacle::Rounds,
        };
        Self {
            a: pair.a,
            b: pair.b,
            depth: depth(pair, edges),
            crossing_faces: pair.crossing_faces.len(),
            at_first: overlapped(pair, before),
            obstacle,
        }
    }

    /// Whether a pair may be left as it is. One that did not overlap at first
    /// may not, nor one of which the edges cross too steeply for a depth to be
    /// told: that is not within any tolerance.
    fn is_within(&self, tolerance: f64) -> bool {
        self.at_first && self.depth > 0.0 && self.depth <= tolerance
    }
}

impl BodyChange {
    fn new(id: BodyId, body: &Body, tissue: &Tissue, traversal: &mut Workspace) -> Self {
        let (surface, x) = (body.surface(), body.positions());
        let displacements: Vec<DVec3> =
            x.iter().zip(&tissue.rest).map(|(x, rest)| *x - *rest).collect();
        let moved = displacements.iter().filter(|u| **u != DVec3::ZERO).count();
        let crossings =
            [&tissue.rest[..], x].map(|x| guard::self_crossings(body, x, traversal).len());
        Self {
            body: id,
            moved,
            max_displacement: displacements.iter().map(|u| u.length()).fold(0.0, f64::max),
            volume_ratio: body
                .has_inside()
                .is_ok()
                .then(|| volume(surface.faces(), x) / tissue.volume),
            flipped_faces: guard::flipped(surface, tissue, x),
            self_crossings: crossings,
            displacements,
        }
    }
}

/// How deep a pair's bodies are in each other, by vertices or by edges.
fn depth(pair: &PairReport, edges: &[Contact]) -> f64 {
    edges.iter().map(|contact| -contact.gap).fold(pair.max_depth, f64::max)
}

fn overlapped(pair: &PairReport, before: &[PairReport]) -> bool {
    before.iter().any(|first| first.overlaps && (first.a, first.b) == (pair.a, pair.b))
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;

    use super::*;

    #[test]
    fn what_may_be_left() {
        let mut scene = Scene::new();
        let [a, b] = ["a", "b"].map(|name| {
            let cube = shapes::cube(1.0);
            scene.add(name, BodyKind::Deformable, cube.surface(), cube.positions).expect("a cube")
        });
        let (crossing_faces, obstacle) = (2, Obstacle::Rounds);
        let left = |depth, at_first| {
            Remaining { a, b, depth, crossing_faces, at_first, obstacle }.is_within(0.05)
        };
        assert!(left(0.05, true));
        assert!(!left(0.06, true), "too deep");
        assert!(!left(0.01, false), "was not there at first");
        assert!(!left(0.0, true), "crosses, how deep cannot be told");
    }
}
