//! Pairs and bodies that would hold up all others: pairs that no push takes apart are left as they are, and
//! bodies that leave their limits are held where they were.

use glam::DVec3;
use scene::{BodyId, PairId, Scene};
use surface::progress::Progress;

use crate::exempt::Exempt;
use crate::resolver::{move_soft_bodies, soft_positions};
use crate::{BrokenLimit, GapObstacle, Obstacle, Remaining, Resolution, ResolveError, Resolver};

impl Resolver {
    /// Removes overlaps with the pairs left as they are that an end names as having no side to be pushed to, if that
    /// leaves less; `exempt` has these pairs then.
    pub(crate) fn leave_sideless(
        &mut self,
        scene: &mut Scene,
        end: Resolution,
        rest: &[Vec<DVec3>],
        exempt: &mut Exempt,
        progress: Progress<'_>,
    ) -> Result<Resolution, ResolveError> {
        let sideless = Exempt { pairs: end.sideless_pairs(), ..Exempt::NONE };
        if sideless.pairs.is_empty() || !end.is_left_without(&sideless) {
            return Ok(end);
        }
        let (end, is_better) = self.exempting(scene, end, rest, &sideless, progress)?;
        if is_better {
            *exempt = sideless;
        }
        Ok(end)
    }

    /// Removes overlaps with the pairs left as they are that no round freed, as those of a muscle without room, if that
    /// leaves less: where it is pushed out into others, no round is accepted, however many pairs are free in it. Again
    /// as long as it does; `exempt` has these pairs then, too.
    pub(crate) fn leave_unfreed(
        &mut self,
        scene: &mut Scene,
        mut end: Resolution,
        rest: &[Vec<DVec3>],
        exempt: &mut Exempt,
        progress: Progress<'_>,
    ) -> Result<Resolution, ResolveError> {
        // Pairs of two soft bodies only where leaving those with a rigid one is not enough.
        let mut with_soft = false;
        while end.frees_less_than_a_round() {
            let unfreed = end.unfreed_pairs(scene, exempt, with_soft);
            let with_unfreed =
                Exempt { pairs: [&exempt.pairs[..], &unfreed].concat(), ..exempt.clone() };
            let mut is_better = false;
            if !unfreed.is_empty() && end.is_left_without(&with_unfreed) {
                (end, is_better) = self.exempting(scene, end, rest, &with_unfreed, progress)?;
            }
            if is_better {
                *exempt = with_unfreed;
            } else if with_soft {
                break;
            }
            with_soft = !is_better;
        }
        Ok(end)
    }

    /// Removes overlaps with the pairs of soft bodies left as they are that remain, as that of a muscle that is there
    /// twice, if that leaves less: they hold up others. `exempt` has these pairs then, too. Returns the limits that
    /// bodies of theirs would break.
    pub(crate) fn leave_soft_pairs(
        &mut self,
        scene: &mut Scene,
        end: Resolution,
        rest: &[Vec<DVec3>],
        exempt: &mut Exempt,
        progress: Progress<'_>,
    ) -> Result<(Resolution, Vec<BrokenLimit>), ResolveError> {
        let soft = end.soft_pairs(scene);
        let with_soft = Exempt { pairs: [&exempt.pairs[..], &soft].concat(), ..exempt.clone() };
        if self.params.keep_going || soft.is_empty() || !end.is_left_without(&with_soft) {
            return Ok((end, Vec::new()));
        }
        let mut broken = end.broken_limits.clone();
        broken.retain(|limit| soft.iter().any(|pair| pair.bodies().contains(&limit.body)));
        let (end, is_better) = self.exempting(scene, end, rest, &with_soft, progress)?;
        if !is_better {
            return Ok((end, Vec::new()));
        }
        *exempt = with_soft;
        Ok((end, broken))
    }

    /// Removes overlaps with the bodies held that left their limits, which would else hold up all others;
    /// again as long as other bodies leave theirs, and less is left.
    pub(crate) fn hold_broken(
        &mut self,
        scene: &mut Scene,
        mut resolution: Resolution,
        rest: &[Vec<DVec3>],
        mut exempt: Exempt,
        progress: Progress<'_>,
    ) -> Result<Resolution, ResolveError> {
        let mut is_better = true;
        while is_better
            && !self.params.keep_going
            && resolution.add_broken_bodies(&mut exempt.bodies)
            && resolution.is_left_without(&exempt)
        {
            (resolution, is_better) = self.exempting(scene, resolution, rest, &exempt, progress)?;
        }
        Ok(resolution)
    }

    /// Removes overlaps with some bodies held and pairs left as they are; takes the scene back to an earlier end, and
    /// returns that one, where no less is left. Returns true if less is.
    fn exempting(
        &mut self,
        scene: &mut Scene,
        end: Resolution,
        rest: &[Vec<DVec3>],
        exempt: &Exempt,
        progress: Progress<'_>,
    ) -> Result<(Resolution, bool), ResolveError> {
        let (last_carried, last_end) = (std::mem::take(&mut self.carried), soft_positions(scene));
        move_soft_bodies(scene, rest)?;
        let before = Some(&end.before[..]);
        let mut next = self.attempt(self.params, scene, &[], exempt, before, progress)?;
        if next.left() >= end.left() {
            self.carried = last_carried;
            move_soft_bodies(scene, &last_end)?;
            return Ok((end, false));
        }
        next.name_exempt(exempt, &end);
        if !next.resolved && !exempt.bodies.is_empty() {
            next.broken_limits.splice(0..0, end.broken_limits);
        }
        Ok((next, true))
    }
}

impl Resolution {
    /// Counts the pairs that overlap or are nearer than the gap.
    pub(crate) fn left(&self) -> usize {
        self.remaining.len() + self.gap.short.len()
    }

    /// Lists the pairs that are left for want of a side to be pushed to.
    fn sideless_pairs(&self) -> Vec<PairId> {
        let mut pairs = Vec::new();
        for left in &self.remaining {
            if left.obstacle.is_sideless() {
                pairs.push(left.pair);
            }
        }
        pairs
    }

    /// Returns true if a round left fewer pairs, and no body's limits are why it was not accepted.
    fn frees_less_than_a_round(&self) -> bool {
        self.broken_limits.is_empty() && self.unfreed.len() < self.remaining.len()
    }

    /// Lists the pairs that no round freed and that are not exempt, of those that overlapped at the start; those of two
    /// soft bodies only `with_soft`.
    fn unfreed_pairs(&self, scene: &Scene, exempt: &Exempt, with_soft: bool) -> Vec<PairId> {
        let mut pairs = Vec::new();
        for Remaining { pair, at_first, .. } in &self.remaining {
            let has_rigid = pair.bodies().iter().any(|body| scene.body(*body).is_rigid());
            let is_unfreed = *at_first && self.unfreed.contains(pair);
            if is_unfreed && !exempt.pairs.contains(pair) && (has_rigid || with_soft) {
                pairs.push(*pair);
            }
        }
        pairs
    }

    /// Lists the pairs of two soft bodies that are left: those with the most bodies beyond limits, since an earlier
    /// state is kept where there are any, in which others still overlap.
    fn soft_pairs(&self, scene: &Scene) -> Vec<PairId> {
        let (mut pairs, mut broken, mut most) = (Vec::new(), Vec::new(), 0);
        self.add_broken_bodies(&mut broken);
        for Remaining { pair, .. } in &self.remaining {
            let bodies = pair.bodies();
            if bodies.iter().any(|body| scene.body(*body).is_rigid()) {
                continue;
            }
            let count = bodies.iter().filter(|body| broken.contains(body)).count();
            if count > most {
                most = count;
                pairs.clear();
            }
            if count == most {
                pairs.push(*pair);
            }
        }
        pairs
    }

    /// Adds the bodies that are beyond their limits to `held`; returns true if it did not have them all.
    fn add_broken_bodies(&self, held: &mut Vec<BodyId>) -> bool {
        let before = held.len();
        for BrokenLimit { body, .. } in &self.broken_limits {
            if !held.contains(body) {
                held.push(*body);
            }
        }
        held.len() > before
    }

    /// Returns true if a pair is left that is not exempt, nor of bodies that are, and one of which may move.
    pub(crate) fn is_left_without(&self, exempt: &Exempt) -> bool {
        let mut is_left = false;
        for left in &self.remaining {
            is_left |= !exempt.concerns(left.pair) && left.obstacle != Obstacle::BothRigid;
        }
        for short in &self.gap.short {
            is_left |= !exempt.concerns(short.pair) && short.obstacle != GapObstacle::BothRigid;
        }
        is_left
    }

    /// Names why exempt pairs are left, as the end does that they were in before: pairs by their own obstacle, those
    /// of held bodies by the limits that these break where they are not held.
    pub(crate) fn name_exempt(&mut self, exempt: &Exempt, before: &Self) {
        for left in &mut self.remaining {
            if exempt.pairs.contains(&left.pair) {
                let mut known = before.remaining.iter();
                if let Some(known) = known.find(|known| known.pair == left.pair) {
                    left.obstacle = known.obstacle;
                }
            } else if !self.resolved
                && exempt.concerns(left.pair)
                && !matches!(left.obstacle, Obstacle::Squeezed { .. })
            {
                left.obstacle = Obstacle::Limits;
            }
        }
    }
}

impl Obstacle {
    /// Returns true if no push has a side to take a pair to.
    fn is_sideless(self) -> bool {
        matches!(self, Self::Enclosed | Self::Pierced | Self::NearlyCoincident)
    }
}
