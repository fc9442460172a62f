//! One frame of detection by a plan.

use scene::{BodyId, PairId, Scene};
use surface::parallel;

use crate::candidates::are_rigid;
use crate::pair_detector::{Frame, PairDetector};
use crate::{Detection, Plan, PlanError};

impl Plan {
    /// Detects all pairs in the scene's present state.
    ///
    /// Pairs that are not in the plan are searched once a body has moved farther than the plan
    /// has prepared for, and detected by the surfaces of both bodies. Until then nothing is
    /// allocated after a few frames, but for a short list where one body has thousands of
    /// vertices near a bone, and the contacts of balls.
    ///
    /// # Errors
    ///
    /// - [`PlanError::OtherScene`] when the scene has other bodies than planned.
    /// - [`PlanError::NoPose`] where a rigid body with a field was not moved by its pose.
    /// - [`PlanError::Scene`] when a body is too large to build bounds for.
    pub fn detect(&mut self, scene: &mut Scene, out: &mut Detection) -> Result<(), PlanError> {
        self.check_scene(scene)?;
        out.clear();

        // Planned pairs, each in the memory of its own.
        self.structures.follow(scene)?;
        let Self { pairs, detectors, structures, params, .. } = self;
        let frame = Frame { scene, structures, margin: params.margin };
        parallel::try_for_each_mut(detectors, |number, detector| {
            detector.detect(&pairs[number], frame)
        })?;
        for (planned, found) in self.pairs.iter().zip(&self.detectors) {
            out.add(planned.pair, found.overlaps, found.min_gap, &found.contacts);
        }

        // Pairs of bodies that have left the bounds which keep them apart.
        out.out_of_range.extend(scene.ids().filter(|&id| self.is_out_of_range(scene, id)));
        if out.out_of_range.is_empty() { Ok(()) } else { self.detect_unplanned(scene, out) }
    }

    /// Returns true if a body has left the bounds within which unplanned pairs stay apart.
    fn is_out_of_range(&self, scene: &Scene, id: BodyId) -> bool {
        if self.far_pair_count == 0 {
            return false;
        }

        // Unplanned pairs stay apart while both bodies are in their inflated boxes.
        let bounds = self.bodies[id.index()].bounds.inflate(self.params.max_displacement);
        scene.body(id).positions().iter().any(|&p| !bounds.contains(p))
    }

    /// Detects the pairs that have come near and are not in the plan.
    fn detect_unplanned(&self, scene: &mut Scene, out: &mut Detection) -> Result<(), PlanError> {
        // Pairs that are near now, with the trees of their bodies.
        let margin = self.params.margin;
        let mut pairs = scene.box_pairs(margin);
        pairs.retain(|&pair| self.is_unplanned(scene, pair));
        let mut is_member = vec![false; scene.bodies().len()];
        for id in pairs.iter().flat_map(|pair| pair.bodies()) {
            is_member[id.index()] = true;
        }
        scene.fit(&is_member)?;

        // Each in memory of its own, which is not kept: such pairs are few.
        let scene = &*scene;
        let detectors = parallel::map(pairs.len(), |i| {
            let mut detector = PairDetector::default();
            detector.detect_unplanned(pairs[i], scene, margin);
            detector
        });
        for (pair, found) in pairs.into_iter().zip(detectors) {
            out.add(pair, found.overlaps, found.min_gap, &found.contacts);
        }
        Ok(())
    }

    /// Returns true if a pair is detected although it is not in the plan.
    fn is_unplanned(&self, scene: &Scene, pair: PairId) -> bool {
        !self.is_planned(pair) && !scene.is_ignored(pair) && !are_rigid(scene, pair)
    }
}
