//! One frame of detection by a plan.

use scene::{PairId, Scene};
use surface::parallel;

use crate::candidates::are_rigid;
use crate::pair_detector::{Frame, PairDetector};
use crate::{Detection, Plan, PlanError};

/// Share of the counts of a frame in the mean of all. Smaller follows a motion later; larger, one
/// unusual frame counts for more.
const UPDATE: f64 = 0.125;

impl Plan {
    /// Detects all pairs in the scene's present state.
    ///
    /// Pairs that are not in the plan are searched once a body has moved farther than the plan
    /// has prepared for, and detected by the surfaces of both bodies. Until then nothing is
    /// allocated after a few frames, but for searches for depths, the contacts of balls, and the
    /// order of work between several threads.
    ///
    /// # Errors
    ///
    /// - [`PlanError::OtherScene`] when the scene has other bodies than planned.
    /// - [`PlanError::NoPose`] where a rigid body with a field was not moved by its pose.
    /// - [`PlanError::Parameter`] where bodies come near each other so far out that distances there are
    ///   rounded by more than the tolerance allows.
    /// - [`PlanError::Scene`] when a body is too large to build bounds for.
    pub fn detect(&mut self, scene: &mut Scene, out: &mut Detection) -> Result<(), PlanError> {
        self.check_scene(scene)?;
        out.clear();

        // Planned pairs, each in the memory of its own; those that took longest last time first.
        self.structures.follow(scene, &self.pairs, &self.params)?;
        let Self { pairs, detectors, structures, params, .. } = self;
        let frame = Frame::new(scene, structures, params);
        let last = |_: usize, detector: &PairDetector| detector.operations.seconds();
        parallel::try_for_each_costly_first(detectors, last, |number, detector| {
            detector.detect(&pairs[number], frame)
        })?;
        for detector in &self.detectors {
            out.add(&detector.found, &detector.contacts);
        }
        for place in 0..self.pairs.len() {
            self.count_operations(place);
        }
        self.frame_count += 1;
        self.remember_all(scene);

        // Pairs of bodies that have left the bounds which keep them apart.
        self.list_out_of_range(scene, out);
        if out.out_of_range.is_empty() { Ok(()) } else { self.detect_unplanned(scene, out) }
    }

    /// Updates the operations of a pair by those of its last detection: in place of predicted ones
    /// after the first one, by a share of them later.
    pub(crate) fn count_operations(&mut self, place: usize) {
        let (planned, detector) = (&mut self.pairs[place], &mut self.detectors[place]);
        let share = if detector.is_counted { UPDATE } else { 1.0 };
        detector.is_counted = true;
        planned.operations = planned.operations.lerp(detector.operations, share);
        planned.cost = self.params.machine_factor * planned.operations.seconds();
    }

    /// Lists the bodies that have left the bounds within which unplanned pairs stay apart.
    pub(crate) fn list_out_of_range(&mut self, scene: &Scene, out: &mut Detection) {
        if self.far_pair_count == 0 {
            return;
        }

        // Unplanned pairs stay apart while both bodies are in their inflated boxes.
        for (id, planned) in scene.ids().zip(&mut self.bodies) {
            if !planned.is_in_range(scene.body(id), self.params.max_displacement) {
                out.out_of_range.push(id);
            }
        }
    }

    /// Lists the pairs that have come near and are not in the plan.
    pub(crate) fn unplanned(&self, scene: &mut Scene) -> Vec<PairId> {
        let mut pairs = scene.box_pairs(self.params.margin);
        pairs.retain(|&pair| self.is_unplanned(scene, pair));
        pairs
    }

    /// Detects the pairs that have come near and are not in the plan.
    fn detect_unplanned(&self, scene: &mut Scene, out: &mut Detection) -> Result<(), PlanError> {
        // Pairs that are near now, with the trees of their bodies.
        let pairs = self.unplanned(scene);
        let mut is_member = vec![false; scene.bodies().len()];
        for id in pairs.iter().flat_map(|pair| pair.bodies()) {
            is_member[id.index()] = true;
        }
        scene.fit(&is_member)?;

        // Each in memory of its own, which is not kept: such pairs are few.
        let frame = Frame::new(scene, &self.structures, &self.params);
        let detectors = parallel::map(pairs.len(), |i| {
            let mut detector = PairDetector::new(pairs[i]);
            detector.detect_exactly(pairs[i], frame).map(|()| detector)
        });
        for detector in detectors {
            let detector = detector?;
            out.add(&detector.found, &detector.contacts);
        }
        Ok(())
    }

    /// Returns true if a pair is detected although it is not in the plan.
    fn is_unplanned(&self, scene: &Scene, pair: PairId) -> bool {
        !self.is_planned(pair) && !scene.is_ignored(pair) && !are_rigid(scene, pair)
    }
}
