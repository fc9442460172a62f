//! Sides by which deep vertices leave another body.
//!
//! The nearest way out of a thin bone may lead through to its far side. Where tissue entered
//! shows at vertices that are shallow and whose own surface faces that of the other body:
//! their exit directions are spread over all vertices inside, along the surface and through
//! the tissue. A vertex whose nearest way out points against its direction is projected
//! again, onto faces on the right side, unless these are much farther than the pair is deep: tissue that
//! embraces a bone would leave across all of it. What leaves by its nearest way then is held out there.

use std::collections::BTreeMap;

use glam::DVec3;
use kdop::Workspace;
use proximity::{ClosestPoint, NearVertex, contact};
use scene::{Body, BodyKind};
use surface::{Contact, triangle};

use crate::curve_exits::PushMemory;
use crate::near_pieces::PiecePair;
use crate::spread::symmetric_sweeps;
use crate::tissue::{Tissue, fitted_tree};

/// Gauss–Seidel sweeps that spread exit directions over vertices inside. Patches are some
/// thirty edges wide: below, their middle is not reached; above, little changes.
const DIRECTION_SWEEPS: usize = 30;

/// Longest way out of a bone by the side of entry \[deepest of the nearest ways\]. Through a plate it is 2 at most,
/// whose middle is deepest. Below, tissue beyond the middle leaves by the far side; above, tissue that embraces a
/// bone leaves across it.
const MAX_TURNED_WAY: f64 = 2.5;

/// Ways by which the vertices of one body left another one in earlier rounds; empty while none was inside.
#[derive(Clone, Debug, Default)]
pub(crate) struct ExitMemory {
    /// Exit directions; 0 for vertices that were never inside. A vertex keeps its direction.
    pub(crate) directions: Vec<DVec3>,
    /// True for deep vertices that left a bone by their nearest way, since none led out in their direction.
    left_nearest: Vec<bool>,
}

/// Ways by which the bodies of a pair came apart in earlier rounds.
#[derive(Clone, Debug, Default)]
pub(crate) struct PairMemory {
    /// Those of either body, for each pair of their pieces.
    pub(crate) exits: BTreeMap<PiecePair, [ExitMemory; 2]>,
    pub(crate) pushes: PushMemory,
}

impl ExitMemory {
    /// Adds vertices that were never inside, up to a number.
    pub(crate) fn resize(&mut self, count: usize) {
        self.directions.resize(count, DVec3::ZERO);
        self.left_nearest.resize(count, false);
    }

    /// Returns the exit direction of a vertex; 0 where it was never inside.
    pub(crate) fn direction(&self, vertex: u32) -> DVec3 {
        self.directions.get(vertex as usize).copied().unwrap_or_default()
    }
}

/// Vertices of one body against another body.
pub(crate) struct ExitSide<'a> {
    pub(crate) tissue: &'a Tissue,
    pub(crate) other_tissue: &'a Tissue,
    /// Piece of the other body that vertices leave.
    pub(crate) other_piece: u32,
    pub(crate) body: &'a Body,
    pub(crate) other: &'a Body,
    pub(crate) smoothing: f64,
}

impl ExitSide<'_> {
    /// Makes the contacts of near vertices. Those that face away from the other surface are
    /// dropped, and deep ones are projected onto the side by which they entered.
    pub(crate) fn contacts(&self, near: &[NearVertex], memory: &mut ExitMemory) -> Vec<Contact> {
        let workspace = &mut Workspace::default();
        let (body, other) = (self.body.contact_surface(), self.other.contact_surface());
        let directions = self.exit_directions(near, memory);
        let is_bone = self.other.kind() == BodyKind::Rigid;
        let longest = if is_bone { MAX_TURNED_WAY * deepest_way(near) } else { f64::INFINITY };
        let mut contacts = Vec::with_capacity(near.len());
        for near in near {
            let corrected = if self.tissue.is_rigid {
                let direction = memory.direction(near.vertex);
                self.correct_rigid(near, direction, workspace)
            } else {
                let direction = directions[near.vertex as usize];
                self.correct_soft(near, direction, longest, memory, workspace)
            };
            if let Some(near) = corrected {
                contacts.push(contact(&body, &other, &near));
            }
        }
        contacts
    }

    /// Corrects a vertex of tissue, which leaves by the side where it entered, on a way up to the longest.
    fn correct_soft(
        &self,
        near: &NearVertex,
        direction: DVec3,
        longest: f64,
        memory: &mut ExitMemory,
        workspace: &mut Workspace,
    ) -> Option<NearVertex> {
        // Outside, a vertex that faces away is of another part of the surface.
        let is_astray = near.normal.dot(direction) < 0.0;
        if near.gap >= 0.0 {
            let is_behind = self.tissue.agrees(self.normal(near), near.normal);
            let has_left = memory.left_nearest.get(near.vertex as usize) == Some(&true);
            return ((!is_astray || has_left) && !is_behind).then_some(*near);
        }
        if !is_astray {
            return Some(*near);
        }

        // Inside, the way out by the entered side, where there is one. Deep vertices that leave a bone by their nearest
        // way all the same are held out there.
        let turned = self.project(near.vertex, direction, workspace);
        let turned = turned.filter(|turned| turned.gap < 0.0 && -turned.gap <= longest);
        if self.other.kind() == BodyKind::Rigid {
            let is_deep = near.gap < -self.tissue.params.tuning.shallow_depth * self.smoothing;
            let has_left = &mut memory.left_nearest[near.vertex as usize];
            *has_left = turned.is_none() && (is_deep || *has_left);
        }
        turned.or(Some(*near))
    }

    /// Corrects a vertex of bone, which leaves in the direction of its patch, or by the side of the
    /// tissue that faces it.
    fn correct_rigid(
        &self,
        near: &NearVertex,
        direction: DVec3,
        workspace: &mut Workspace,
    ) -> Option<NearVertex> {
        if near.gap < 0.0 && direction != DVec3::ZERO {
            let turned = !self.tissue.agrees(near.normal, direction);
            let turned = turned.then(|| self.project(near.vertex, direction, workspace)).flatten();
            return turned.filter(|turned| turned.gap < 0.0).or(Some(*near));
        }
        let normal = self.normal(near);
        if !self.tissue.agrees(normal, near.normal) {
            return Some(*near);
        }
        if near.gap >= 0.0 {
            return None;
        }

        // The nearest way out leads through the tissue: the side that faces the bone instead.
        let turned = self.project(near.vertex, -normal, workspace);
        turned.filter(|turned| turned.gap < 0.0)
    }

    fn normal(&self, near: &NearVertex) -> DVec3 {
        self.tissue.normals[near.vertex as usize]
    }

    /// Computes the outer unit normal of a face of the other body.
    fn normal_of_other(&self, face: u32) -> DVec3 {
        let normal = triangle::unit_normal(self.other.corners(face));
        if self.other.is_inside_out() { -normal } else { normal }
    }

    /// Computes the exit directions of vertices inside or near, |V|; 0 for others, for rigid
    /// bodies, and for all while none has been inside.
    fn exit_directions(&self, near: &[NearVertex], memory: &mut ExitMemory) -> Vec<DVec3> {
        if self.tissue.is_rigid || (memory.directions.is_empty() && !has_inside(near)) {
            return vec![DVec3::ZERO; self.tissue.normals.len()];
        }
        memory.resize(self.tissue.normals.len());

        // Own directions: a vertex new inside counts by how shallow it is, and by how it faces the other body.
        let mut own = memory.directions.clone();
        for near in near {
            let direction = &mut own[near.vertex as usize];
            if near.gap < 0.0 && *direction == DVec3::ZERO {
                let facing = (-self.normal(near).dot(near.normal)).max(0.0);
                let trust = facing
                    * (near.gap / (self.tissue.params.tuning.shallow_depth * self.smoothing)).exp();
                *direction = trust * near.normal;
            }
        }

        // Spread the directions over all near vertices.
        let mut directions = own.clone();
        symmetric_sweeps(near, DIRECTION_SWEEPS, |near| {
            let mean = self.tissue.equilibrium(near.vertex, |v| directions[v as usize], 0.0);
            if let Some(mean) = mean {
                directions[near.vertex as usize] = own[near.vertex as usize] + mean;
            }
        });
        for direction in &mut directions {
            *direction = direction.normalize_or_zero();
        }

        // Remember those of vertices new inside.
        for near in near {
            let remembered = &mut memory.directions[near.vertex as usize];
            if near.gap < 0.0 && *remembered == DVec3::ZERO {
                *remembered = directions[near.vertex as usize];
            }
        }
        directions
    }

    /// Finds the closest point of the other body's surface among faces on one side of it.
    fn project(&self, vertex: u32, side: DVec3, workspace: &mut Workspace) -> Option<NearVertex> {
        // The nearest of the faces on this side.
        let position = self.body.positions()[vertex as usize];
        let other = fitted_tree(self.other);
        let mut nearest: Option<ClosestPoint> = None;
        other.tree().nearest(position, f64::INFINITY, workspace, |face, _| {
            let found = other.closest_on_face(position, face);
            let is_nearer = nearest.is_none_or(|nearest| found.is_before(&nearest));
            let is_of_piece = self.other_tissue.piece_of_face(face) == self.other_piece;
            if is_of_piece && is_nearer && self.tissue.agrees(self.normal_of_other(face), side) {
                nearest = Some(found);
            }
            nearest.map_or(f64::INFINITY, |nearest| nearest.distance)
        });

        // The way there, or the face's normal where the way is not on this side.
        let ClosestPoint { face, foot, .. } = nearest?;
        let way = (foot.point - position).normalize_or_zero();
        let is_on_side = self.tissue.agrees(way, side);
        let normal = if is_on_side { way } else { self.normal_of_other(face) };
        Some(NearVertex {
            vertex,
            gap: (position - foot.point).dot(normal),
            foot: foot.point,
            face,
            barycentric: foot.barycentric,
            normal,
        })
    }
}

/// Returns true if one of the vertices is inside.
fn has_inside(near: &[NearVertex]) -> bool {
    deepest_way(near) > 0.0
}

/// Returns the longest of the nearest ways out; 0 where no vertex is inside.
fn deepest_way(near: &[NearVertex]) -> f64 {
    let mut deepest: f64 = 0.0;
    for near in near {
        deepest = deepest.max(-near.gap);
    }
    deepest
}

#[cfg(test)]
mod tests {
    use std::collections::{BTreeMap, BTreeSet};
    use std::ops::Range;

    use fixtures::shapes;
    use scene::PairId;

    use super::*;

    use crate::run::Run;
    use crate::test_scenes::bone_and_muscle;
    use crate::{Conditions, ResolveParams};

    /// A muscle is .8 deep in a bone of 10, whose far side the vertices inside remember.
    #[test]
    fn what_left_by_its_nearest_way_is_held_out_there() {
        let plate = shapes::plate(DVec3::new(24.0, 24.0, 10.0), [6, 6]);
        let muscle = shapes::ellipsoid(DVec3::new(8.0, 8.0, 4.0), 3).translated(3.2 * DVec3::Z);
        let out: Vec<DVec3> = muscle.positions.iter().map(|x| *x + 0.9 * DVec3::Z).collect();
        let mut scene = bone_and_muscle(plate.translated(-5.0 * DVec3::Z), muscle);
        let [bone, muscle] = ["bone", "muscle"].map(|name| scene.find(name).expect("a body"));
        let first = scene.body(muscle).particles().start;
        let params = ResolveParams { gap: 0.2, ..ResolveParams::with_smoothing(6.0) };
        let conditions = Conditions::default();
        let run = Run::start(&mut scene, params, &conditions);
        let mut run = run.expect("a run");
        run.start_round();
        let through = |x: &DVec3| if x.z < 0.9 { -DVec3::Z } else { DVec3::ZERO };
        let mut memory = ExitMemory::default();
        memory.resize(out.len());
        memory.directions = out.iter().map(through).collect();
        let exits = BTreeMap::from([([0, 0], [ExitMemory::default(), memory])]);
        let memory = PairMemory { exits, ..PairMemory::default() };
        run.pair_memories.insert(PairId::new(bone, muscle), memory);

        // Deep vertices of the muscle, and those that are held outside.
        let deep = -1.1 * params.tuning.shallow_depth * params.smoothing;
        let mut vertices_at = |gaps: Range<f64>| {
            let mut vertices = BTreeSet::new();
            for contact in run.contacts().expect("contacts").iter().flatten() {
                let vertex = contact.stencil.terms().iter().find(|term| term.weight.abs() > 0.99);
                let vertex = vertex.map(|term| term.particle).filter(|vertex| *vertex >= first);
                if gaps.contains(&contact.gap) && contact.normal.z.abs() > 0.99 {
                    vertices.extend(vertex);
                }
            }
            run.move_soft(|_, _| Some(out.clone())).expect("positions");
            vertices
        };
        let inside = vertices_at(-1.0..deep);
        let outside = vertices_at(0.0..1.0);
        assert!(inside.len() > 4 && outside.is_superset(&inside), "{inside:?} {outside:?}");
    }
}
