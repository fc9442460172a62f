//! Sides by which deep vertices leave another body.
//!
//! The nearest way out of a thin bone may lead through to its far side. Where tissue entered
//! shows at vertices that are shallow and whose own surface faces that of the other body:
//! their exit directions are spread over all vertices inside, along the surface and through
//! the tissue. A vertex whose nearest way out points against its direction is projected
//! again, onto faces on the right side.

use glam::DVec3;
use kdop::Workspace;
use proximity::{ClosestPoint, SurfaceTree, contact};
use scene::{Body, BodyId, NearVertex, PairReport, Scene};
use surface::{Contact, parallel, triangle, vertex_normals};

use crate::spread::symmetric_sweeps;
use crate::tissue::{Tissue, fitted_tree};
use crate::tuning;

/// Exit directions of earlier rounds, of the vertices of one body out of another; 0 for
/// vertices that were never inside. A vertex keeps its direction.
pub(crate) type ExitMemory = Vec<DVec3>;

/// Exit sides for the pairs of a scene.
pub(crate) struct ExitSides<'a> {
    scene: &'a Scene,
    tissues: &'a [Tissue],
    /// Present vertex normals of all bodies.
    normals: Vec<Vec<DVec3>>,
    smoothing: f64,
}

/// Vertices of one body against another body.
struct Side<'a> {
    body: &'a Body,
    tissue: &'a Tissue,
    normals: &'a [DVec3],
    other: &'a SurfaceTree,
    smoothing: f64,
}

impl<'a> ExitSides<'a> {
    pub(crate) fn new(scene: &'a Scene, tissues: &'a [Tissue], smoothing: f64) -> Self {
        let normals = |body: &Body| vertex_normals(body.surface().faces(), body.positions());
        let normals = parallel::map_slice_with(scene.bodies(), || (), |(), body| normals(body));
        Self { scene, tissues, normals, smoothing }
    }

    /// Makes the contacts of a pair's near vertices, with their exit sides corrected.
    pub(crate) fn contacts(
        &self,
        report: &PairReport,
        [of_a, of_b]: &mut [ExitMemory; 2],
    ) -> Vec<Contact> {
        let [a, b] = report.pair.bodies();
        let vertices_of_a = self.side(a, b).correct(&report.a_against_b.near, of_a);
        let vertices_of_b = self.side(b, a).correct(&report.b_against_a.near, of_b);

        let [a, b] = [a, b].map(|id| self.scene.body(id).contact_surface());
        let contacts_of_a = vertices_of_a.iter().map(|near| contact(&a, &b, near));
        let contacts_of_b = vertices_of_b.iter().map(|near| contact(&b, &a, near));
        contacts_of_a.chain(contacts_of_b).collect()
    }

    fn side(&self, body: BodyId, other: BodyId) -> Side<'_> {
        Side {
            body: self.scene.body(body),
            tissue: &self.tissues[body.index()],
            normals: &self.normals[body.index()],
            other: fitted_tree(self.scene.body(other)),
            smoothing: self.smoothing,
        }
    }
}

impl Side<'_> {
    /// Corrects near vertices: drops those that face away from the other surface, and projects
    /// deep ones onto the side by which they entered.
    fn correct(&self, near: &[NearVertex], memory: &mut ExitMemory) -> Vec<NearVertex> {
        let workspace = &mut Workspace::default();
        if self.body.is_rigid() {
            return near.iter().filter_map(|near| self.correct_rigid(near, workspace)).collect();
        }
        let directions = self.exit_directions(near, memory);
        let mut corrected = Vec::with_capacity(near.len());
        for near in near {
            let direction = directions[near.vertex as usize];
            corrected.extend(self.correct_soft(near, direction, workspace));
        }
        corrected
    }

    /// Corrects a vertex of tissue, which leaves by the side where it entered.
    fn correct_soft(
        &self,
        near: &NearVertex,
        direction: DVec3,
        workspace: &mut Workspace,
    ) -> Option<NearVertex> {
        let is_astray = near.normal.dot(direction) < 0.0;
        if near.gap >= 0.0 {
            let is_behind = self.normal(near).dot(near.normal) > tuning::MIN_AGREEMENT;
            return (!is_astray && !is_behind).then_some(*near);
        }
        if !is_astray {
            return Some(*near);
        }
        let turned = self.project(near.vertex, direction, workspace);
        Some(turned.filter(|turned| turned.gap < 0.0).unwrap_or(*near))
    }

    /// Corrects a vertex of bone, which leaves by the side of the tissue that faces it.
    fn correct_rigid(&self, near: &NearVertex, workspace: &mut Workspace) -> Option<NearVertex> {
        let normal = self.normal(near);
        if normal.dot(near.normal) < tuning::MIN_AGREEMENT {
            return Some(*near);
        }
        if near.gap >= 0.0 {
            return None;
        }
        let max_depth = tuning::MAX_FACING_DEPTH * self.smoothing;
        let turned = self.project(near.vertex, -normal, workspace);
        turned.filter(|turned| turned.gap < 0.0 && turned.gap > -max_depth)
    }

    fn normal(&self, near: &NearVertex) -> DVec3 {
        self.normals[near.vertex as usize]
    }

    /// Computes the exit directions of vertices inside or near, |V|; 0 for others, and for all
    /// while none has been inside.
    fn exit_directions(&self, near: &[NearVertex], memory: &mut ExitMemory) -> Vec<DVec3> {
        if memory.is_empty() && !near.iter().any(|near| near.gap < 0.0) {
            return vec![DVec3::ZERO; self.normals.len()];
        }
        memory.resize(self.normals.len(), DVec3::ZERO);

        // A vertex new inside counts by how shallow it is, and by how it faces the other body.
        let mut own = memory.clone();
        for near in near.iter().filter(|near| near.gap < 0.0) {
            let direction = &mut own[near.vertex as usize];
            if *direction == DVec3::ZERO {
                let facing = (-self.normal(near).dot(near.normal)).max(0.0);
                let trust = facing * (near.gap / (tuning::TRUSTED_DEPTH * self.smoothing)).exp();
                *direction = trust * near.normal;
            }
        }

        let mut directions = own.clone();
        symmetric_sweeps(near, tuning::DIRECTION_SWEEPS, |near| {
            let mean = self.tissue.equilibrium(near.vertex, |v| directions[v as usize], 0.0);
            if let Some(mean) = mean {
                directions[near.vertex as usize] = own[near.vertex as usize] + mean;
            }
        });
        for direction in &mut directions {
            *direction = direction.normalize_or_zero();
        }

        for near in near.iter().filter(|near| near.gap < 0.0) {
            let remembered = &mut memory[near.vertex as usize];
            if *remembered == DVec3::ZERO {
                *remembered = directions[near.vertex as usize];
            }
        }
        directions
    }

    /// Finds the closest point of the other body's surface among faces on one side of it.
    fn project(&self, vertex: u32, side: DVec3, workspace: &mut Workspace) -> Option<NearVertex> {
        let position = self.body.positions()[vertex as usize];
        let is_on_side = |direction: DVec3| direction.dot(side) > tuning::MIN_AGREEMENT;
        let face_normal = |face: u32| triangle::unit_normal(self.other.corners(face));

        let mut nearest: Option<ClosestPoint> = None;
        self.other.tree().nearest(position, f64::INFINITY, workspace, |face, _| {
            let found = self.other.closest_on_face(position, face);
            let is_nearer = nearest.is_none_or(|nearest| found.is_before(&nearest));
            if is_nearer && is_on_side(face_normal(face)) {
                nearest = Some(found);
            }
            nearest.map_or(f64::INFINITY, |nearest| nearest.distance)
        });

        let ClosestPoint { face, foot, .. } = nearest?;
        let way = (foot.point - position).normalize_or_zero();
        let normal = if is_on_side(way) { way } else { face_normal(face) };
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
