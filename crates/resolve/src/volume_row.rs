//! Volume of each body as an equality of an elastic problem, gained part by part.

use std::ops::Range;

use crate::parts::Part;
use crate::shared_number::SharedNumber;

/// Volume of a body as an equality.
#[derive(Default)]
pub(crate) struct VolumeRow {
    /// Volume to be gained.
    pub(crate) missing: f64,
    /// Stiffness of the augmented term.
    pub(crate) penalty: f64,
    /// Parts of the body.
    pub(crate) parts: Range<usize>,
    pub(crate) multiplier: SharedNumber,
    /// Volume that was gained before the present sweep.
    pub(crate) gained: SharedNumber,
}

impl VolumeRow {
    /// Returns the pressure once more volume was gained in the present sweep.
    pub(crate) fn force(&self, gained: f64) -> f64 {
        self.multiplier.get() + self.penalty * (self.missing - self.gained.get() - gained)
    }
}

/// Makes the row of each body's volume, of which some is missing.
pub(crate) fn volume_rows(missing: Vec<f64>, parts: &[Part]) -> Vec<VolumeRow> {
    let mut rows = Vec::with_capacity(missing.len());
    for (body, missing) in missing.into_iter().enumerate() {
        let first = parts.partition_point(|part| part.body < body);
        let end = parts.partition_point(|part| part.body <= body);
        rows.push(VolumeRow { missing, parts: first..end, ..VolumeRow::default() });
    }
    rows
}
