//! Displacements that are carried over to the next state of a scene.
//!
//! Between two frames of a motion, tissue turns with its bones, and so does the push that it
//! takes. Displacements are stored in a local frame of each vertex, made of its normal and an
//! edge, and applied in the frame that the vertex has in the next state.

use glam::{DMat3, DVec3};
use scene::Scene;

use crate::spread::NEGLIGIBLE_SHARE;
use crate::tissue::Tissue;

/// Displacements of one body's vertices, each in the local frame of its vertex: |V| for a soft
/// body, none for a rigid one.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LocalDisplacements(Vec<DVec3>);

impl LocalDisplacements {
    /// Stores the displacements of a tissue at `x`.
    pub(crate) fn new(tissue: &Tissue, x: &[DVec3]) -> Self {
        let mut local = Vec::new();
        if !tissue.is_rigid {
            for (vertex, (rest, x)) in (0..).zip(tissue.rest.iter().zip(x)) {
                let u = *x - *rest;
                let is_moved = u != DVec3::ZERO;
                local.push(if is_moved { local_frame(tissue, vertex).transpose() * u } else { u });
            }
        }
        Self(local)
    }

    /// Returns true if no vertex is displaced.
    pub(crate) fn is_zero(&self) -> bool {
        self.0.iter().all(|u| *u == DVec3::ZERO)
    }

    /// Computes the positions of a tissue with these displacements.
    pub(crate) fn displace(&self, tissue: &Tissue) -> Vec<DVec3> {
        // Displacements that have faded are dropped, so that vertices return to their bits.
        let mut longest: f64 = 0.0;
        for u in &self.0 {
            longest = longest.max(u.length());
        }
        let mut x = tissue.rest.clone();
        for (vertex, (x, u)) in (0..).zip(x.iter_mut().zip(&self.0)) {
            if u.length() > NEGLIGIBLE_SHARE * longest && tissue.is_free(vertex) {
                *x += local_frame(tissue, vertex) * *u;
            }
        }
        x
    }
}

/// Returns true if displacements are of bodies like those of a scene.
pub(crate) fn fits(carried: &[LocalDisplacements], scene: &Scene) -> bool {
    let mut fits = carried.len() == scene.bodies().len();
    for (local, body) in carried.iter().zip(scene.bodies()) {
        let count = if body.is_rigid() { 0 } else { body.positions().len() };
        fits &= local.0.len() == count;
    }
    fits
}

/// Computes the orthonormal axes of a vertex: its normal, the direction across it toward its
/// first neighbor, and the direction across both.
fn local_frame(tissue: &Tissue, vertex: u32) -> DMat3 {
    let normal = tissue.rest_normals[vertex as usize];
    let Some(link) = tissue.links(vertex).first() else { return DMat3::IDENTITY };
    let edge = tissue.rest[link.neighbor as usize] - tissue.rest[vertex as usize];
    let along = edge - edge.dot(normal) * normal;
    match (normal.try_normalize(), along.try_normalize()) {
        (Some(normal), Some(along)) => DMat3::from_cols(normal, along, normal.cross(along)),
        _ => DMat3::IDENTITY,
    }
}
