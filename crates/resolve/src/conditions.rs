//! Conditions of a scene: vertices that follow another body, fixed ones, stiffnesses, and bodies to be
//! uncrossed.
//!
//! Vertices of the first body of a tie within its distance of the second one that face it, and do not
//! cross it, follow their closest points on it, as they were at the start. Where the first body is
//! rigid, vertices of the second follow the first.

use std::collections::BTreeSet;

use glam::DVec3;
use kdop::Workspace;
use response::ParameterError;
use scene::{BodyId, PairId, Scene, SceneError};
use surface::progress::Progress;
use surface::triangle;

use crate::near_pairs::NearPairs;
use crate::self_contacts::SelfSurface;
use crate::tissue::{Tissue, fitted_tree};
use crate::{BodyStiffness, CellCorners, Conditions, ResolveError, Tie, TiedVertices};

/// Vertex that follows a point of another body.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TieBond {
    /// Number of the tie.
    pub(crate) tie: usize,
    pub(crate) follower: BodyId,
    pub(crate) vertex: u32,
    pub(crate) leader: BodyId,
    pub(crate) corners: [u32; 3],
    pub(crate) weights: [f64; 3],
}

impl Tissue {
    /// Fixes a vertex.
    pub(crate) fn fix(&mut self, vertex: u32) {
        self.is_fixed.resize(self.rest.len(), false);
        self.is_fixed[vertex as usize] = true;
    }
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
                tissues[body].fix(vertex);
            }
        }
        Ok(())
    }

    /// Sets the stiffnesses of bodies.
    pub(crate) fn stiffen(
        &self,
        scene: &Scene,
        tissues: &mut [Tissue],
    ) -> Result<(), ResolveError> {
        for BodyStiffness { body, factor } in &self.stiffnesses {
            let name = scene.get(*body)?.name();
            if !BodyStiffness::FACTORS.contains(factor) {
                return Err(ResolveError::Stiffness { name: name.to_owned(), factor: *factor });
            }
            tissues[body.index()].stiffness = *factor;
        }
        Ok(())
    }

    /// Marks the bodies that are not rounded.
    pub(crate) fn keep_unrounded(
        &self,
        scene: &Scene,
        tissues: &mut [Tissue],
    ) -> Result<(), ResolveError> {
        for id in &self.unrounded {
            scene.get(*id)?;
            tissues[id.index()].is_written_single = false;
        }
        Ok(())
    }

    /// Adds the corners of cells.
    pub(crate) fn hold_corners(
        &self,
        scene: &Scene,
        tissues: &mut [Tissue],
    ) -> Result<(), ResolveError> {
        for CellCorners { body, corners, min_jacobian_share } in &self.cell_corners {
            scene.get(*body)?;
            if !(0.0..1.0).contains(min_jacobian_share) {
                let (name, range) = ("min_jacobian_share", "at least 0 and below 1");
                return Err(ParameterError { name, value: *min_jacobian_share, range }.into());
            }
            let tissue = &mut tissues[body.index()];
            let (body, count) = (body.index(), tissue.rest.len());
            if let Some(&vertex) =
                corners.iter().flatten().find(|vertex| **vertex as usize >= count)
            {
                return Err(ResolveError::NoSuchVertex { body, vertex, count });
            }
            tissue.hold_corners(corners, *min_jacobian_share);
        }
        Ok(())
    }

    /// Marks the bodies that are to be uncrossed. The trees of all bodies are up to date.
    pub(crate) fn uncross(
        &self,
        scene: &Scene,
        tissues: &mut [Tissue],
        progress: Progress<'_>,
    ) -> Result<(), ResolveError> {
        for id in &self.uncrossed {
            let body = scene.get(*id)?;
            let (tree, tissue) = (fitted_tree(body), &mut tissues[id.index()]);
            tree.has_winding_number().map_err(|source| {
                let name = body.name().to_owned();
                ResolveError::NoInside { name, source }
            })?;
            let crossings = tree.self_crossings(&mut Workspace::default(), progress)?.len();
            if crossings > 0 {
                tissue.is_inside_itself = SelfSurface::new(tissue, tree).inside();
            }
            tissue.crossings_to_resolve = Some(crossings);
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

    /// Finds the vertices that follow another body, of those that face it and do not cross it. The
    /// trees of all bodies are up to date.
    pub(crate) fn tie_bonds(
        &self,
        scene: &Scene,
        tissues: &[Tissue],
        near: &NearPairs,
    ) -> Result<TieBonds, ResolveError> {
        let (mut bonds, mut counts) = (Vec::new(), Vec::new());
        for Tie { bodies: [a, b], distance } in &self.ties {
            let name = scene.get(*a)?.name();
            scene.get(*b)?;
            if a == b {
                return Err(SceneError::Itself { name: name.to_owned() }.into());
            }
            let first_is_rigid = tissues[a.index()].is_rigid;
            let (follower, leader) = if first_is_rigid { (*b, *a) } else { (*a, *b) };
            let sides = TieSides { scene, tissues, near, follower, leader };

            // A tie that holds nothing would take the gap from its pair, and give nothing for it.
            let Some(count) = sides.bind(counts.len(), *distance, &mut bonds) else {
                let [a, b] = [*a, *b].map(|id| scene.body(id).name().to_owned());
                return Err(ResolveError::NothingTied { a, b, distance: *distance });
            };
            counts.push(count);
        }
        Ok(TieBonds { bonds, counts })
    }
}

/// Vertices that follow another body, with their numbers for each tie.
#[derive(Clone, Debug)]
pub(crate) struct TieBonds {
    pub(crate) bonds: Vec<TieBond>,
    pub(crate) counts: Vec<TiedVertices>,
}

impl TieBond {
    /// Returns the distance of the vertex from its place on the leader.
    fn distance(&self, scene: &Scene) -> f64 {
        let leader = scene.body(self.leader).positions();
        let mut place = DVec3::ZERO;
        for (corner, weight) in self.corners.into_iter().zip(self.weights) {
            place += weight * leader[corner as usize];
        }
        scene.body(self.follower).positions()[self.vertex as usize].distance(place)
    }
}

impl TieBonds {
    /// Returns the counts of vertices, with the distances from their places as bodies are now.
    pub(crate) fn measured(mut self, scene: &Scene) -> Vec<TiedVertices> {
        for bond in &self.bonds {
            let count = &mut self.counts[bond.tie];
            count.max_distance = count.max_distance.max(bond.distance(scene));
        }
        self.counts
    }

    /// Returns the bonds without those of vertices that have come to be in the other body, or to cross it.
    pub(crate) fn without_crossing(&self, scene: &Scene, near: &NearPairs) -> Self {
        let mut crossing = BTreeSet::new();
        for &TiedVertices { follower, leader, .. } in &self.counts {
            let vertices = near.crossing_vertices(follower, leader, scene.body(follower).surface());
            crossing.extend(vertices.into_iter().map(|vertex| (follower, vertex)));
        }
        self.without(&crossing, |count| &mut count.crossing)
    }

    /// Returns the bonds without those of loose vertices.
    pub(crate) fn without_loose(&self, loose: &BTreeSet<(BodyId, u32)>) -> Self {
        self.without(loose, |count| &mut count.loose)
    }

    /// Returns the bonds without those of some vertices, which are counted as others.
    fn without(
        &self,
        vertices: &BTreeSet<(BodyId, u32)>,
        counter: impl Fn(&mut TiedVertices) -> &mut usize,
    ) -> Self {
        let Self { mut bonds, mut counts } = self.clone();
        bonds.retain(|bond| {
            let is_held = !vertices.contains(&(bond.follower, bond.vertex));
            if !is_held {
                counts[bond.tie].tied -= 1;
                *counter(&mut counts[bond.tie]) += 1;
            }
            is_held
        });
        Self { bonds, counts }
    }
}

/// Bodies of a tie, before any has moved.
struct TieSides<'a> {
    scene: &'a Scene,
    tissues: &'a [Tissue],
    near: &'a NearPairs,
    follower: BodyId,
    leader: BodyId,
}

impl TieSides<'_> {
    /// Adds the bonds of vertices that face the leader within a distance; returns how many vertices these are, `None`
    /// where none is within it.
    fn bind(&self, tie: usize, distance: f64, bonds: &mut Vec<TieBond>) -> Option<TiedVertices> {
        let Self { scene, tissues, follower, leader, .. } = *self;
        let [own, other] = [follower, leader].map(|id| fitted_tree(scene.body(id)));
        let crosses = self.near.crossing_vertices(follower, leader, own.surface());
        let workspace = &mut Workspace::default();
        let (tied, crossing, loose) = (0, 0, 0);
        let mut count =
            TiedVertices { follower, leader, tied, crossing, loose, distance, max_distance: 0.0 };
        let mut hint = None;
        for (vertex, &x) in (0..).zip(own.positions().as_slice()) {
            let found = other.closest_point(x, distance, hint, workspace);
            let Some(closest) = found else { continue };
            hint = Some(closest.face);
            let away = x - closest.foot.point;
            let faces_away = tissues[follower.index()].outward(vertex).dot(away) > 0.0;

            // What is inside or crosses comes out; an outer side that faces away outside is left.
            if faces_away || crosses.contains(&vertex) {
                let comes_out = !faces_away || self.is_inside(closest.face, away);
                count.crossing += usize::from(comes_out);
                continue;
            }
            count.tied += 1;
            let corners = other.surface().faces()[closest.face as usize];
            let weights = closest.foot.barycentric;
            bonds.push(TieBond { tie, follower, vertex, leader, corners, weights });
        }
        hint.map(|_| count)
    }

    /// Returns true if the way from the closest point of a face leads into the leader.
    fn is_inside(&self, face: u32, away: DVec3) -> bool {
        let normal = triangle::unit_normal(self.scene.body(self.leader).corners(face));
        away.dot(self.tissues[self.leader.index()].orientation() * normal) < 0.0
    }
}
