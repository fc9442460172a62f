//! Detection of all contacts of a scene, and the distances within which rounds detect and push.

use scene::{CheckParams, PairId, PairReport, Scene};
use surface::progress::Progress;

use crate::params::tolerance_of;
use crate::{ResolveError, ResolveParams};

/// Detects all contacts, and measures the overlaps with depths in brackets of a width.
pub(crate) fn check(
    scene: &mut Scene,
    margin: f64,
    width: f64,
    progress: Progress<'_>,
) -> Result<Vec<PairReport>, ResolveError> {
    // Near pairs are left without measures: their areas are of no use here, and take longer.
    let mut reports = scene.check(&CheckParams::without_measures(margin), progress)?;
    let overlapping = reports.iter_mut().filter(|report| report.overlaps);
    let (pairs, reports_of): (Vec<PairId>, Vec<&mut PairReport>) =
        overlapping.map(|report| (report.pair, report)).unzip();
    let overlaps = scene.pair_overlaps(&pairs, Some(width), progress)?;
    for (report, overlap) in reports_of.into_iter().zip(overlaps) {
        report.overlap = overlap;
    }
    Ok(reports)
}

/// Returns the gap to which overlaps are pushed apart: beyond that asked for where this is
/// little beside the tolerance or the pushes, so that edges of curved surfaces do not cross between
/// their vertices.
pub(crate) fn clearance(params: &ResolveParams) -> f64 {
    let tolerance = params.tolerance.max(tolerance_of(params.smoothing));
    params.gap.max(0.5 * tolerance)
}

/// Returns the margin within which contacts are detected.
pub(crate) fn detection_margin(params: &ResolveParams) -> f64 {
    2.0 * clearance(params) + params.tuning.detection_margin * params.max_step()
}
