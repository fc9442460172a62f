//! Candidate pairs of a plan, found by the broad phase, and the first choice of their methods.

use scene::{PairId, Scene};

use crate::{
    DetectionMethod, ErrorEstimate, ExcludedPair, ExclusionReason, ForcedMethod, OperationCounts,
    PairPlan, PlanError, PlanParams,
};

/// Pairs of bodies near enough to be planned, in the order of the bodies.
#[derive(Debug)]
pub(crate) struct Candidates {
    /// Pairs to detect, by the cheapest method if its structures can be built.
    pub(crate) planned: Vec<PairPlan>,
    pub(crate) excluded: Vec<ExcludedPair>,
    /// Number of pairs that are farther apart.
    pub(crate) far_pair_count: usize,
}

impl Candidates {
    /// Finds the pairs that may come within the margin, and those with a forced method.
    ///
    /// A body whose vertices move by no more than the maximum displacement stays in its box
    /// inflated by it, so that all other pairs stay apart.
    pub(crate) fn find(
        scene: &mut Scene,
        params: &PlanParams,
        forced: &[ForcedMethod],
    ) -> Result<Self, PlanError> {
        let count = scene.bodies().len();
        // Near pairs, and forced ones wherever they are.
        let mut near = scene.box_pairs(params.margin + 2.0 * params.max_displacement);
        near.extend(forced.iter().map(|forced| forced.pair).filter(|pair| pair.b.index() < count));
        near.sort_unstable();
        near.dedup();

        // Their first methods, or the reasons why they are not detected.
        let far_pair_count = count * count.saturating_sub(1) / 2 - near.len();
        let mut candidates = Self { planned: Vec::new(), excluded: Vec::new(), far_pair_count };
        for pair in near {
            let method = forced_method(forced, pair);
            match exclusion(scene, pair, method) {
                Some(reason) => candidates.excluded.push(ExcludedPair { pair, reason }),
                None => candidates.planned.push(choose_method(scene, pair, method)?),
            }
        }
        Ok(candidates)
    }
}

/// Returns the method that the caller has chosen for a pair.
pub(crate) fn forced_method(forced: &[ForcedMethod], pair: PairId) -> Option<DetectionMethod> {
    forced.iter().find(|forced| forced.pair == pair).map(|forced| forced.method)
}

/// Returns true if both bodies of a pair are rigid: contacts between them change nothing.
pub(crate) fn are_rigid(scene: &Scene, pair: PairId) -> bool {
    scene.body(pair.a).is_rigid() && scene.body(pair.b).is_rigid()
}

/// Makes the error of a method that was forced and does not suit its pair.
pub(crate) fn unsuitable(scene: &Scene, planned: &PairPlan, reason: ExclusionReason) -> PlanError {
    let [a, b] = planned.pair.bodies().map(|id| scene.body(id).name().to_owned());
    PlanError::Forced { a, b, method: planned.method, reason }
}

/// Returns the reason why a near pair is not detected, if there is one.
fn exclusion(
    scene: &Scene,
    pair: PairId,
    forced: Option<DetectionMethod>,
) -> Option<ExclusionReason> {
    if scene.is_ignored(pair) {
        Some(ExclusionReason::Ignored)
    } else if are_rigid(scene, pair) && forced.is_none() {
        Some(ExclusionReason::BothRigid)
    } else {
        None
    }
}

/// Chooses the forced method of a pair, or else the cheapest.
fn choose_method(
    scene: &Scene,
    pair: PairId,
    forced: Option<DetectionMethod>,
) -> Result<PairPlan, PlanError> {
    // A field needs a rigid body with an inside.
    let closed = pair.bodies().map(|id| scene.body(id).has_inside().is_ok());
    let mut bone = None;
    for (id, is_closed) in pair.bodies().into_iter().zip(closed) {
        if bone.is_none() && is_closed && scene.body(id).is_rigid() {
            bone = Some(id);
        }
    }
    let fallback_reason = match bone {
        Some(_) => None,
        None if closed == [true; 2] => Some(ExclusionReason::NoBone),
        None => Some(ExclusionReason::Open),
    };
    let cheapest = if bone.is_some() { DetectionMethod::Field } else { DetectionMethod::Surfaces };

    // Errors, operations and costs follow once the structures are built.
    let planned = PairPlan {
        pair,
        method: forced.unwrap_or(cheapest),
        bone,
        fallback_reason,
        error: ErrorEstimate::NONE,
        operations: OperationCounts::default(),
        cost: 0.0,
    };
    match planned.method {
        DetectionMethod::Field if bone.is_none() => {
            Err(unsuitable(scene, &planned, ExclusionReason::NoBone))
        }
        DetectionMethod::Medial if are_rigid(scene, pair) => {
            Err(unsuitable(scene, &planned, ExclusionReason::BothRigid))
        }
        _ => Ok(planned),
    }
}
