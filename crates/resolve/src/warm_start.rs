//! Warm start of overlap removal: displacements carried over from the state before.
//!
//! Where a bone has gone back, tissue follows it. Where a bone has gone through where tissue is at rest, tissue stays
//! before it, also if nothing overlaps at rest any more.

use crate::local_displacements::LocalDisplacements;
use crate::run::Run;
use crate::{Resolution, ResolveError};

impl Run<'_> {
    /// Returns the displacements of all bodies in local frames.
    pub(crate) fn local_displacements(&self) -> Vec<LocalDisplacements> {
        let mut displacements = Vec::new();
        for (tissue, body) in self.tissues.iter().zip(self.scene.bodies()) {
            displacements.push(LocalDisplacements::new(tissue, body.positions()));
        }
        displacements
    }

    /// Pushes bodies apart, displaced by `carried` first where that is better. An error puts soft bodies back.
    pub(crate) fn remove_overlaps(
        &mut self,
        carried: &[LocalDisplacements],
    ) -> Result<Resolution, ResolveError> {
        let result = self.warm_start(carried).and_then(|()| self.complete());
        if result.is_err() {
            self.restore()?;
        }
        result
    }

    /// Displaces tissue by `carried`, if there is any, where that is better than the state as it stands, or where
    /// tissue would have to pass through a bone to get there.
    fn warm_start(&mut self, carried: &[LocalDisplacements]) -> Result<(), ResolveError> {
        let is_rest_clean = self.rounds[0].is_clean(&self.params);
        let may_move = is_rest_clean || self.continues();
        if !may_move || carried.iter().all(LocalDisplacements::is_zero) {
            return Ok(());
        }

        // Carried displacements count as a round, and are taken back where more is left by them. That a
        // pair overlaps anew does not count: it comes out as any other.
        self.move_soft(|tissue, _| Some(carried[tissue.id.index()].displace(tissue)))?;
        if self.near.overlapping().next().is_none() {
            self.go_back()?;
        }
        self.record()?;
        self.is_warm = self.rounds[1].merit < self.rounds[0].merit || self.is_kept_off_rest();
        if !self.is_warm {
            self.revert_to_best()?;
            if is_rest_clean {
                // Nothing is to be done, and nothing counts.
                self.is_back_at_rest = true;
                self.rounds.truncate(1);
            }
            return Ok(());
        }

        // Displacements of the last state are within limits, and so is what is left to do from them, also where less
        // overlaps by itself: tissue would let a bone pass that is halfway through it.
        let carried = self.tissues.iter().map(|tissue| tissue.damage.max_displacement);
        let further = self.params.max_displacement * self.rounds[1].max_depth;
        let allowed = carried.fold(0.0, f64::max) + further;
        self.allowed_displacement = self.allowed_displacement.max(allowed);
        self.keep_as_best(1);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use fixtures::shapes;
    use glam::DVec3;
    use scene::BodyKind;

    use super::*;
    use crate::test_scenes::bone_and_muscle;
    use crate::{Conditions, ResolveParams};

    /// A muscle deep in a bone, and close above it another bone, which carried displacements press it into.
    #[test]
    fn displacements_are_carried_though_another_pair_overlaps_by_them() {
        let block = |z: f64| {
            shapes::plate(DVec3::new(20.0, 20.0, 4.0), [4, 4]).translated(DVec3::new(0.0, 0.0, z))
        };
        let muscle = shapes::ellipsoid(DVec3::new(8.0, 8.0, 4.0), 3).translated(3.0 * DVec3::Z);
        let mut scene = bone_and_muscle(block(0.0), muscle);
        let above = block(9.5);
        scene
            .add("above", BodyKind::Rigid, above.surface(), above.positions)
            .expect("a third body");

        for (up, is_kept) in [(3.1, true), (-1.0, false)] {
            let (params, conditions) = (ResolveParams::with_smoothing(6.0), Conditions::default());
            let run = Run::start(&mut scene, params, &conditions);
            let mut run = run.expect("a run");
            let mut carried = Vec::new();
            for tissue in &run.tissues {
                let x: Vec<DVec3> = tissue.rest.iter().map(|x| *x + up * DVec3::Z).collect();
                carried.push(LocalDisplacements::new(tissue, &x));
            }
            run.warm_start(&carried).expect("a state");
            assert_eq!((run.rounds[0].new_pairs, run.rounds[0].overlapping_pairs), (0, 1));
            assert_eq!(run.rounds[1].new_pairs > 0, is_kept, "{:?}", run.rounds[1]);
            assert_eq!(run.is_warm, is_kept, "by {up}");
            let moved = run.scene.bodies()[1].positions() != run.tissues[1].rest;
            assert_eq!(moved, is_kept);
            run.restore().expect("the start");
        }
    }
}
