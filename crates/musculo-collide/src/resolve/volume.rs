//! Gives a body back the volume that pushes took from it, where it is free.

use glam::DVec3;

use super::contacts::vertex_normals;
use super::tissue::{Tissue, volume};
use crate::scene::Body;
use crate::{BodyId, BodyKind, PairReport, VertexReport};

/// Change of volume, as a share, that is left alone: below it, giving volume
/// back would move vertices for nothing that can be measured.
const TOLERATED: f64 = 0.002;

/// Most that a vertex is moved in a round, in what it has moved before.
const MOST: f64 = 0.5;

/// Moves free vertices of a body along their normals until its volume is the
/// one it had. Free are those that have moved and were not near another body.
pub(super) fn restore(
    body: &Body,
    tissue: &Tissue,
    x: &mut [DVec3],
    pairs: &[PairReport],
    id: BodyId,
) {
    if body.has_inside().is_err() {
        return;
    }
    let faces = body.surface().faces();
    let missing = tissue.volume - volume(faces, x);
    if missing.abs() <= TOLERATED * tissue.volume.abs() {
        return;
    }
    let weights = free_weights(tissue, x, pairs, id);
    let area: f64 = weights.iter().zip(&tissue.areas).map(|(weight, area)| weight * area).sum();
    if area > 0.0 {
        let normals = vertex_normals(body.surface(), x);
        let rate = (missing / area).clamp(-MOST, MOST);
        for ((x, weight), normal) in x.iter_mut().zip(weights).zip(normals) {
            *x += rate * weight * normal;
        }
    }
}

/// Change of a soft body's volume, as a share; 0 for what has none.
pub(super) fn change(body: &Body, tissue: &Tissue) -> f64 {
    let counts = body.kind() != BodyKind::Rigid && body.has_inside().is_ok();
    if counts && tissue.volume != 0.0 {
        (volume(body.surface().faces(), body.positions()) / tissue.volume - 1.0).abs()
    } else {
        0.0
    }
}

fn free_weights(tissue: &Tissue, x: &[DVec3], pairs: &[PairReport], id: BodyId) -> Vec<f64> {
    let mut weights: Vec<f64> =
        tissue.rest.iter().zip(x).map(|(rest, x)| rest.distance(*x)).collect();
    let mut hold = |report: &VertexReport| {
        report.near.iter().for_each(|near| weights[near.vertex as usize] = 0.0);
    };
    for pair in pairs {
        if pair.a == id {
            hold(&pair.a_against_b);
        } else if pair.b == id {
            hold(&pair.b_against_a);
        }
    }
    weights
}
