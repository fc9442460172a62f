//! Distance field of a rigid body, as fine as a tolerance needs.

use distance_field::{DistanceField, FieldDetector, FieldParams};
use scene::Body;
use surface::progress::Progress;

use crate::ExclusionReason;

/// Distance field whose measured error is within a tolerance.
#[derive(Debug)]
pub(crate) struct BoneField {
    pub(crate) detector: FieldDetector,
    /// Largest error that was measured near the surface.
    pub(crate) measured_error: f64,
}

/// Spacing that is tried first \[tolerances\]: trilinear values of a bone are wrong by a quarter of
/// a spacing at its sharpest rims. Below, fields are finer than needed; above, more are tried.
const FIRST_SPACING: f64 = 4.0;

/// Number of spacings that are tried.
const MAX_ATTEMPTS: u32 = 4;

/// Largest factor between one spacing and the next, and what is taken off the one that would be
/// in proportion: rims are not sampled where their error is largest. Above, more are tried.
const MAX_REFINEMENT: f64 = 0.7;
const REFINEMENT_RESERVE: f64 = 0.8;

/// Largest memory of a field while it is built \[bytes\].
const MAX_BYTES: u64 = 1 << 28;

impl BoneField {
    /// Builds the field of a rigid body at the positions it was added with.
    pub(crate) fn build(
        body: &Body,
        tolerance: f64,
        margin: f64,
        progress: Progress<'_>,
    ) -> Result<Self, ExclusionReason> {
        // The frame of the field is that in which the body was added.
        let reference = body.reference().ok_or(ExclusionReason::NotRigid)?;
        let surface = body.surface();
        let x = surface.positions(reference).map_err(|_| ExclusionReason::NotRigid)?;

        let mut spacing = FIRST_SPACING * tolerance;
        let mut attempt = 1;
        loop {
            // Room for contacts within the margin, and for the error.
            let params = FieldParams {
                padding: margin + tolerance + 2.0 * spacing,
                truncation: None,
                max_bytes: MAX_BYTES,
                ..FieldParams::new(spacing)
            };
            let refuse = |source| ExclusionReason::Field { spacing, source };
            let progress = progress.part(f64::from(attempt - 1) / f64::from(MAX_ATTEMPTS), 1.0);
            let field = DistanceField::build(surface, x, &params, progress).map_err(refuse)?;

            let measured = field.report().measured_error;
            let measured_error = measured.map_or(f64::INFINITY, |measured| measured.max);
            if measured_error <= tolerance {
                let detector = FieldDetector::new(field, margin).map_err(refuse)?;
                return Ok(Self { detector, measured_error });
            }

            // Finer, in proportion to the error.
            if attempt == MAX_ATTEMPTS {
                let error = measured_error;
                return Err(ExclusionReason::FieldInaccurate { spacing, error, tolerance });
            }
            spacing *= (REFINEMENT_RESERVE * tolerance / measured_error).min(MAX_REFINEMENT);
            attempt += 1;
        }
    }
}
