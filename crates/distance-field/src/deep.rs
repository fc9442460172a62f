//! Measured error of a field far from its surface, where it is largest.
//!
//! Far from the surface two errors add up: nodes beyond the band may have taken over a face that
//! is not the nearest, and distances have creases along the medial axis, which interpolation
//! rounds off. Both are largest at the creases, where the gradient of the interpolated distance is
//! shorter than 1: a crease through the middle of a cell leaves it none, and the largest error.
//! Samples are therefore the middles of the cells with the shortest gradients, among many cells
//! that are spread evenly over the grid. As near the surface, a value of the wrong sign is off by
//! the sum of both distances.

use glam::DVec3;
use surface::parallel;
use surface::progress::{Interrupted, Progress};

use crate::accuracy::{AccuracyParams, MAX_HEIGHT, SampleSigns, quasirandom};
use crate::face_groups::FaceGroups;
use crate::num::coordinate;
use crate::{DistanceField, Interpolation, MeasuredError, Storage};

/// Points that are drawn per sample.
///
/// Fewer miss creases; more cost a query each.
const DRAWN_PER_SAMPLE: usize = 64;

/// Spacings by which a distance may exceed the value of the field.
///
/// Values at nodes are too small by at most half the diagonal of a voxel, and those between them by
/// half the diagonal of a cell more: √3/2 + √3/2 spacings at most.
const MAX_SHORTFALL: f64 = 2.0;

/// Point far from the surface, at which the field is compared.
#[derive(Clone, Copy)]
struct DeepSample {
    point: DVec3,
    /// Distance that the field has there.
    value: f64,
    /// Length of its gradient.
    slope: f64,
}

/// Compares a field with exact distances at places farther than two spacings from the
/// surface; `None` where the field has no such place below its truncation.
pub(crate) fn deep_error(
    field: &DistanceField,
    groups: &FaceGroups<'_>,
    params: AccuracyParams,
    progress: Progress<'_>,
) -> Result<Option<MeasuredError>, Interrupted> {
    let AccuracyParams { samples: count, truncation, rule, .. } = params;
    let (early, late) = (progress.part(0.0, 0.1), progress.part(0.1, 1.0));
    let spacing = field.grid().spacing();
    let samples = creases(field, count, truncation);
    let points: Vec<DVec3> = samples.iter().map(|sample| sample.point).collect();
    let signs = SampleSigns::new(groups, &points, rule, early)?;

    let steps = late.steps(samples.len());
    let errors = parallel::map(samples.len(), |i| {
        steps.advance(1)?;
        let DeepSample { point, value, .. } = samples[i];
        let exact = groups.distance(point, value.abs() + MAX_SHORTFALL * spacing);
        Ok(signs.error(i, value, exact.min(truncation)))
    });

    let (mut squares, mut max) = (0.0, 0.0_f64);
    for error in errors {
        let error = error?;
        squares += error * error;
        max = max.max(error);
    }
    let points = samples.len();
    let rms = (squares / coordinate(points)).sqrt();
    Ok((points > 0).then_some(MeasuredError { points, rms, max }))
}

/// Returns the middles of the cells of the shortest gradients among many that are spread over the
/// grid.
fn creases(field: &DistanceField, count: usize, truncation: f64) -> Vec<DeepSample> {
    let grid = field.grid();
    let cells = DVec3::from_array(grid.dims().map(|n| coordinate(n.saturating_sub(1))));
    let min_height = MAX_HEIGHT * grid.spacing();

    // Values at the truncation are stored rounded, and then less than it.
    let step = match field.storage() {
        Storage::Float => 0.0,
        Storage::Quantized { step } => step,
    };
    let least_truncated = (1.0 - f64::from(f32::EPSILON)) * truncation - 0.5 * step;

    let mut samples = Vec::new();
    for n in 0..count * DRAWN_PER_SAMPLE {
        let cell = (quasirandom(n) * cells).floor() + 0.5;
        let point = grid.origin() + cell * grid.spacing();
        let Some(found) = field.evaluate(point, Interpolation::Trilinear) else { continue };
        let (value, height) = (found.distance, found.distance.abs());
        if height > min_height && height < least_truncated {
            samples.push(DeepSample { point, value, slope: found.gradient.length() });
        }
    }
    samples.sort_by(|a, b| a.slope.total_cmp(&b.slope));
    samples.truncate(count);
    samples
}
