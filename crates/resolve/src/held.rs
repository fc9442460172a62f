//! Bodies that leave their limits, which are held where they were, so that all others come free.

use glam::DVec3;
use scene::{BodyId, PairId, Scene};
use surface::progress::Progress;

use crate::resolver::{move_soft_bodies, soft_positions};
use crate::{BrokenLimit, GapObstacle, Obstacle, Resolution, ResolveError, Resolver};

impl Resolver {
    /// Removes overlaps with the bodies held that left their limits, which would else hold up all others;
    /// again as long as other bodies leave theirs, and less is left.
    pub(crate) fn hold_broken(
        &mut self,
        scene: &mut Scene,
        mut resolution: Resolution,
        rest: &[Vec<DVec3>],
        progress: Progress<'_>,
    ) -> Result<Resolution, ResolveError> {
        let mut held = Vec::new();
        while !self.params.keep_going
            && resolution.add_broken_bodies(&mut held)
            && resolution.is_left_without(&held)
        {
            let (last_carried, last_end) =
                (std::mem::take(&mut self.carried), soft_positions(scene));
            move_soft_bodies(scene, rest)?;
            let before = Some(&resolution.before[..]);
            let mut next = self.attempt(self.params, scene, &[], &held, before, progress)?;
            if next.left() >= resolution.left() {
                self.carried = last_carried;
                move_soft_bodies(scene, &last_end)?;
                return Ok(resolution);
            }
            if !next.resolved {
                next.add_held(&held, resolution.broken_limits);
            }
            resolution = next;
        }
        Ok(resolution)
    }
}

impl Resolution {
    /// Counts the pairs that overlap or are nearer than the gap.
    pub(crate) fn left(&self) -> usize {
        self.remaining.len() + self.gap.short.len()
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

    /// Returns true if a pair is left of bodies that are not held, one of which may move.
    fn is_left_without(&self, held: &[BodyId]) -> bool {
        let is_other = |pair: PairId| pair.bodies().iter().all(|body| !held.contains(body));
        let mut is_left = false;
        for left in &self.remaining {
            is_left |= is_other(left.pair) && left.obstacle != Obstacle::BothRigid;
        }
        for short in &self.gap.short {
            is_left |= is_other(short.pair) && short.obstacle != GapObstacle::BothRigid;
        }
        is_left
    }

    /// Adds what held bodies break where they are not held, and names that where their pairs are left.
    fn add_held(&mut self, held: &[BodyId], broken: Vec<BrokenLimit>) {
        for left in &mut self.remaining {
            if matches!(left.obstacle, Obstacle::Squeezed { .. }) {
                continue;
            }
            if left.pair.bodies().iter().any(|body| held.contains(body)) {
                left.obstacle = Obstacle::Limits;
            }
        }
        self.broken_limits.splice(0..0, broken);
    }
}
