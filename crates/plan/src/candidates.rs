//! Pairs of bodies near enough to be planned, found by the broad phase.

use scene::{BodyId, PairId, Scene, SceneError};

use crate::{DetectionMethod, ExcludedPair, ExclusionReason, ForcedMethod, PlanError, PlanParams};

/// Pairs of bodies near enough to be planned, in the order of the bodies.
#[derive(Debug)]
pub(crate) struct NearPairs {
    pub(crate) planned: Vec<NearPair>,
    pub(crate) excluded: Vec<ExcludedPair>,
    /// Number of pairs that are farther apart.
    pub(crate) far_pair_count: usize,
}

/// Pair near enough to be planned.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearPair {
    pub(crate) pair: PairId,
    /// Method that the caller has chosen.
    pub(crate) forced: Option<DetectionMethod>,
    /// Rigid body of the pair with an inside, which can have a field.
    pub(crate) bone: Option<BodyId>,
}

impl NearPairs {
    /// Finds the pairs that may come within the margin, and those with a forced method.
    ///
    /// A body whose vertices move by no more than the maximum displacement stays in its box
    /// inflated by it, so that all other pairs stay apart.
    pub(crate) fn find(
        scene: &mut Scene,
        params: &PlanParams,
        forced: &[ForcedMethod],
    ) -> Result<Self, PlanError> {
        for ForcedMethod { pair, .. } in forced {
            let name = scene.get(pair.a)?.name();
            scene.get(pair.b)?;
            if pair.a == pair.b {
                return Err(SceneError::Itself { name: name.to_owned() }.into());
            }
        }

        // Near pairs, and forced ones wherever they are.
        let count = scene.bodies().len();
        let mut near = scene.box_pairs(params.margin + 2.0 * params.max_displacement);
        near.extend(forced.iter().map(|forced| forced.pair));
        near.sort_unstable();
        near.dedup();

        // Those that are detected, or the reasons why not.
        let far_pair_count = count * count.saturating_sub(1) / 2 - near.len();
        let mut pairs = Self { planned: Vec::new(), excluded: Vec::new(), far_pair_count };
        for pair in near {
            let method = forced.iter().find(|forced| forced.pair == pair);
            let method = method.map(|forced| forced.method);
            match exclusion(scene, pair, method) {
                Some(reason) => pairs.excluded.push(ExcludedPair { pair, reason }),
                None => pairs.planned.push(NearPair::new(scene, pair, method)?),
            }
        }
        Ok(pairs)
    }
}

impl NearPair {
    fn new(
        scene: &Scene,
        pair: PairId,
        forced: Option<DetectionMethod>,
    ) -> Result<Self, PlanError> {
        // A field needs a rigid body with an inside.
        let mut bone = None;
        for id in pair.bodies() {
            let body = scene.body(id);
            if bone.is_none() && body.is_rigid() && body.has_inside().is_ok() {
                bone = Some(id);
            }
        }
        match forced {
            Some(method @ DetectionMethod::Field) if bone.is_none() => {
                Err(unsuitable(scene, pair, method, ExclusionReason::NoBone))
            }
            Some(method @ DetectionMethod::Balls) if are_rigid(scene, pair) => {
                Err(unsuitable(scene, pair, method, ExclusionReason::BothRigid))
            }
            _ => Ok(Self { pair, forced, bone }),
        }
    }
}

/// Returns true if both bodies of a pair are rigid: contacts between them change nothing.
pub(crate) fn are_rigid(scene: &Scene, pair: PairId) -> bool {
    scene.body(pair.a).is_rigid() && scene.body(pair.b).is_rigid()
}

/// Makes the error of a method that was forced and does not suit its pair.
pub(crate) fn unsuitable(
    scene: &Scene,
    pair: PairId,
    method: DetectionMethod,
    reason: ExclusionReason,
) -> PlanError {
    let [a, b] = pair.bodies().map(|id| scene.body(id).name().to_owned());
    PlanError::Forced { a, b, method, reason }
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
