//! Volume of each body as an equality of an elastic problem, gained part by part.

use std::ops::Range;

use glam::DVec3;

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
    /// Numbers of what parts of other bodies gain of it.
    pub(crate) shared: Vec<usize>,
    pub(crate) multiplier: SharedNumber,
    /// Volume that was gained before the present sweep.
    pub(crate) gained: SharedNumber,
}

/// Volume of a body that a part of another one gains, by particles that are of both.
#[derive(Default)]
pub(crate) struct SharedGain {
    pub(crate) part: usize,
    pub(crate) body: usize,
    /// Volume that parts of colors before have gained in the present sweep.
    pub(crate) before: SharedNumber,
    /// Volume that the part has gained in it.
    pub(crate) gained: SharedNumber,
}

/// Gradient of a body's volume with respect to a particle of a part that shares in its gain.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RelaxedArea {
    pub(crate) area: DVec3,
    pub(crate) body: usize,
    /// Number of the gain.
    pub(crate) gain: usize,
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
