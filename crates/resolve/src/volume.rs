//! Restoration of the volume that pushes took from a body, where it is free.

use glam::DVec3;
use surface::vertex_normals;

use super::near_pairs::NearPairs;
use super::tissue::{Tissue, volume};
use super::tuning;
use scene::Body;
use scene::{BodyId, BodyKind};

/// Moves free vertices of a body along their normals until its volume is that at rest.
///
/// Free are vertices that have moved and that are not near another body.
pub(super) fn restore(body: &Body, tissue: &Tissue, x: &mut [DVec3], near: &NearPairs, id: BodyId) {
    let faces = body.surface().faces();
    let missing = tissue.volume - volume(faces, x);
    let ignored = tuning::IGNORED_VOLUME_CHANGE * tissue.volume.abs();
    if body.has_inside().is_err() || missing.abs() <= ignored {
        return;
    }

    // Each vertex moves in proportion to its displacement so far.
    let weights = free_displacements(tissue, x, near, id);
    let area: f64 = weights.iter().zip(&tissue.areas).map(|(weight, area)| weight * area).sum();
    if area > 0.0 {
        let normals = vertex_normals(faces, x);
        let rate = (missing / area).clamp(-tuning::MAX_VOLUME_STEP, tuning::MAX_VOLUME_STEP);
        for ((x, weight), normal) in x.iter_mut().zip(weights).zip(normals) {
            *x += rate * weight * normal;
        }
    }
}

/// Computes the relative change of a soft body's volume; 0 for bodies without an inside.
pub(super) fn relative_change(body: &Body, tissue: &Tissue) -> f64 {
    let has_volume = body.kind() != BodyKind::Rigid && body.has_inside().is_ok();
    if !has_volume || tissue.volume == 0.0 {
        return 0.0;
    }
    (volume(body.surface().faces(), body.positions()) / tissue.volume - 1.0).abs()
}

/// Computes the distance of each free vertex from rest, |V|; 0 for others.
fn free_displacements(tissue: &Tissue, x: &[DVec3], near: &NearPairs, id: BodyId) -> Vec<f64> {
    let mut free: Vec<f64> = tissue.rest.iter().zip(x).map(|(rest, x)| rest.distance(*x)).collect();
    for pair in near.iter() {
        let report = &pair.report;
        for (body, vertices) in
            [(report.pair.a, &report.a_against_b), (report.pair.b, &report.b_against_a)]
        {
            if body == id {
                vertices.near.iter().for_each(|near| free[near.vertex as usize] = 0.0);
            }
        }
    }
    free
}
