//! A bone's field, as fine as a tolerance asks.

use distance_field::{DistanceField, FieldDetector, FieldError, FieldParams};
use surface::progress::Progress;

use crate::ExclusionReason;
use scene::Body;

/// A field whose error near the surface is within what was asked.
#[derive(Debug)]
pub(super) struct BoneField {
    pub(super) detector: FieldDetector,
    /// No value near the surface is wronger.
    pub(super) error_bound: f64,
}

/// The first spacing tried, over the tolerance: trilinear values of a bone are
/// wrong by a quarter of a spacing at its sharpest rims.
const SPACING: f64 = 4.0;

/// Spacings tried before a field is given up.
const ATTEMPTS: u32 = 4;

/// Bytes that one field may take while it is built.
const MOST_BYTES: u64 = 1 << 28;

impl BoneField {
    /// Builds the field of a rigid body where it was added.
    pub(super) fn build(body: &Body, tolerance: f64, margin: f64) -> Result<Self, ExclusionReason> {
        let reference = body.reference().ok_or(ExclusionReason::NotRigid)?;
        let surface = body.surface();
        let x = surface.positions(reference).map_err(|_| ExclusionReason::NotRigid)?;
        let mut spacing = SPACING * tolerance;
        for _ in 0..ATTEMPTS {
            let params = FieldParams {
                padding: margin + tolerance + 2.0 * spacing,
                truncation: None,
                max_bytes: MOST_BYTES,
                ..FieldParams::new(spacing)
            };
            let field = match DistanceField::build(surface, x, &params, Progress::none()) {
                Ok(field) => field,
                Err(FieldError::TooLarge { .. } | FieldError::AxisTooLong { .. }) => {
                    return Err(ExclusionReason::FieldTooLarge { spacing });
                }
                Err(source) => return Err(ExclusionReason::Field { reason: source.to_string() }),
            };
            let error_bound =
                field.report().measured_error.map_or(f64::INFINITY, |error| error.max);
            if error_bound <= tolerance {
                let detector = FieldDetector::new(field, margin)
                    .map_err(|source| ExclusionReason::Field { reason: source.to_string() })?;
                return Ok(Self { detector, error_bound });
            }
            // Less than in proportion, since rims are not sampled where they are worst.
            spacing *= (0.8 * tolerance / error_bound).min(0.7);
        }
        Err(ExclusionReason::FieldTooWrong { spacing })
    }
}
