//! Displacements handed on from one state of a scene to the next.
//!
//! Between two frames of a motion tissue turns with its bones, and so does the
//! push that it takes: displacements are kept in a frame of each vertex, made
//! of its normal and of an edge, and put back into the frame that the vertex
//! has in the next state.

use glam::{DMat3, DVec3};

use super::tissue::Tissue;
use crate::scene::Body;
use crate::{BodyKind, Scene};

/// Share of a displacement that is handed on. What is still needed is pushed
/// again, and by the more rounds the less is kept; what is needed no more
/// fades by this share a frame, and so the later the more is kept.
const KEPT: f64 = 0.98;

/// Displacement below which a vertex is put back where it was, as a share of
/// the body's largest.
const FADED: f64 = 1e-3;

/// Displacements of one body's vertices, each in the frame of its vertex.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Carried(Vec<DVec3>);

impl Carried {
    /// Takes the displacements of a body from `tissue`'s rest.
    pub(super) fn take(body: &Body, tissue: &Tissue) -> Self {
        let moved = tissue.rest.iter().zip(body.positions()).map(|(rest, x)| *x - *rest);
        let local = (0..).zip(moved).map(|(vertex, u)| {
            if u == DVec3::ZERO { u } else { frame(tissue, vertex).transpose() * u }
        });
        Self(local.collect())
    }

    /// Where the vertices of `tissue` are when displaced as they were.
    pub(super) fn displaced(&self, tissue: &Tissue) -> Vec<DVec3> {
        let longest = self.0.iter().map(|u| u.length()).fold(0.0, f64::max);
        let displace = |(vertex, (rest, u)): (u32, (&DVec3, &DVec3))| {
            if u.length() <= FADED * longest {
                *rest
            } else {
                *rest + KEPT * (frame(tissue, vertex) * *u)
            }
        };
        (0..).zip(tissue.rest.iter().zip(&self.0)).map(displace).collect()
    }

    /// Whether it was taken from a body like this.
    fn fits(&self, body: &Body) -> bool {
        self.0.len() == body.positions().len()
    }
}

/// Takes the displacements of all soft bodies; none of rigid ones.
pub(super) fn take(scene: &Scene, tissues: &[Tissue]) -> Vec<Option<Carried>> {
    let of_body = |(body, tissue): (&Body, &Tissue)| {
        (body.kind() != BodyKind::Rigid).then(|| Carried::take(body, tissue))
    };
    scene.bodies().iter().zip(tissues).map(of_body).collect()
}

/// Whether displacements were taken from bodies like those of a scene.
pub(super) fn fit(carried: &[Option<Carried>], scene: &Scene) -> bool {
    let fits = |(carried, body): (&Option<Carried>, &Body)| match carried {
        Some(carried) => body.kind() != BodyKind::Rigid && carried.fits(body),
        None => body.kind() == BodyKind::Rigid,
    };
    carried.len() == scene.bodies().len() && carried.iter().zip(scene.bodies()).all(fits)
}

/// Orthonormal axes of a vertex: its normal, and across it towards the first
/// of its neighbours.
fn frame(tissue: &Tissue, vertex: u32) -> DMat3 {
    let normal = tissue.normals[vertex as usize];
    let edge = tissue.neighbours(vertex).first().map_or(DVec3::ZERO, |&(next, _)| {
        tissue.rest[next as usize] - tissue.rest[vertex as usize]
    });
    let along = edge - edge.dot(normal) * normal;
    match (normal.try_normalize(), along.try_normalize()) {
        (Some(normal), Some(along)) => DMat3::from_cols(normal, along, normal.cross(along)),
        _ => DMat3::IDENTITY,
    }
}
