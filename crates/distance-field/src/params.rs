//! Parameters of a build and of its storage.

use crate::FieldError;
use crate::error::{check_not_negative, check_positive};

/// Parameters of [`DistanceField::build`](crate::DistanceField::build); lengths in the
/// caller's unit.
///
/// A spacing has no default: [`FieldParams::new`] takes it, and chooses the other lengths
/// in proportion.
///
/// ```
/// use distance_field::FieldParams;
///
/// let params = FieldParams { truncation: None, ..FieldParams::new(1.0) };
/// assert_eq!(params.padding, 10.0);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FieldParams {
    /// Distance between neighboring nodes, `> 0`. Half the spacing takes 8 times the
    /// memory; the band is then half as wide, and two fifths of the error in it remain.
    pub spacing: f64,
    /// Distance from the surface's bounding box to the border of the grid, `>= 0`. Points
    /// outside the grid have no value.
    pub padding: f64,
    /// Algorithm that computes the distances.
    pub method: FieldMethod,
    /// Largest distance that is stored: longer ones are cut to it. `None` keeps all
    /// distances, for which a build takes half as long again.
    pub truncation: Option<f64>,
    /// Number format of the stored values.
    pub storage: Storage,
    /// Bytes that a build may hold at once, checked before it allocates.
    pub max_bytes: u64,
    /// Number of sample points at which the field is compared with exact distances; 0
    /// measures nothing.
    pub samples: usize,
}

/// Algorithm that computes the distances of a field.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum FieldMethod {
    /// Voxelization, distance transform and flood fill, the method of the source.
    ///
    /// Simple, but distances err by half a spacing and directions by 20°, whatever the
    /// spacing. The flood fill needs a closed surface; cavities that it does not reach are told
    /// from the inside by winding number.
    Voxel {
        /// Set of voxels that a face switches on.
        voxelization: Voxelization,
    },
    /// Exact distances in a band around the surface; beyond it, exact distances to the
    /// face that is closest to the nearest node of the band. Signed by winding number.
    ExactBand {
        /// Half width in spacings, `>= 1.75`, so that all corners of a cell that the
        /// surface crosses are exact. A distance just outside the band can err by most of a
        /// spacing, near a medial plane or, under 3, near a sharp rim.
        band: f64,
        /// Meaning of the values at the nodes of the band.
        node_values: NodeValues,
    },
}

/// Rule by which a face switches voxels on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Voxelization {
    /// Bresenham lines along the edges, and one voxel per column inside: thin, but where
    /// faces span several voxels a 6-connected flood leaks through.
    Bresenham,
    /// The thinnest voxelization that no 6-connected path crosses.
    SixSeparating,
    /// Every voxel that the face touches.
    Conservative,
}

/// Meaning of the values at nodes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum NodeValues {
    /// Distances at the nodes. Between them, linear interpolation of a convex function is
    /// too high on average.
    #[default]
    Interpolating,
    /// Coefficients of a quasi-interpolation: each node is corrected by a twelfth of its
    /// second differences, so that linear interpolation is right on average.
    ///
    /// A correction is at most an eighth of a spacing, and never changes the sign. Over
    /// smooth bones three fifths of the error remain, over others two thirds. Cubic
    /// interpolation takes the correction back, and is as accurate as between distances.
    QuasiInterpolating,
}

/// Number format of the stored values.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Storage {
    /// 32-bit floats, 4 bytes per node.
    Float,
    /// 16-bit multiples of `step`, 2 bytes per node, each rounded by at most half a step.
    Quantized {
        /// Length of one step, `> 0`; the largest value stored is 32767 steps.
        step: f64,
    },
}

/// Minimum band whose nodes surround every cell that the surface crosses: the diagonal of
/// a cell, √3, and a little.
const MIN_BAND: f64 = 1.75;

impl FieldMethod {
    /// The pipeline of the source: Bresenham lines.
    pub const VOXEL: Self = Self::Voxel { voxelization: Voxelization::Bresenham };
    /// Exact band of three spacings, with nodes of a quasi-interpolation.
    pub const EXACT_BAND: Self =
        Self::ExactBand { band: 3.0, node_values: NodeValues::QuasiInterpolating };

    /// Returns the meaning of the values at nodes.
    pub(crate) fn node_values(self) -> NodeValues {
        match self {
            Self::Voxel { .. } => NodeValues::Interpolating,
            Self::ExactBand { node_values, .. } => node_values,
        }
    }
}

impl FieldParams {
    /// Returns the default parameters at a spacing: exact band, 10 spacings of padding,
    /// truncation at 15 spacings, floats, up to 4 GiB, 512 samples.
    #[must_use]
    pub fn new(spacing: f64) -> Self {
        Self {
            spacing,
            padding: 10.0 * spacing,
            method: FieldMethod::EXACT_BAND,
            truncation: Some(15.0 * spacing),
            storage: Storage::Float,
            max_bytes: 4 << 30,
            samples: 512,
        }
    }

    /// Returns the parameters of the source: voxel method, nothing truncated.
    #[must_use]
    pub fn voxel(spacing: f64) -> Self {
        Self { method: FieldMethod::VOXEL, truncation: None, ..Self::new(spacing) }
    }

    /// Checks every length that the parameters hold.
    ///
    /// # Errors
    ///
    /// [`FieldError::InvalidParam`] with the first that is out of range.
    pub fn validate(&self) -> Result<(), FieldError> {
        check_positive("spacing", self.spacing)?;
        check_not_negative("padding", self.padding)?;
        if let Some(truncation) = self.truncation {
            check_positive("truncation", truncation)?;
        }
        if let Storage::Quantized { step } = self.storage {
            check_positive("storage step", step)?;
        }

        match self.method {
            FieldMethod::ExactBand { band, .. } if !(band.is_finite() && band >= MIN_BAND) => {
                let expected = "finite and >= 1.75 spacings";
                Err(FieldError::InvalidParam { name: "band", value: band, expected })
            }
            _ => Ok(()),
        }
    }
}
