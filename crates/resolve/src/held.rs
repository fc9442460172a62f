//! Pairs and bodies that would hold up all others: pairs that no push takes apart are left as they are, and
//! bodies that leave their limits are held where they were.

use std::collections::BTreeMap;

use scene::{BodyId, PairId, Scene};

use crate::attempts::Attempts;
use crate::exempt::Exempt;
use crate::{BrokenLimit, GapObstacle, Obstacle, Remaining, Resolution, ResolveError};

/// Attempts with ever more pairs left or bodies held. Below, one that holds up others is not found where there
/// are several; above, scenes that cannot be freed take longer.
const MAX_ATTEMPTS: usize = 4;

impl Attempts<'_> {
    /// Removes overlaps with the pairs left as they are that an end names as having no side to be pushed to, if that
    /// leaves less.
    pub(crate) fn leave_sideless(&mut self) -> Result<(), ResolveError> {
        let sideless = Exempt { pairs: self.end.sideless_pairs(), ..self.exempt.clone() };
        if !sideless.pairs.is_empty() && self.end.is_left_without(&sideless) {
            self.try_exempting(&sideless)?;
        }
        Ok(())
    }

    /// Removes overlaps with the pairs left as they are that no round freed, as those of a muscle without room, if that
    /// leaves less: where it is pushed out into others, no round is accepted, however many pairs are free in it. With more
    /// of them as long as rounds free others.
    pub(crate) fn leave_unfreed(&mut self) -> Result<(), ResolveError> {
        let (mut tried, mut worse) = (self.exempt.clone(), None);
        for _ in 0..MAX_ATTEMPTS {
            let last = worse.as_ref().unwrap_or(&self.end);
            let unfreed = last.unfreed_pairs(self.scene, &tried);
            tried.pairs.extend(&unfreed);
            let frees_others = last.frees_less_than_a_round() && self.end.is_left_without(&tried);
            if unfreed.is_empty() || !frees_others {
                break;
            }
            worse = self.try_exempting(&tried)?;
        }
        Ok(())
    }

    /// Removes overlaps with the pairs of soft bodies left as they are that remain, as that of a muscle that is there
    /// twice, if that leaves less: they hold up others. Returns the limits that bodies of theirs would break.
    pub(crate) fn leave_soft_pairs(&mut self) -> Result<Vec<BrokenLimit>, ResolveError> {
        let soft = self.end.soft_pairs(self.scene);
        let pairs = [&self.exempt.pairs[..], &soft].concat();
        let with_soft = Exempt { pairs, ..self.exempt.clone() };
        let keeps_going = self.start.params.keep_going;
        if keeps_going || soft.is_empty() || !self.end.is_left_without(&with_soft) {
            return Ok(Vec::new());
        }
        let mut broken = self.end.broken_limits.clone();
        broken.retain(|limit| soft.iter().any(|pair| pair.bodies().contains(&limit.body)));
        let worse = self.try_exempting(&with_soft)?;
        Ok(if worse.is_none() { broken } else { Vec::new() })
    }

    /// Removes overlaps with the bodies held that left their limits, which would else hold up all others, if that leaves
    /// less; again with others that leave theirs then, and pairs that no round frees.
    pub(crate) fn hold_broken(&mut self) -> Result<(), ResolveError> {
        // Limits that bodies left in ends that were no better, and why pairs were left there.
        let (mut beyond, mut obstacles) = (Vec::new(), BTreeMap::new());
        let mut tried = self.exempt.clone();
        let keeps_going = self.start.params.keep_going;
        let mut has_more = !keeps_going && self.end.add_broken_bodies(&mut tried.bodies);
        for _ in 0..MAX_ATTEMPTS {
            if !has_more || !self.end.is_left_without(&tried) {
                break;
            }
            let worse = self.try_exempting(&tried)?;
            for left in &mut self.end.remaining {
                left.obstacle = *obstacles.get(&left.pair).unwrap_or(&left.obstacle);
            }
            let last = worse.as_ref().unwrap_or(&self.end);
            has_more = last.add_next(self.scene, &mut tried);
            for left in last.remaining.iter().filter(|left| tried.pairs.contains(&left.pair)) {
                obstacles.entry(left.pair).or_insert(left.obstacle);
            }
            if let Some(worse) = worse {
                beyond.extend(worse.broken_limits);
            } else if !self.end.resolved {
                self.end.list_before(std::mem::take(&mut beyond));
            }
        }
        Ok(())
    }

    /// Removes overlaps with some bodies held and pairs left as they are, and so in further attempts where that leaves
    /// less; else returns that end.
    fn try_exempting(&mut self, exempt: &Exempt) -> Result<Option<Resolution>, ResolveError> {
        let worse = self.try_again(self.start.params, exempt)?;
        if worse.is_none() {
            self.exempt.clone_from(exempt);
        }
        Ok(worse)
    }
}

impl Resolution {
    /// Counts the pairs that overlap or are nearer than the gap.
    pub(crate) fn left(&self) -> usize {
        self.remaining.len() + self.gap.short.len()
    }

    /// Lists limits that bodies leave in other ends before those of this one, each body once.
    pub(crate) fn list_before(&mut self, limits: Vec<BrokenLimit>) {
        for limit in limits.into_iter().rev() {
            if self.broken_limits.iter().all(|listed| listed.body != limit.body) {
                self.broken_limits.insert(0, limit);
            }
        }
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

    /// Lists the pairs that no round freed and that are not exempt, of those that overlapped at the start: those with a
    /// rigid body, or else the others, or else all of soft bodies that a round has pressed into others.
    fn unfreed_pairs(&self, scene: &Scene, exempt: &Exempt) -> Vec<PairId> {
        let (mut with_rigid, mut soft, mut around) = (Vec::new(), Vec::new(), Vec::new());
        for Remaining { pair, at_first, .. } in &self.remaining {
            if !*at_first || exempt.concerns(*pair) {
                continue;
            }
            let is_moved = |body: &BodyId| {
                let is_unfreed = self.unfreed.iter().any(|unfreed| unfreed.contains(*body));
                is_unfreed && !scene.body(*body).is_rigid()
            };
            if pair.bodies().iter().any(is_moved) {
                around.push(*pair);
            }
            if self.unfreed.contains(pair) {
                let has_rigid = pair.bodies().iter().any(|body| scene.body(*body).is_rigid());
                if has_rigid { with_rigid.push(*pair) } else { soft.push(*pair) }
            }
        }
        let lists = [with_rigid, soft, around];
        lists.into_iter().find(|pairs| !pairs.is_empty()).unwrap_or_default()
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

    /// Adds what held up others in this end: the bodies beyond their limits, or where there are none, pairs that no
    /// round freed. Returns true if there is any.
    fn add_next(&self, scene: &Scene, exempt: &mut Exempt) -> bool {
        if self.add_broken_bodies(&mut exempt.bodies) {
            return true;
        }
        let mut unfreed = Vec::new();
        if self.frees_less_than_a_round() {
            unfreed = self.unfreed_pairs(scene, exempt);
        }
        exempt.pairs.extend(&unfreed);
        !unfreed.is_empty()
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
            } else if !self.resolved && exempt.concerns(left.pair) && !left.obstacle.is_of_room() {
                left.obstacle = Obstacle::Limits;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use glam::DVec3;
    use scene::BodyKind;
    use surface::progress::Progress;

    use super::*;
    use crate::ResolveParams;

    /// A bone in two muscles, which overlap each other and are beside a third one.
    #[test]
    fn pairs_that_no_round_frees_are_left_before_those_of_bodies_that_are_pressed_into_others() {
        let ball = |x: f64| shapes::icosphere(2.0, 2).translated(DVec3::X * x);
        let mut scene = Scene::new();
        let bodies = [("bone", 0.0), ("left", -1.5), ("right", 1.5), ("beside", 5.6)];
        for (number, (name, x)) in bodies.into_iter().enumerate() {
            let kind = if number == 0 { BodyKind::Rigid } else { BodyKind::Deformable };
            scene.add(name, kind, ball(x).surface(), ball(x).positions).expect("a body");
        }
        let [bone, left, right, beside] = bodies.map(|(name, _)| scene.find(name).expect("a body"));
        let params = ResolveParams { max_rounds: 0, ..ResolveParams::with_smoothing(1.0) };
        let mut end = crate::resolve(&mut scene, &params, Progress::none()).expect("a resolution");
        let pairs = [PairId::new(bone, left), PairId::new(bone, right), PairId::new(left, right)];
        let at_first: Vec<PairId> = end.remaining.iter().map(|left| left.pair).collect();
        assert_eq!(at_first, pairs);

        // Those with bones, then others, then what a body that was pressed into another one had at first.
        let [_, bone_right, soft] = pairs;
        let mut next = |unfreed: &[PairId], exempt: &[PairId]| {
            end.unfreed = unfreed.to_vec();
            end.unfreed_pairs(&scene, &Exempt { pairs: exempt.to_vec(), ..Exempt::NONE })
        };
        assert_eq!(next(&[bone_right, soft], &[]), [bone_right]);
        assert_eq!(next(&[bone_right, soft], &[bone_right]), [soft]);
        let anew = PairId::new(right, beside);
        assert_eq!(next(&[anew], &[soft]), [bone_right]);
        assert_eq!(next(&[anew], &[bone_right, soft]), []);

        // Pairs of bodies that are held are left with them.
        let mut held = Exempt { bodies: vec![left], ..Exempt::NONE };
        end.unfreed = vec![anew];
        assert!(end.add_next(&scene, &mut held));
        assert_eq!((held.bodies.len(), &held.pairs[..]), (1, &[bone_right][..]));
        assert!(!end.add_next(&scene, &mut held));
    }
}
