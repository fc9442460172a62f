//! Proof of the gap: certified distances between the surfaces of all pairs, at the end.

use kdop::Workspace;
use proximity::{ClosestPoint, SeparationBounds, SurfaceTree};
use scene::PairId;
use surface::progress::Interrupted;
use surface::{parallel, triangle};

use crate::damage::rounded_to_single;
use crate::exit_sides::agrees;
use crate::resolution::{DistanceBracket, GapObstacle, GapProof, ShortGap};
use crate::run::Run;
use crate::tissue::{Tissue, fitted_tree};
use crate::{ResolveError, WrittenPrecision};

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
        } else if let Some(squeeze) = self.squeeze(pair, nearest) {
            squeeze
        } else if overlaps {
            GapObstacle::Overlaps
        } else if is_held {
            GapObstacle::Fixed
        } else {
            GapObstacle::Stuck
        }
    }

    /// Returns the room that two rigid bodies leave a soft one between them, if that is less than
    /// its thickness and both gaps.
    fn squeeze(&self, pair: PairId, nearest: &SeparationBounds) -> Option<GapObstacle> {
        let gap = self.params.gap;
        for (soft, rigid) in [(0, 1), (1, 0)] {
            let [soft_id, rigid_id] = [soft, rigid].map(|side: usize| pair.bodies()[side]);
            let (tissue, wall) = (&self.tissues[soft_id.index()], &self.tissues[rigid_id.index()]);
            if tissue.is_rigid || !wall.is_rigid {
                continue;
            }

            // The thickness where the bodies are nearest, at the start.
            let workspace = &mut Workspace::default();
            let at_rest = self.tree_at_rest(tissue)?;
            let [vertex, ..] = tissue.corners(nearest.faces[soft]);
            let thickness = tissue.thickness_at(&at_rest, vertex, workspace)?;

            // The nearest wall on the other side of the body, seen from this wall.
            let foot = nearest.points[rigid];
            let wall_body = self.scene.body(rigid_id);
            let normal = triangle::unit_normal(wall_body.corners(nearest.faces[rigid]));
            let outward = if wall.is_inside_out() { -normal } else { normal };
            for other in self.tissues.iter().filter(|other| other.is_rigid && other.id != rigid_id)
            {
                let tree = fitted_tree(self.scene.body(other.id));
                let found = tree.closest_point(foot, thickness + 2.0 * gap, None, workspace);
                let is_opposite = |found: &ClosestPoint| {
                    let way = (found.foot.point - foot).normalize_or_zero();
                    agrees(way, outward)
                };
                if let Some(found) = found.filter(is_opposite) {
                    return Some(GapObstacle::Squeezed { room: found.distance, thickness, gap });
                }
            }
        }
        None
    }

    /// Builds the tree of a body at the start.
    fn tree_at_rest(&self, tissue: &Tissue) -> Option<SurfaceTree> {
        let mut tree = fitted_tree(self.scene.body(tissue.id)).clone();
        tree.set_positions(tissue.rest.iter().copied()).ok()?;
        Some(tree)
    }

    /// Builds the trees of rigid bodies that rounding moves; `None` for all others.
    fn rounded_rigid_trees(&self) -> Result<Vec<Option<SurfaceTree>>, ResolveError> {
        let mut trees = Vec::new();
        for body in self.scene.bodies() {
            let mut tree = None;
            if body.is_rigid() && self.params.precision == WrittenPrecision::Single {
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
