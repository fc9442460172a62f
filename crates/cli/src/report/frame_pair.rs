//! Record of an overlap in a frame of a motion.

use musculo_collide::{Depth, OverlapMeasures, PairReport, Scene};
use serde::Serialize;

/// Two bodies that overlap in a frame. Its measures have the names of those of a check; separate regions are left
/// out.
#[derive(Debug, Serialize)]
pub(crate) struct FramePair {
    a: String,
    b: String,
    /// Measures of what both share; `None` where the surfaces share no area.
    overlap: Option<OverlapMeasures>,
    /// Greatest depth of `a`'s surface inside `b`; `None` where nothing of it is inside, and where
    /// `b` has no inside.
    depth_of_a_in_b: Option<Depth>,
    /// Greatest depth of `b`'s surface inside `a`.
    depth_of_b_in_a: Option<Depth>,
    /// Depth of the deepest vertex inside the other body, 0 without one.
    max_vertex_depth: f64,
}

impl FramePair {
    /// Lists the pairs that overlap.
    pub(crate) fn list(scene: &Scene, reports: &[PairReport]) -> Vec<Self> {
        let overlapping = reports.iter().filter(|report| report.overlaps);
        overlapping.map(|report| Self::new(scene, report)).collect()
    }

    fn new(scene: &Scene, report: &PairReport) -> Self {
        let [a, b] = scene.names(report.pair).map(str::to_owned);
        let overlap = report.overlap.as_ref();
        Self {
            a,
            b,
            overlap: overlap.map(|overlap| overlap.measures.total),
            depth_of_a_in_b: overlap.and_then(|overlap| overlap.depth_of_a_in_b),
            depth_of_b_in_a: overlap.and_then(|overlap| overlap.depth_of_b_in_a),
            max_vertex_depth: report.max_vertex_depth,
        }
    }
}
