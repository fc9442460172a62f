//! Frames under a budget: pairs in the order of their possible depth, until the budget is spent.

use std::fmt;
use std::time::Duration;

use scene::{PairId, Scene};

use crate::box_depth::max_depth_by_boxes;
use crate::detection::LeftOutPair;
use crate::motion::{BodyMotion, LastDepth};
use crate::pair_detector::{Frame, PairDetector};
use crate::{Detection, OperationCounts, Plan, PlanError};

/// Budget of one frame. The pair under way when it is spent is completed.
pub enum FrameBudget<'a> {
    /// Time of the counted operations [on the reference
    /// machine](crate::OperationCounts::SECONDS): the same pairs in every run.
    Operations(Duration),
    /// Time by the caller's clock, which returns the time since any fixed moment. It is read
    /// before the first pair and after each.
    Clock {
        /// Largest time of the frame.
        limit: Duration,
        /// The clock.
        now: &'a mut dyn FnMut() -> Duration,
    },
}

impl fmt::Debug for FrameBudget<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Operations(limit) => f.debug_tuple("Operations").field(limit).finish(),
            Self::Clock { limit, .. } => {
                f.debug_struct("Clock").field("limit", limit).finish_non_exhaustive()
            }
        }
    }
}

/// Pair that waits for detection in a frame.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    pair: PairId,
    /// Its place among the planned pairs, if it is one.
    place: Option<usize>,
    upper: f64,
}

/// Spent part of a budget.
struct Meter<'b, 'a> {
    budget: &'b mut FrameBudget<'a>,
    start: Duration,
    /// Last reading of the clock.
    last: Duration,
    /// Operations so far \[s\].
    seconds: f64,
}

impl Plan {
    /// Detects the pairs that may be deepest, until a budget is spent.
    ///
    /// Pairs are taken in the order of a proved bound on their depth now: the last one, and the
    /// displacements of both bodies since; at first, what the boxes of both bodies allow. Those
    /// that are left out are [listed](Detection::left_out) with that bound. Trees and coarse
    /// surfaces follow the bodies of detected pairs alone.
    ///
    /// # Errors
    ///
    /// As [`Self::detect`].
    pub fn detect_within(
        &mut self,
        scene: &mut Scene,
        budget: &mut FrameBudget<'_>,
        out: &mut Detection,
    ) -> Result<(), PlanError> {
        self.check_scene(scene)?;
        out.clear();
        let mut meter = Meter::start(budget);

        // The possible depth of all pairs, also of those that have come near without a plan.
        self.track_motion(scene);
        self.list_out_of_range(scene, out);
        let unplanned =
            if out.out_of_range.is_empty() { Vec::new() } else { self.unplanned(scene) };
        let waiting = self.waiting(scene, &unplanned);

        // Deepest first, until the budget is spent.
        let mut is_detected = vec![false; self.pairs.len()];
        let mut others = Vec::new();
        for Waiting { pair, place, upper } in waiting {
            if meter.is_spent() {
                out.left_out.push(LeftOutPair { pair, upper });
                continue;
            }
            let planned = place.map(|place| &self.pairs[place]);
            let refit = self.structures.follow_pair(scene, pair, planned, &self.params)?;
            let frame = Frame::new(scene, &self.structures, &self.params);
            match place {
                Some(place) => {
                    let detector = &mut self.detectors[place];
                    detector.detect(&self.pairs[place], frame)?;
                    is_detected[place] = true;
                    let seconds = meter.add(refit + detector.operations);
                    self.pairs[place].measured_seconds = seconds;
                    self.count_operations(place);
                    self.remember(place);
                }
                None => {
                    let mut detector = PairDetector::new(pair);
                    detector.detect_exactly(pair, frame)?;
                    meter.add(refit + detector.operations);
                    others.push(detector);
                }
            }
        }

        self.frame_count += 1;

        // Results in the order of the plan, whatever the order of detection was.
        for (detector, is_detected) in self.detectors.iter().zip(is_detected) {
            if is_detected {
                out.add(&detector.found, &detector.contacts);
            }
        }
        others.sort_by_key(|detector| detector.found.pair);
        for detector in others {
            out.add(&detector.found, &detector.contacts);
        }
        Ok(())
    }

    /// Follows the motion of all bodies, from the first frame under a budget on.
    fn track_motion(&mut self, scene: &Scene) {
        match &mut self.motion {
            Some(motion) => BodyMotion::follow(motion, scene),
            None => self.motion = Some(BodyMotion::begin(scene)),
        }
    }

    /// Follows the motion of all bodies and notes the depths of all pairs, where frames are
    /// detected under a budget.
    pub(crate) fn remember_all(&mut self, scene: &Scene) {
        let Some(motion) = &mut self.motion else { return };
        BodyMotion::follow(motion, scene);
        for place in 0..self.pairs.len() {
            // Those that this scene ignores were not detected: what is known of them stays.
            if !scene.is_ignored(self.pairs[place].pair) {
                self.remember(place);
            }
        }
    }

    /// Notes the depth of a pair that was detected.
    fn remember(&mut self, place: usize) {
        let (Some(motion), detector) = (&self.motion, &mut self.detectors[place]) else { return };
        let pair = detector.found.pair;
        let traveled = pair.bodies().map(|id| motion[id.index()].traveled);
        detector.last = Some(LastDepth { upper: detector.found.depth.upper, traveled });
    }

    /// Lists all pairs that are not ignored with bounds on their depths, deepest first.
    fn waiting(&self, scene: &Scene, unplanned: &[PairId]) -> Vec<Waiting> {
        let mut waiting = Vec::new();
        for (place, detector) in self.detectors.iter().enumerate() {
            let pair = detector.found.pair;
            if scene.is_ignored(pair) {
                continue;
            }
            let upper = self.max_depth(scene, pair, detector.last);
            waiting.push(Waiting { pair, place: Some(place), upper });
        }
        for &pair in unplanned {
            let upper = self.max_depth(scene, pair, None);
            waiting.push(Waiting { pair, place: None, upper });
        }

        // Of equal bounds the first pair.
        waiting.sort_by(|p, q| q.upper.total_cmp(&p.upper));
        waiting
    }

    /// Bounds the depth of a pair now.
    ///
    /// While two surfaces move by d and e, no point becomes deeper by more than d + e: until then
    /// neither surface has passed it.
    fn max_depth(&self, scene: &Scene, pair: PairId, last: Option<LastDepth>) -> f64 {
        let Some(motion) = &self.motion else { return f64::INFINITY };
        let boxes = pair.bodies().map(|id| motion[id.index()].bounds);
        let by_boxes = max_depth_by_boxes(scene, pair, boxes);
        let Some(last) = last else { return by_boxes };

        // The last bound, and what both bodies have moved since, rounded up.
        let mut upper = last.upper;
        for (id, traveled) in pair.bodies().into_iter().zip(last.traveled) {
            let way = motion[id.index()].traveled - traveled;
            if way > 0.0 {
                upper = (upper + way.next_up()).next_up();
            }
        }
        upper.min(by_boxes)
    }
}

impl<'b, 'a> Meter<'b, 'a> {
    fn start(budget: &'b mut FrameBudget<'a>) -> Self {
        let mut meter = Self { budget, start: Duration::ZERO, last: Duration::ZERO, seconds: 0.0 };
        meter.read_clock();
        meter.start = meter.last;
        meter
    }

    /// Adds the operations of a pair, and returns its time by the clock, if there is one \[s\].
    fn add(&mut self, operations: OperationCounts) -> Option<f64> {
        self.seconds += operations.seconds();
        let before = self.last;
        self.read_clock();
        let has_clock = matches!(self.budget, FrameBudget::Clock { .. });
        has_clock.then(|| self.last.saturating_sub(before).as_secs_f64())
    }

    fn read_clock(&mut self) {
        if let FrameBudget::Clock { now, .. } = &mut self.budget {
            self.last = now();
        }
    }

    fn is_spent(&self) -> bool {
        match &self.budget {
            FrameBudget::Operations(limit) => self.seconds >= limit.as_secs_f64(),
            FrameBudget::Clock { limit, .. } => self.last.saturating_sub(self.start) >= *limit,
        }
    }
}
