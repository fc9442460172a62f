//! Work of exact detection per pair, counted once, and the work of other methods predicted from it.

use scene::{BodyId, PairId, Scene};
use surface::parallel;
use surface::progress::Progress;

use crate::builder::COARSE_SHARE;
use crate::candidates::NearPair;
use crate::choice::Candidate;
use crate::cost::{count, far_share};
use crate::pair_detector::{Frame, PairDetector};
use crate::structures::Structures;
use crate::{DetectionMethod, OperationCounts, PlanError, PlanParams};

/// Work of one pair in exact detection.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Workload {
    exact: OperationCounts,
    /// Vertices per body, and those that are inside the other one or within the margin.
    vertices: [f64; 2],
    near: [f64; 2],
    /// Depth of the pair, and what a coarse surface takes from it on average.
    depth: f64,
    receding: f64,
    far_share: f64,
}

/// Part of its deviation by which a coarse surface lies inside the body's own, on average.
const RECEDING_SHARE: f64 = 0.5;

impl Workload {
    /// Counts the work of pairs by detecting each exactly, once. Trees must be fitted.
    pub(crate) fn count_all(
        scene: &Scene,
        pairs: &[NearPair],
        params: &PlanParams,
        progress: Progress<'_>,
    ) -> Result<Vec<Self>, PlanError> {
        let structures = Structures::new(scene.bodies().len());
        let frame = Frame::new(scene, &structures, params);
        let far_share = far_share(scene);
        let steps = progress.steps(pairs.len());
        let counted = parallel::map(pairs.len(), |number| {
            steps.advance(1)?;
            let pair = pairs[number].pair;
            let mut detector = PairDetector::new(pair);
            detector.detect_exactly(pair, frame)?;
            Ok(Self::of(scene, &detector, params.tolerance, far_share))
        });
        counted.into_iter().collect()
    }

    /// Returns the work of exact detection.
    pub(crate) fn exact(&self) -> OperationCounts {
        self.exact
    }

    fn of(scene: &Scene, detector: &PairDetector, tolerance: f64, far_share: f64) -> Self {
        let pair = detector.found.pair;
        Self {
            exact: detector.operations,
            vertices: pair.bodies().map(|id| count(scene.body(id).positions().len())),
            near: detector.near_counts(),
            depth: detector.found.max_depth,
            receding: RECEDING_SHARE * COARSE_SHARE * tolerance,
            far_share,
        }
    }

    /// Predicts the work of a method. `kept` is the share of its faces that the coarse surface of
    /// each body has.
    pub(crate) fn predict(
        &self,
        method: DetectionMethod,
        pair: PairId,
        is_coarse: [bool; 2],
        bone: Option<BodyId>,
        kept: [f64; 2],
    ) -> Candidate {
        // A body that is compared by its own surface keeps all of its faces.
        let kept = [0, 1].map(|side| if is_coarse[side] { kept[side] } else { 1.0 });
        let operations = match method {
            DetectionMethod::Exact => self.exact,
            DetectionMethod::Coarse => self.coarse(is_coarse, kept),
            DetectionMethod::Field => {
                let field_vertices = self.near[usize::from(bone == Some(pair.a))];
                OperationCounts { field_vertices, ..self.exact }
            }
            DetectionMethod::Balls => OperationCounts {
                ball_vertices: self.vertices[0] + self.vertices[1],
                ..OperationCounts::default()
            },
        };
        Candidate { method, is_coarse, bone, operations, seconds: operations.seconds() }
    }

    /// Predicts the work on coarser surfaces: vertices as there are faces, and faces along the
    /// common curve as there are edges. Where overlaps are shallow, the curve is shorter.
    fn coarse(&self, is_coarse: [bool; 2], kept: [f64; 2]) -> OperationCounts {
        // Of near faces that do not meet, this share does once both surfaces are coarser.
        const MEETING_SHARE: f64 = 0.1;

        let sum = |counts: [f64; 2]| counts[0] * kept[0] + counts[1] * kept[1];
        let near_vertices = sum(self.near);
        let tested_faces = self.exact.tested_faces * along_curve(kept);
        let along_curve = along_curve(kept) * self.remaining(is_coarse);
        let meeting_faces =
            (self.exact.meeting_faces * along_curve).max(MEETING_SHARE * tested_faces);
        let operations = OperationCounts {
            listed_vertices: sum(self.vertices).min(self.exact.listed_vertices),
            tested_faces,
            meeting_faces,
            near_vertices,
            far_near_vertices: self.far_share * near_vertices,
            ..OperationCounts::default()
        };
        self.with_search(operations, is_coarse, kept)
    }

    /// Adds the search for a depth: larger faces and a narrower bracket take more than the exact
    /// one, by the share of faces that are left out.
    fn with_search(
        &self,
        operations: OperationCounts,
        is_coarse: [bool; 2],
        kept: [f64; 2],
    ) -> OperationCounts {
        // Both sides have as many of the crossings, whatever their sizes.
        let share = 0.5 * (kept[0] + kept[1]);
        let beyond = 1.0 - share;
        let meeting_faces = beyond * operations.meeting_faces;

        // Each crossing of larger faces is taken from both sides, and each face split once where
        // smaller ones are.
        let is_split = self.exact.split_pieces > 0.0;
        let split_faces = if is_split { meeting_faces } else { 0.0 };
        let split_pieces = self.remaining(is_coarse) * self.exact.split_pieces;
        OperationCounts {
            clipped_faces: share * self.exact.clipped_faces + 2.0 * meeting_faces,
            split_pieces: (1.0 + beyond) * split_pieces + split_faces,
            depth_queries: (1.0 + beyond) * self.exact.depth_queries,
            ..operations
        }
    }

    /// Predicts the share of the common curve that is left between coarse surfaces, which lie a little
    /// inside the bodies' own. Around a contact of rounded bodies its length goes with the root of the
    /// depth.
    fn remaining(&self, is_coarse: [bool; 2]) -> f64 {
        let receding = is_coarse.into_iter().filter(|&is_coarse| is_coarse).count();
        let depth = self.depth - self.receding * count(receding);
        if depth > 0.0 { (depth / self.depth).sqrt() } else { 0.0 }
    }
}

/// Returns the share of edges along a curve, from the shares of faces.
fn along_curve(kept: [f64; 2]) -> f64 {
    0.5 * (kept[0].sqrt() + kept[1].sqrt())
}
