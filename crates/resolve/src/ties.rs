//! Ties between bodies, and fixed vertices.
//!
//! Vertices of the first body of a tie within its distance of the second one follow their closest
//! points on it, as they were at the start. Where the first body is rigid, vertices of the second
//! follow the first.

use std::collections::BTreeMap;

use glam::DVec3;
use kdop::Workspace;
use scene::{BodyId, PairId, Scene};

use crate::elastic::{Bond, ElasticProblem};
use crate::run::Run;
use crate::tissue::{Tissue, fitted_tree};
use crate::{Conditions, ResolveError, Tie, tuning};

/// Vertex that follows a point of another body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TieBond {
    follower: BodyId,
    vertex: u32,
    leader: BodyId,
    corners: [u32; 3],
    weights: [f64; 3],
}

impl Conditions {
    /// Marks the fixed vertices.
    pub(crate) fn fix(&self, tissues: &mut [Tissue]) -> Result<(), ResolveError> {
        for fixed in &self.fixed {
            let body = fixed.body.index();
            let count = tissues.get(body).map_or(0, |tissue| tissue.rest.len());
            for &vertex in &fixed.vertices {
                if vertex as usize >= count {
                    return Err(ResolveError::NoSuchVertex { body, vertex, count });
                }
                let is_fixed = &mut tissues[body].is_fixed;
                is_fixed.resize(count, false);
                is_fixed[vertex as usize] = true;
            }
        }
        Ok(())
    }

    /// Returns the pairs that are tied, ascending.
    pub(crate) fn tied_pairs(&self) -> Vec<PairId> {
        let mut tied = Vec::new();
        for Tie { bodies: [a, b], .. } in &self.ties {
            tied.push(PairId::new(*a, *b));
        }
        tied.sort_unstable();
        tied.dedup();
        tied
    }

    /// Finds the vertices that follow another body. The trees of all bodies are up to date.
    pub(crate) fn tie_bonds(
        &self,
        scene: &Scene,
        tissues: &[Tissue],
    ) -> Result<Vec<TieBond>, ResolveError> {
        let mut bonds = Vec::new();
        let workspace = &mut Workspace::default();
        for Tie { bodies: [a, b], distance } in &self.ties {
            scene.get(*a)?;
            scene.get(*b)?;
            let first_is_rigid = tissues[a.index()].is_rigid;
            let (follower, leader) = if first_is_rigid { (*b, *a) } else { (*a, *b) };
            let own = fitted_tree(scene.body(follower));
            let other = fitted_tree(scene.body(leader));
            let mut hint = None;
            for (vertex, &x) in (0..).zip(own.positions().as_slice()) {
                let found = other.closest_point(x, *distance, hint, workspace);
                if let Some(closest) = found {
                    hint = Some(closest.face);
                    let corners = other.surface().faces()[closest.face as usize];
                    let weights = closest.foot.barycentric;
                    bonds.push(TieBond { follower, vertex, leader, corners, weights });
                }
            }
        }
        Ok(bonds)
    }
}

impl Run<'_> {
    /// Returns true if two bodies are tied to each other.
    pub(crate) fn is_tied(&self, pair: PairId) -> bool {
        self.tied.binary_search(&pair).is_ok()
    }

    /// Moves tied vertices with their leaders in this round.
    pub(crate) fn follow_ties(&mut self) {
        for bond in &self.tie_bonds {
            let leader = &self.tissues[bond.leader.index()];
            let mut u = DVec3::ZERO;
            for (corner, weight) in bond.corners.into_iter().zip(bond.weights) {
                u += weight * leader.u[corner as usize];
            }
            self.tissues[bond.follower.index()].u[bond.vertex as usize] = u;
        }
    }

    /// Adds the particles of ties to those that move, where one of their bodies does.
    pub(crate) fn add_tie_seeds(&self, seeds: &mut BTreeMap<BodyId, Vec<u32>>) {
        for tie in &self.tie_bonds {
            if seeds.contains_key(&tie.follower) || seeds.contains_key(&tie.leader) {
                seeds.entry(tie.follower).or_default().push(tie.vertex);
                seeds.entry(tie.leader).or_default().extend(tie.corners);
            }
        }
    }

    /// Adds ties as bonds where their vertices take part.
    pub(crate) fn add_tie_bonds(&self, problem: &mut ElasticProblem) {
        for tie in &self.tie_bonds {
            let first = |id: BodyId| self.scene.body(id).particles().start;
            let mut terms = vec![(first(tie.follower) + tie.vertex, 1.0)];
            for (corner, weight) in tie.corners.into_iter().zip(tie.weights) {
                terms.push((first(tie.leader) + corner, -weight));
            }
            let tissue = &self.tissues[tie.follower.index()];
            let mass = tissue.area(tie.vertex) * tissue.thickness(self.params.smoothing);
            let stiffness = tuning::TIE_STIFFNESS * mass / (tissue.mean_edge * tissue.mean_edge);
            problem.bonds.push(Bond { terms, stiffness });
        }
    }
}
