//! Plans: the cheapest method per pair whose error is proved to be within a tolerance.

use std::collections::BTreeMap;

use musculo_collide::{BodyId, Detection, Plan, PlanParams, Scene};
use surface::progress::Progress;

use super::super::score::Answer;
use super::super::task::Task;
use super::{Built, Detector, Failure};

/// Number of frames that plans are made for.
const FRAMES: u32 = 100_000;

/// Detection by a plan.
struct PlannedDetection<'a> {
    task: &'a Task<'a>,
    scene: Scene,
    ids: Vec<BodyId>,
    muscles: Vec<usize>,
    plan: Plan,
    detection: Detection,
}

/// Makes a plan of the bodies at rest.
///
/// # Errors
///
/// When the scene refuses a body, or no plan can be made.
pub(super) fn detector<'a>(task: &'a Task<'a>, tolerance: f64) -> Built<'a> {
    let (mut scene, ids) = task.scene()?;
    let params = PlanParams {
        frames: FRAMES,
        max_displacement: f64::INFINITY,
        ..PlanParams::with_tolerance(tolerance)
    };
    let plan = Plan::new(&mut scene, &params, Progress::none())?;
    let (muscles, detection) = (task.muscles(), Detection::default());
    Ok(Box::new(PlannedDetection { task, scene, ids, muscles, plan, detection }))
}

impl Detector for PlannedDetection<'_> {
    fn step(&mut self, frame: usize) -> Result<(), Failure> {
        for &muscle in &self.muscles {
            self.scene.move_body(self.ids[muscle], self.task.positions(frame, muscle))?;
        }
        Ok(self.plan.detect(&mut self.scene, &mut self.detection)?)
    }

    fn answer(&self) -> Answer {
        let mut depths = BTreeMap::new();
        for found in self.detection.pairs() {
            if found.is_overlapping() {
                depths.insert(found.pair.bodies().map(BodyId::index), found.max_depth);
            }
        }
        Answer::Depths(depths)
    }
}
