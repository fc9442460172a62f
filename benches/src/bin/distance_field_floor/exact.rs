//! Exact distances at many points.

use benches::bodies::{Body, Depth};
use fixtures::sampling::Truth;
use glam::DVec3;
use indicatif::ProgressBar;
use kdop::Workspace;
use rayon::prelude::*;

/// Parts that the work is told of in.
pub(crate) const PARTS: u64 = 40;

/// What is true at points whose side is not in doubt, in their order.
pub(crate) fn truths(body: &Body, points: &[DVec3], progress: &ProgressBar) -> Vec<Truth> {
    let depth = Depth::new(body);
    let truth = |workspace: &mut Workspace, &point: &DVec3| {
        let (foot, depth) = depth.foot(point, f64::INFINITY, workspace).expect("a bone has faces");
        Truth::new(point, foot, -depth)
    };
    let part = |points: &[DVec3]| {
        let of_part = points.par_iter().map_init(Workspace::default, truth);
        let truths: Vec<Truth> = of_part.flatten_iter().collect();
        progress.inc(1);
        truths
    };
    let parts = usize::try_from(PARTS).expect("few");
    points.chunks(points.len().div_ceil(parts).max(1)).flat_map(part).collect()
}
