//! Planned and excluded pairs of bodies.

use scene::{BodyId, PairId};

use crate::{Accuracy, DetectionMethod, ExclusionReason, OperationCounts};

/// Method for one pair of bodies.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PairPlan {
    /// The two bodies.
    pub pair: PairId,
    /// The method.
    pub method: DetectionMethod,
    /// True for each body that is compared by its coarse surface.
    pub is_coarse: [bool; 2],
    /// The rigid body whose field is queried, where that is the method.
    pub bone: Option<BodyId>,
    /// Accuracy of the depth and of the gaps of contacts, from the structures as they were built.
    pub accuracy: Accuracy,
    /// Operations per frame: predicted, and counted once frames were detected.
    pub operations: OperationCounts,
    /// Time per frame of these operations on the machine of the parameters, by one thread \[s\].
    pub cost: f64,
    /// Time of the last detection by the clock of a [budget](crate::FrameBudget), with the refit of
    /// what was not refit for an earlier pair \[s\]; `None` without a clock.
    pub measured_seconds: Option<f64>,
}

/// Pair near enough to be planned that is not detected.
#[derive(Clone, Debug, PartialEq)]
pub struct ExcludedPair {
    /// The two bodies.
    pub pair: PairId,
    /// Reason why it is not detected.
    pub reason: ExclusionReason,
}

impl PairPlan {
    /// Returns the body that is compared with the field of `bone`.
    pub(crate) fn other(&self, bone: BodyId) -> BodyId {
        if bone == self.pair.a { self.pair.b } else { self.pair.a }
    }
}
