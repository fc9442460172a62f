//! Restoration of the volume that pushes took from a body, where it is free.

use glam::DVec3;
use scene::BodyId;
use surface::vertex_normals;

use crate::near_pairs::NearPairs;
use crate::tissue::Tissue;
use crate::tuning;

/// Moves free vertices of a body along their normals until its volume is that at rest.
///
/// Free are vertices that have moved and that are not near another body.
pub(crate) fn restore(tissue: &Tissue, x: &mut [DVec3], near: &NearPairs, id: BodyId) {
    let Some(volume) = tissue.volume else { return };
    let missing = volume - tissue.volume_at(x);
    if missing.abs() <= tuning::IGNORED_VOLUME_CHANGE * volume.abs() {
        return;
    }

    // Each vertex moves in proportion to its displacement so far.
    let weights = free_displacements(tissue, x, near, id);
    let area: f64 = weights.iter().zip(&tissue.areas).map(|(weight, area)| weight * area).sum();
    if area > 0.0 {
        let normals = vertex_normals(tissue.surface.faces(), x);
        let rate = (missing / area).clamp(-tuning::MAX_VOLUME_STEP, tuning::MAX_VOLUME_STEP);
        for ((x, weight), normal) in x.iter_mut().zip(weights).zip(normals) {
            *x += rate * weight * normal;
        }
    }
}

/// Computes the relative change of a body's volume; 0 for bodies without one.
pub(crate) fn relative_change(tissue: &Tissue, x: &[DVec3]) -> f64 {
    match tissue.volume {
        Some(volume) if volume != 0.0 => (tissue.volume_at(x) / volume - 1.0).abs(),
        _ => 0.0,
    }
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
