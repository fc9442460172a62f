//! Regular grid of nodes.

use std::ops::RangeInclusive;

use glam::DVec3;
use surface::Aabb;

use crate::FieldError;
use crate::error::{check_not_negative, check_positive};
use crate::num::{coordinate, floor_index};

/// Maximum number of nodes along an axis: three squares of it fit 32 bits.
const MAX_AXIS_NODES: usize = 37_000;

/// Spacings, in any length unit, of whose multiples and fractions single precision has all digits.
const SPACINGS: RangeInclusive<f64> = 1e-30..=1e30;

/// Regular grid of nodes at `origin + spacing · (i, j, k)`, `i` running fastest in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FieldGrid {
    origin: DVec3,
    spacing: f64,
    dims: [usize; 3],
}

impl FieldGrid {
    /// Returns a grid of `dims` nodes, at least two along each axis.
    ///
    /// # Errors
    ///
    /// - [`FieldError::InvalidParam`] when `spacing` is not between 1e-30 and 1e30, the origin
    ///   is not finite or an axis has fewer than two nodes.
    /// - [`FieldError::TooLarge`] when the number of nodes overflows.
    pub fn new(origin: DVec3, spacing: f64, dims: [usize; 3]) -> Result<Self, FieldError> {
        if !SPACINGS.contains(&spacing) {
            let expected = "between 1e-30 and 1e30";
            return Err(FieldError::InvalidParam { name: "spacing", value: spacing, expected });
        }
        if !origin.is_finite() {
            let value = origin.x + origin.y + origin.z;
            return Err(FieldError::InvalidParam { name: "origin", value, expected: "finite" });
        }
        for n in dims {
            if n < 2 {
                let (name, value) = ("nodes per axis", coordinate(n));
                return Err(FieldError::InvalidParam { name, value, expected: "2 or more" });
            }
        }
        let [nx, ny, nz] = dims;
        if nx.checked_mul(ny).is_none_or(|plane| plane.checked_mul(nz).is_none()) {
            let nodes = dims.into_iter().map(coordinate).product();
            return Err(FieldError::TooLarge { nodes, bytes: nodes, max_bytes: u64::MAX });
        }
        Ok(Self { origin, spacing, dims })
    }

    /// Returns the grid over a box and `padding` on each side.
    ///
    /// A build holds `bytes_per_node` at once: the grid is refused, before anything is
    /// allocated, where all nodes together exceed `max_bytes`.
    pub(crate) fn around(
        bounds: Aabb,
        spacing: f64,
        padding: f64,
        bytes_per_node: f64,
        max_bytes: u64,
    ) -> Result<Self, FieldError> {
        check_positive("spacing", spacing)?;
        check_not_negative("padding", padding)?;

        // Counted in floats, which do not overflow.
        let origin = bounds.min - padding;
        let cells = ((bounds.max - bounds.min + 2.0 * padding) / spacing).ceil().max(DVec3::ONE);
        let nodes = (cells.x + 1.0) * (cells.y + 1.0) * (cells.z + 1.0);
        let bytes = nodes * bytes_per_node;
        if bytes.is_nan() || bytes > as_bytes(max_bytes) {
            return Err(FieldError::TooLarge { nodes, bytes, max_bytes });
        }

        // Squared distances along an axis must fit 32 bits.
        let longest = cells.max_element() + 1.0;
        if longest > coordinate(MAX_AXIS_NODES) {
            return Err(FieldError::AxisTooLong { nodes: longest, max_nodes: MAX_AXIS_NODES });
        }
        Self::new(origin, spacing, cells.to_array().map(|n| floor_index(n) + 1))
    }

    /// Returns the position of node (0, 0, 0).
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Returns the distance between neighboring nodes, in the length unit.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Returns the number of nodes along each axis.
    #[must_use]
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// Returns the number of nodes.
    #[must_use]
    pub fn node_count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Returns the position of a node.
    #[must_use]
    pub fn position(&self, node: [usize; 3]) -> DVec3 {
        self.origin + self.spacing * DVec3::from_array(node.map(coordinate))
    }

    /// Returns the index of a node in memory.
    #[must_use]
    pub fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.dims[0] * (j + self.dims[1] * k)
    }

    /// Converts a point to spacings from the origin.
    pub(crate) fn to_spacings(self, p: DVec3) -> DVec3 {
        (p - self.origin) / self.spacing
    }
}

#[expect(clippy::cast_precision_loss, reason = "a budget is not exact to the byte")]
fn as_bytes(max_bytes: u64) -> f64 {
    max_bytes as f64
}
