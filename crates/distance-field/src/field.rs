//! A signed distance field over a grid.

use crate::frame::Frame;
use crate::store::Store;
use surface::Pose;

use crate::{FieldError, FieldGrid, FieldReport, NodeValues, Storage};

/// Signed distances at the nodes of a grid, negative inside, and what lies
/// between them by interpolation.
///
/// Built by [`DistanceField::build`] or read back by
/// [`DistanceField::from_values`]; asked by [`DistanceField::evaluate`],
/// [`DistanceField::query`] and [`DistanceField::query_batch`].
#[derive(Clone, Debug)]
pub struct DistanceField {
    pub(crate) grid: FieldGrid,
    /// Where the grid is in the field's own frame.
    pub(crate) frame: Frame,
    pub(crate) store: Store,
    pub(crate) nodes: NodeValues,
    pub(crate) report: FieldReport,
}

impl DistanceField {
    /// A field from one value a node, x running fastest, as a file holds them.
    ///
    /// # Errors
    ///
    /// - [`FieldError::ValueCount`] when there is not one value a node.
    /// - [`FieldError::NotFinite`] with the first node whose value is not.
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
        let store = Store::new(values, &grid, storage)?;
        Ok(Self::new(grid, store, FieldReport::default()))
    }

    /// With nodes that hold distances.
    pub(crate) fn new(grid: FieldGrid, store: Store, report: FieldReport) -> Self {
        let frame = Frame::new(&grid, &Pose::IDENTITY);
        Self { grid, frame, store, nodes: NodeValues::Interpolating, report }
    }

    /// The same values, said to be right for what is given: a file may know that they
    /// are of a quasi-interpolation. Of values alone, [`Self::from_values`] takes it that
    /// they are the distances at nodes.
    #[must_use]
    pub fn with_node_values(self, nodes: NodeValues) -> Self {
        Self { nodes, ..self }
    }

    /// The grid that the field is kept on.
    #[must_use]
    pub fn grid(&self) -> &FieldGrid {
        &self.grid
    }

    /// What the build found, and what it cost.
    #[must_use]
    pub fn report(&self) -> &FieldReport {
        &self.report
    }

    /// Value of a node, in the length unit.
    ///
    /// # Panics
    ///
    /// When there is no such node.
    #[must_use]
    pub fn node(&self, node: [usize; 3]) -> f64 {
        self.store.node(node)
    }

    /// Values of all nodes, x running fastest, as [`Self::from_values`] takes them.
    #[must_use]
    pub fn values(&self) -> Vec<f32> {
        if let Store::Floats(nodes) = &self.store {
            return nodes.values.clone();
        }
        let [nx, ny, nz] = self.grid.dims();
        let nodes =
            (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
        nodes.map(|node| crate::num::single(self.node(node))).collect()
    }

    /// What the values are right for.
    #[must_use]
    pub fn node_values(&self) -> NodeValues {
        self.nodes
    }

    /// What the values are kept as.
    #[must_use]
    pub fn storage(&self) -> Storage {
        self.store.storage()
    }

    /// Bytes that the values take.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.store.bytes()
    }

    /// Most that storing the values changed one of them, in the length unit.
    #[must_use]
    pub fn storage_rounding(&self) -> f64 {
        self.store.rounding()
    }
}
