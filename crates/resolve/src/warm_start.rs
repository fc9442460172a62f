//! Warm start of overlap removal: displacements carried over to the next state of a scene.
//!
//! Between two frames of a motion, tissue turns with its bones, and so does the push that it
//! takes. Displacements are stored in a local frame of each vertex, made of its normal and an
//! edge, and applied in the frame that the vertex has in the next state.

use glam::{DMat3, DVec3};
use scene::{Body, Scene};

use crate::tissue::Tissue;
use crate::tuning;

/// Displacements of one body's vertices, each in the local frame of its vertex, |V|.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LocalDisplacements(Vec<DVec3>);

impl LocalDisplacements {
    /// Stores the displacements of a body from its tissue's rest.
    fn new(body: &Body, tissue: &Tissue) -> Self {
        let moved = tissue.rest.iter().zip(body.positions()).map(|(rest, x)| *x - *rest);
        let local = (0..).zip(moved).map(|(vertex, u)| {
            if u == DVec3::ZERO { u } else { local_frame(tissue, vertex).transpose() * u }
        });
        Self(local.collect())
    }

    /// Computes the positions of a tissue with these displacements.
    pub(crate) fn displace(&self, tissue: &Tissue) -> Vec<DVec3> {
        let longest = self.0.iter().map(|u| u.length()).fold(0.0, f64::max);
        let mut x = tissue.rest.clone();
        for (vertex, (x, u)) in (0..).zip(x.iter_mut().zip(&self.0)) {
            if u.length() > tuning::MIN_CARRIED * longest {
                *x += tuning::CARRIED_SHARE * (local_frame(tissue, vertex) * *u);
            }
        }
        x
    }
}

/// Stores the displacements of all soft bodies of a scene; none for rigid ones.
pub(crate) fn local_displacements(
    scene: &Scene,
    tissues: &[Tissue],
) -> Vec<Option<LocalDisplacements>> {
    let of_body = |(body, tissue): (&Body, &Tissue)| {
        (!body.is_rigid()).then(|| LocalDisplacements::new(body, tissue))
    };
    scene.bodies().iter().zip(tissues).map(of_body).collect()
}

/// Returns the displacements if they are of bodies like those of a scene, and none otherwise.
pub(crate) fn fitting<'a>(
    carried: &'a [Option<LocalDisplacements>],
    scene: &Scene,
) -> &'a [Option<LocalDisplacements>] {
    let fits = |(carried, body): (&Option<LocalDisplacements>, &Body)| match carried {
        Some(local) => !body.is_rigid() && local.0.len() == body.positions().len(),
        None => body.is_rigid(),
    };
    let as_many = carried.len() == scene.bodies().len();
    let all_fit = as_many && carried.iter().zip(scene.bodies()).all(fits);
    if all_fit { carried } else { &[] }
}

/// Computes the orthonormal axes of a vertex: its normal, the direction across it toward its
/// first neighbor, and the direction across both.
fn local_frame(tissue: &Tissue, vertex: u32) -> DMat3 {
    let normal = tissue.normals[vertex as usize];
    let edge = tissue.links(vertex).first().map_or(DVec3::ZERO, |link| {
        tissue.rest[link.neighbor as usize] - tissue.rest[vertex as usize]
    });
    let along = edge - edge.dot(normal) * normal;
    match (normal.try_normalize(), along.try_normalize()) {
        (Some(normal), Some(along)) => DMat3::from_cols(normal, along, normal.cross(along)),
        _ => DMat3::IDENTITY,
    }
}
