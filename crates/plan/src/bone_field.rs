//! Distance field of a rigid body, as fine as a tolerance needs.

use distance_field::{DistanceField, FieldDetector, FieldMethod, FieldParams, NodeValues};
use glam::DVec3;
use scene::Body;
use surface::progress::Progress;

use crate::{Accuracy, ExclusionReason};

/// Distance field of a rigid body.
#[derive(Debug)]
pub(crate) struct BoneField {
    pub(crate) detector: FieldDetector,
    pub(crate) accuracy: Accuracy,
}

/// Grid of a field that is yet to be built.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FieldSize {
    pub(crate) spacing: f64,
    pub(crate) nodes: f64,
}

/// Proved bound of a field with an exact band \[spacings\]: half the diagonal of a cell, the
/// correction of a quasi-interpolation, and rounding.
const BOUND: f64 = 0.992;

/// Depth below which points are projected to the body itself \[spacings\]: less than the band less
/// the bound and the diagonal of a cell, so that the bound holds for all others.
pub(crate) const MAX_DEPTH: f64 = 1.25;

/// Band beyond the largest distance of a contact \[spacings\]: the bound and the diagonal of a cell.
const BAND_RESERVE: f64 = 2.75;

/// Largest number of nodes: a second to build and 32 MB. Above, a coarser field is built, whose
/// bound exceeds the tolerance.
const MAX_NODES: f64 = 8.0 * 1024.0 * 1024.0;

/// Factor between two spacings that are tried for the number of nodes.
const SPACING_STEP: f64 = 1.1;

impl FieldSize {
    /// Returns the grid of a field whose bound is within a tolerance, or the finest one with a
    /// bounded number of nodes.
    pub(crate) fn new(body: &Body, tolerance: f64, margin: f64) -> Self {
        let bounds = body.face_bounds();
        // A smaller spacing would not grow by steps.
        let mut spacing = (tolerance / BOUND).max(f64::MIN_POSITIVE);
        while spacing.is_finite() {
            let sides = bounds.sides() + 2.0 * padding(spacing, tolerance, margin);
            let nodes = (sides / spacing + DVec3::splat(2.0)).element_product();
            if nodes <= MAX_NODES {
                return Self { spacing, nodes };
            }
            spacing *= SPACING_STEP;
        }
        Self { spacing: f64::INFINITY, nodes: f64::INFINITY }
    }

    /// Returns the proved bound.
    pub(crate) fn bound(self) -> f64 {
        BOUND * self.spacing
    }
}

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

        // A band that holds all contacts which are not projected.
        let FieldSize { spacing, .. } = FieldSize::new(body, tolerance, margin);
        let band = BAND_RESERVE + MAX_DEPTH.max(margin / spacing);
        let params = FieldParams {
            padding: padding(spacing, tolerance, margin),
            truncation: None,
            method: FieldMethod::ExactBand { band, node_values: NodeValues::QuasiInterpolating },
            ..FieldParams::new(spacing)
        };
        let refuse = |source| ExclusionReason::Field { spacing, source };
        let field = DistanceField::build(surface, x, &params, progress).map_err(refuse)?;

        let report = field.report();
        let accuracy = Accuracy {
            bound: report.error_bound.unwrap_or(f64::INFINITY),
            is_proved: report.error_bound.is_some(),
            measured_error: report.measured_error.map(|measured| measured.max),
        };
        let detector = FieldDetector::new(field, margin).map_err(refuse)?;
        Ok(Self { detector, accuracy })
    }
}

/// Returns the room around the body for contacts within the margin, and for the error.
fn padding(spacing: f64, tolerance: f64, margin: f64) -> f64 {
    margin + tolerance + 2.0 * spacing
}
