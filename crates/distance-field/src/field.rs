//! Signed distance field on a regular grid.

use surface::Pose;

use crate::frame::Frame;
use crate::store::NodeStore;
use crate::{FieldError, FieldGrid, FieldReport, NodeValues, Storage};

/// Signed distance field on a regular grid: distances at its nodes, negative inside, and
/// values between them by interpolation.
///
/// Built by [`DistanceField::build`] or read back by [`DistanceField::from_values`]; queried
/// by [`DistanceField::evaluate`], [`DistanceField::query`] and
/// [`DistanceField::query_batch`].
#[derive(Clone, Debug)]
pub struct DistanceField {
    pub(crate) grid: FieldGrid,
    /// Map from the field's own frame to the grid.
    pub(crate) frame: Frame,
    pub(crate) store: NodeStore,
    pub(crate) node_values: NodeValues,
    pub(crate) report: FieldReport,
}

impl DistanceField {
    /// Returns a field of one value per node, x running fastest, as a file holds them.
    ///
    /// # Errors
    ///
    /// - [`FieldError::ValueCount`] unless there is one value per node.
    /// - [`FieldError::NotFinite`] with the first node whose value is not finite.
    /// - [`FieldError::StepTooSmall`] and [`FieldError::InvalidParam`] as the storage
    ///   requires.
    pub fn from_values(
        grid: FieldGrid,
        values: Vec<f32>,
        storage: Storage,
    ) -> Result<Self, FieldError> {
        if values.len() != grid.node_count() {
            return Err(FieldError::ValueCount { expected: grid.node_count(), got: values.len() });
        }
        if let Some(node) = values.iter().position(|value| !value.is_finite()) {
            return Err(FieldError::NotFinite { node });
        }
        let store = NodeStore::new(values, &grid, storage)?;
        Ok(Self::new(grid, store, FieldReport::default()))
    }

    /// Returns a field whose nodes hold distances.
    pub(crate) fn new(grid: FieldGrid, store: NodeStore, report: FieldReport) -> Self {
        let frame = Frame::new(&grid, &Pose::IDENTITY);
        Self { grid, frame, store, node_values: NodeValues::Interpolating, report }
    }

    /// Returns the same values with another meaning: those of a file may be coefficients of
    /// a quasi-interpolation, while [`Self::from_values`] takes them for distances.
    #[must_use]
    pub fn with_node_values(self, node_values: NodeValues) -> Self {
        Self { node_values, ..self }
    }

    /// Returns the grid.
    #[must_use]
    pub fn grid(&self) -> &FieldGrid {
        &self.grid
    }

    /// Returns the report of the build.
    #[must_use]
    pub fn report(&self) -> &FieldReport {
        &self.report
    }

    /// Returns the value of a node, in the length unit.
    ///
    /// # Panics
    ///
    /// When there is no such node.
    #[must_use]
    pub fn node(&self, node: [usize; 3]) -> f64 {
        self.store.node(node)
    }

    /// Returns the values of all nodes, x running fastest, as [`Self::from_values`] takes
    /// them.
    #[must_use]
    pub fn values(&self) -> Vec<f32> {
        self.store.to_floats()
    }

    /// Returns the meaning of the values at nodes.
    #[must_use]
    pub fn node_values(&self) -> NodeValues {
        self.node_values
    }

    /// Returns the number format of the values.
    #[must_use]
    pub fn storage(&self) -> Storage {
        self.store.storage()
    }

    /// Returns the memory of the values, in bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.store.bytes()
    }
}
