//! State of a scene after each round of overlap removal.

use scene::{DepthBracket, PairId};

use crate::ResolveParams;
use crate::count::as_f64;
use crate::near_pairs::NearPair;
use crate::tissue::Damage;

/// State of a scene at the start or after a round, without pairs of two rigid bodies, those that are left as
/// they are since no push has a side to take them to, and those that cross where they are tied, no deeper than half the
/// tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Round {
    /// Number of pairs whose faces cross, or with vertices inside.
    pub overlapping_pairs: usize,
    /// Number of crossing pairs of faces, over all pairs of bodies.
    pub crossing_faces: usize,
    /// Number of faces with all corners on another body that they do not cross: pairs that share faces
    /// come apart as overlaps do, for a gap or where they overlap between common corners.
    pub touching_faces: usize,
    /// Depth of the deepest vertex or crossing edge, by which rounds are compared.
    pub max_depth: f64,
    /// Depth of the deepest overlap, of surfaces: at the start, in the final round, and in rounds
    /// in which no vertex or edge exceeds the tolerance. `None` elsewhere, without overlaps, and
    /// where surfaces have no inside.
    pub surface_depth: Option<DepthBracket>,
    /// Number of pairs that overlap and did not at the start; those that shared faces then, where they
    /// are deeper than the tolerance.
    pub new_pairs: usize,
    /// Number of crossing pairs of faces of one body that did not cross at the start; counted
    /// once nothing overlaps.
    pub self_crossings: usize,
    /// Number of faces turned by a right angle or more.
    pub flipped_faces: usize,
    /// Number of [corners of cells](crate::CellCorners) that are flat.
    pub flat_corners: usize,
    /// Largest relative change of a soft body's volume.
    pub volume_change: f64,
    /// Weighted sum of overlaps, spoilt faces and lost volume, 0 where there are none. It falls from
    /// each accepted round to the next.
    pub merit: f64,
    /// True if the round is better than all accepted before, no pair overlaps anew in it, and no
    /// body is beyond its limits. The scene is given the last of these, and the best round if
    /// [`keep_going`](crate::ResolveParams::keep_going) asks for it. The start
    /// comes before either where no fewer pairs overlap than there, and deeper in all.
    pub is_accepted: bool,
}

impl Round {
    /// Summarizes the overlaps of a scene; what concerns single bodies is 0.
    ///
    /// Pairs that are new with their depth overlap anew.
    pub(crate) fn of_overlaps<'a>(
        overlapping: impl Iterator<Item = &'a NearPair>,
        is_new: impl Fn(PairId, f64) -> bool,
    ) -> Self {
        let mut round = Self::default();
        for pair in overlapping {
            round.overlapping_pairs += 1;
            round.crossing_faces += pair.report.crossing_faces.len();
            round.max_depth = round.max_depth.max(pair.depth());
            round.new_pairs += usize::from(is_new(pair.report.pair, pair.depth()));
        }
        round
    }

    /// Adds the damage to one body; self-crossings only where they are counted.
    pub(crate) fn add_damage(&mut self, damage: &Damage, counts_crossings: bool) {
        self.volume_change = self.volume_change.max(damage.volume_change);
        self.flipped_faces += damage.flipped_faces;
        self.flat_corners += damage.flat_corners;
        if counts_crossings {
            self.self_crossings += damage.self_crossings;
        }
    }

    /// Returns true if nothing overlaps or shares faces, and no shape is spoilt.
    pub(crate) fn is_clean(&self, params: &ResolveParams) -> bool {
        let left = self.overlapping_pairs + self.touching_faces + self.spoilt();
        left == 0 && self.excess_volume(params) <= 0.0
    }

    /// Returns true if nothing is left but crossings of bodies with themselves.
    pub(crate) fn only_crosses_itself(&self) -> bool {
        let spoilt = self.flipped_faces + self.flat_corners;
        let left = self.overlapping_pairs + self.touching_faces + spoilt;
        left == 0 && self.max_depth <= 0.0 && self.self_crossings > 0
    }

    /// Returns true if no overlap exceeds the tolerance and none is new.
    pub(crate) fn is_within(&self, tolerance: f64) -> bool {
        let is_shallow = self.surface_depth.is_none_or(|depth| depth.upper <= tolerance);
        self.max_depth <= tolerance && is_shallow && self.new_pairs == 0
    }

    /// Returns true if this round has left less than another one. What overlaps anew is never
    /// better than what does not.
    pub(crate) fn is_better_than(&self, other: &Self) -> bool {
        let [is_new, was_new] = [self, other].map(|round| round.new_pairs > 0);
        if is_new == was_new { self.merit < other.merit } else { was_new }
    }

    /// Computes the [merit](Self::merit) of what the round has left.
    pub(crate) fn weigh(&self, params: &ResolveParams) -> f64 {
        let faces = self.crossing_faces + self.touching_faces + self.spoilt();
        self.max_depth / params.tolerance * as_f64(self.overlapping_pairs)
            + params.tuning.face_weight * as_f64(faces)
            + self.excess_volume(params)
    }

    /// Counts what is spoilt: crossings of bodies with themselves, faces turned over, and flat corners of cells.
    fn spoilt(&self) -> usize {
        self.self_crossings + self.flipped_faces + self.flat_corners
    }

    fn excess_volume(&self, params: &ResolveParams) -> f64 {
        (self.volume_change - params.volume_tolerance()).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_without_new_overlaps_are_better_than_any_with() {
        let round = |new_pairs, merit| Round { new_pairs, merit, ..Round::default() };
        let ascending = [round(0, 1.0), round(0, 2.0), round(1, 0.5), round(3, 0.7)];
        for (number, better) in ascending.iter().enumerate() {
            for worse in &ascending[number + 1..] {
                assert!(better.is_better_than(worse) && !worse.is_better_than(better));
            }
        }
    }

    #[test]
    fn what_is_spoilt_is_not_clean_and_weighs() {
        let params = ResolveParams::with_smoothing(6.0);
        assert!(Round::default().is_clean(&params));
        for round in [
            Round { self_crossings: 1, ..Round::default() },
            Round { flipped_faces: 1, ..Round::default() },
            Round { flat_corners: 1, ..Round::default() },
        ] {
            assert!(!round.is_clean(&params) && round.weigh(&params) > 0.0, "{round:?}");
        }
    }

    #[test]
    fn what_else_is_left_is_no_crossing_of_a_body_with_itself() {
        let crossing = Round { self_crossings: 2, ..Round::default() };
        assert!(crossing.only_crosses_itself() && !Round::default().only_crosses_itself());
        for other in [
            Round { overlapping_pairs: 1, ..crossing },
            Round { touching_faces: 1, ..crossing },
            Round { flipped_faces: 1, ..crossing },
            Round { flat_corners: 1, ..crossing },
            Round { max_depth: 0.1, ..crossing },
        ] {
            assert!(!other.only_crosses_itself(), "{other:?}");
        }
    }
}
