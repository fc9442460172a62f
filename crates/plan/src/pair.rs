//! Planned and excluded pairs of bodies.

use scene::{BodyId, PairId};

use crate::{DetectionMethod, ErrorEstimate, ExclusionReason, OperationCounts};

/// Method for one pair of bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct PairPlan {
    /// The two bodies.
    pub pair: PairId,
    /// The method.
    pub method: DetectionMethod,
    /// The rigid body whose field the pair may use.
    pub(crate) bone: Option<BodyId>,
    /// Reason why the pair does not use a field, where it does not.
    pub fallback_reason: Option<ExclusionReason>,
    /// Error of a contact's gap, from the structures as they were built, at the positions they
    /// were built at.
    pub error: ErrorEstimate,
    /// Operations per frame.
    pub operations: OperationCounts,
    /// Predicted time per frame, of one thread \[s\].
    pub cost: f64,
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
    /// Returns the rigid body whose field is queried, where that is the method.
    #[must_use]
    pub fn bone(&self) -> Option<BodyId> {
        self.bone.filter(|_| self.method == DetectionMethod::Field)
    }

    /// Returns the body that is compared with the field of `bone`.
    pub(crate) fn other(&self, bone: BodyId) -> BodyId {
        if bone == self.pair.a { self.pair.b } else { self.pair.a }
    }
}
