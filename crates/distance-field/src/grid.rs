//! A regular grid of nodes around a surface, and where points fall in it.

use glam::DVec3;
use surface::Pose;

use crate::FieldError;
use crate::frame::{Frame, Located};
use crate::num::{coordinate, floor_index, whole_index};

/// Most nodes along an axis: three squares of it fit 32 bits.
const LONGEST_AXIS: usize = 37_000;

/// Nodes at `origin + spacing · (i, j, k)`, `i` running fastest in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FieldGrid {
    origin: DVec3,
    spacing: f64,
    dims: [usize; 3],
}

/// The cell that holds a point: its lowest node, and the point's place in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridCell {
    /// Lowest node, each number at most the count of nodes minus 2.
    pub node: [usize; 3],
    /// Place along each axis, `0.0..=1.0`.
    pub place: DVec3,
}

impl FieldGrid {
    /// A grid of `dims` nodes, at least two along each axis.
    ///
    /// # Errors
    ///
    /// - [`FieldError::InvalidParam`] when `spacing` is not positive and finite, the
    ///   origin is not finite or an axis has fewer than two nodes.
    /// - [`FieldError::TooLarge`] when the nodes cannot be numbered.
    pub fn new(origin: DVec3, spacing: f64, dims: [usize; 3]) -> Result<Self, FieldError> {
        check_positive("spacing", spacing)?;
        if !origin.is_finite() {
            let value = origin.x + origin.y + origin.z;
            return Err(FieldError::InvalidParam { name: "origin", value, expected: "finite" });
        }
        if let Some(&few) = dims.iter().find(|&&n| n < 2) {
            let value = coordinate(few);
            return Err(FieldError::InvalidParam {
                name: "nodes an axis",
                value,
                expected: "2 or more",
            });
        }
        if dims.iter().try_fold(1_usize, |product, &n| product.checked_mul(n)).is_none() {
            let nodes = dims.iter().map(|&n| coordinate(n)).product();
            return Err(FieldError::TooLarge { nodes, bytes: nodes, max_bytes: u64::MAX });
        }
        Ok(Self { origin, spacing, dims })
    }

    /// The grid over the box of `x` and `padding` on each side.
    ///
    /// `bytes_per_node` is what a build holds at once; the grid is refused
    /// before anything is allocated when all nodes together exceed `max_bytes`.
    pub(crate) fn around(
        x: &[DVec3],
        [spacing, padding]: [f64; 2],
        bytes_per_node: f64,
        max_bytes: u64,
    ) -> Result<Self, FieldError> {
        check_positive("spacing", spacing)?;
        if !(padding.is_finite() && padding >= 0.0) {
            let expected = "finite and not negative";
            return Err(FieldError::InvalidParam { name: "padding", value: padding, expected });
        }
        let (lo, hi) = bounds(x);
        let origin = lo - padding;
        let cells = ((hi - lo + 2.0 * padding) / spacing).ceil().max(DVec3::ONE);
        let nodes = (cells.x + 1.0) * (cells.y + 1.0) * (cells.z + 1.0);
        let bytes = nodes * bytes_per_node;
        if bytes.is_nan() || bytes > as_bytes(max_bytes) {
            return Err(FieldError::TooLarge { nodes, bytes, max_bytes });
        }
        let longest = cells.max_element() + 1.0;
        if longest > coordinate(LONGEST_AXIS) {
            return Err(FieldError::AxisTooLong { nodes: longest, limit: LONGEST_AXIS });
        }
        Self::new(origin, spacing, cells.to_array().map(|n| floor_index(n) + 1))
    }

    /// Position of node (0, 0, 0).
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Distance between neighbouring nodes, in the length unit.
    #[must_use]
    pub fn spacing(&self) -> f64 {
        self.spacing
    }

    /// Nodes along each axis.
    #[must_use]
    pub fn dims(&self) -> [usize; 3] {
        self.dims
    }

    /// All nodes.
    #[must_use]
    pub fn node_count(&self) -> usize {
        self.dims.iter().product()
    }

    /// Position of a node.
    #[must_use]
    pub fn position(&self, node: [usize; 3]) -> DVec3 {
        self.origin + self.spacing * DVec3::from_array(node.map(coordinate))
    }

    /// Number of a node in memory.
    #[must_use]
    pub fn index(&self, [i, j, k]: [usize; 3]) -> usize {
        i + self.dims[0] * (j + self.dims[1] * k)
    }

    /// The cell that holds `p`; none outside, or when `p` is not a number.
    /// The last node of an axis belongs to the last cell.
    #[must_use]
    pub fn locate(&self, p: DVec3) -> Option<GridCell> {
        let Located { cell, place } = Frame::new(self, &Pose::IDENTITY).locate(p)?;
        Some(GridCell { node: cell.to_array().map(whole_index), place })
    }

    /// `p` in units of the spacing, from the origin.
    pub(crate) fn to_units(self, p: DVec3) -> DVec3 {
        (p - self.origin) / self.spacing
    }
}

pub(crate) fn bounds(x: &[DVec3]) -> (DVec3, DVec3) {
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    x.iter().fold(empty, |(lo, hi), &p| (lo.min(p), hi.max(p)))
}

pub(crate) fn check_positive(name: &'static str, value: f64) -> Result<(), FieldError> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(FieldError::InvalidParam { name, value, expected: "finite and positive" })
}

#[expect(clippy::cast_precision_loss, reason = "a budget is not exact to the byte")]
fn as_bytes(max_bytes: u64) -> f64 {
    max_bytes as f64
}
