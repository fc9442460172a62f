//! Proof of the gap: certified distances between the surfaces of all pairs, at the end.

use kdop::Workspace;
use proximity::{SeparationBounds, SurfaceTree};
use scene::PairId;
use surface::parallel;
use surface::progress::Interrupted;

use crate::ResolveError;
use crate::damage::rounded_to_single;
use crate::resolution::{DistanceBracket, GapObstacle, GapProof, ShortGap};
use crate::run::Run;
use crate::squeeze::Squeeze;
use crate::tissue::fitted_tree;

impl Run<'_> {
    /// Brackets the distance of every pair that may be nearer than the gap, at the positions that
    /// will be written.
    pub(crate) fn prove_gap(&mut self, overlapping: &[PairId]) -> Result<GapProof, ResolveError> {
        let gap = self.params.gap;
        let mut proof = GapProof { gap, ..GapProof::default() };
        if gap <= 0.0 {
            return Ok(proof);
        }
        // Rounding brings rigid bodies nearer to each other than they are.
        let mut pairs = self.scene.close_pairs(gap + self.gap_slack())?;
        self.scene.fit_all()?;
        pairs.retain(|pair| !self.is_tied(*pair));

        // Rigid bodies are not moved, but proved where rounding puts them.
        let rounded = self.rounded_rigid_trees()?;
        let (scene, rounded) = (&*self.scene, &rounded);
        let progress = self.round_progress();
        let bounds = parallel::map_slice_with(&pairs, Workspace::default, |workspace, pair| {
            progress.report(0.0)?;
            let [a, b] = pair.bodies().map(|id| {
                let own = &rounded[id.index()];
                own.as_ref().unwrap_or_else(|| fitted_tree(scene.body(id)))
            });
            Ok(SeparationBounds::compute(a, b, gap, workspace))
        });
        let bounds: Result<Vec<_>, Interrupted> = bounds.into_iter().collect();

        for (&pair, bounds) in pairs.iter().zip(bounds?) {
            let overlaps = overlapping.contains(&pair);
            let Some(bounds) = bounds else {
                // One body is inside the other, far from its surface.
                if overlaps {
                    let distance = DistanceBracket { lower: 0.0, upper: 0.0 };
                    let obstacle = if self.can_open(pair) {
                        GapObstacle::Overlaps
                    } else {
                        GapObstacle::BothRigid
                    };
                    proof.examined_pairs += 1;
                    proof.short.push(ShortGap { pair, distance, obstacle });
                }
                continue;
            };
            proof.examined_pairs += 1;
            let distance = if overlaps {
                DistanceBracket { lower: 0.0, upper: 0.0 }
            } else {
                DistanceBracket { lower: bounds.lower, upper: bounds.upper.max(bounds.lower) }
            };
            if distance.lower < gap {
                let obstacle = self.gap_obstacle(pair, overlaps, &bounds);
                proof.short.push(ShortGap { pair, distance, obstacle });
            }
        }
        proof.short.sort_by(|p, q| p.distance.lower.total_cmp(&q.distance.lower));
        Ok(proof)
    }

    /// Returns why a pair is nearer than the gap.
    fn gap_obstacle(
        &self,
        pair: PairId,
        overlaps: bool,
        nearest: &SeparationBounds,
    ) -> GapObstacle {
        let mut is_held = true;
        for (id, face) in pair.bodies().into_iter().zip(nearest.faces) {
            let tissue = &self.tissues[id.index()];
            is_held &= tissue.corners(face).iter().all(|vertex| !tissue.is_free(*vertex));
        }
        if !self.can_open(pair) {
            GapObstacle::BothRigid
        } else if let Some(Squeeze { room, thickness }) = self.squeeze_at_nearest(pair, nearest) {
            GapObstacle::Squeezed { room, thickness, gap: self.params.gap }
        } else if overlaps {
            GapObstacle::Overlaps
        } else if is_held {
            GapObstacle::Fixed
        } else {
            GapObstacle::Stuck
        }
    }

    /// Builds the trees of rigid bodies that rounding moves; `None` for all others.
    fn rounded_rigid_trees(&self) -> Result<Vec<Option<SurfaceTree>>, ResolveError> {
        let mut trees = Vec::new();
        for (tissue, body) in self.tissues.iter().zip(self.scene.bodies()) {
            let mut tree = None;
            if tissue.is_rigid && tissue.is_written_single {
                let x = rounded_to_single(body.positions());
                if x != body.positions() {
                    let mut moved = fitted_tree(body).clone();
                    moved.set_positions(x.into_iter()).map_err(ResolveError::Rounding)?;
                    tree = Some(moved);
                }
            }
            trees.push(tree);
        }
        Ok(trees)
    }
}
