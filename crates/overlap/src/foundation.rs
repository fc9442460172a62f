//! Elastic foundation: contact pressure of a layer of cartilage from the depth at one point.

use std::ops::RangeInclusive;

use surface::{MAX_COORDINATE, MIN_SIZE};

use crate::error::JointContactError;

/// Bed of springs that stands for an elastic layer on a rigid ground.
///
/// With Young's modulus E, Poisson's ratio ν, thickness h and depth d the constrained modulus is
///
/// ```text
/// M = (1 − ν) E / ((1 + ν) (1 − 2ν))
/// ```
///
/// and the pressure `M d / h` ([`Linear`](FoundationLaw::Linear)) or `−M ln(1 − d / h)`
/// ([`Logarithmic`](FoundationLaw::Logarithmic)). For two layers pressed on each other, h is the
/// sum of both thicknesses and d the depth of one in the other.
///
/// Sources: Y. Bei and B. J. Fregly, "Multibody dynamic simulation of knee contact mechanics",
/// Medical Engineering & Physics 26, 2004 (linear); L. Blankevoort et al., "Articular contact in a
/// three-dimensional model of the knee", Journal of Biomechanics 24(11), 1991 (logarithmic).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ElasticFoundation {
    /// Young's modulus, from 1e-60 to 1e60, as force per area.
    pub youngs_modulus: f64,
    /// Poisson's ratio, `> −1` and `< 0.5`.
    pub poissons_ratio: f64,
    /// Thickness of the layer, from 1e-90 to 1e30, in the length unit.
    pub thickness: f64,
    /// Dependence of the pressure on the strain.
    pub law: FoundationLaw,
}

/// Dependence of the pressure on the strain d / h.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
#[non_exhaustive]
pub enum FoundationLaw {
    /// Proportional to the strain: for small ones.
    #[default]
    Linear,
    /// Stiffer the more the layer is compressed. Strains above 0.99 count as 0.99, where the
    /// pressure is 4.6 times the modulus: at a strain of 1 it would be infinite.
    Logarithmic,
}

/// Moduli of which loads are numbers. A load is at most 1e16 moduli, as Poisson's ratio nears 1/2, times
/// the strain, which is at most 1e121, times the area of a surface and the distance of its center.
const MODULI: RangeInclusive<f64> = 1e-60..=1e60;

/// Thicknesses of layers: the range of coordinates.
const THICKNESSES: RangeInclusive<f64> = MIN_SIZE..=MAX_COORDINATE;

impl ElasticFoundation {
    /// Checks that the parameters are in their ranges.
    ///
    /// # Errors
    ///
    /// [`JointContactError::Foundation`] when the modulus, the thickness or Poisson's ratio is out of its
    /// range. Beyond, loads would leave the range of numbers.
    pub fn validate(&self) -> Result<(), JointContactError> {
        let Self { youngs_modulus, poissons_ratio, thickness, .. } = *self;
        let is_material = poissons_ratio > -1.0 && poissons_ratio < 0.5;
        let is_load = MODULI.contains(&youngs_modulus) && THICKNESSES.contains(&thickness);
        if is_load && is_material {
            return Ok(());
        }
        Err(JointContactError::Foundation { youngs_modulus, poissons_ratio, thickness })
    }

    /// Computes the pressure at a depth, 0 where the depth is not above 0.
    ///
    /// ```
    /// use overlap::{ElasticFoundation, FoundationLaw};
    ///
    /// // Cartilage of 4 mm on bone, in newtons and millimeters.
    /// let (youngs_modulus, poissons_ratio, thickness) = (5.0, 0.46, 4.0);
    /// let law = FoundationLaw::Linear;
    /// let layer = ElasticFoundation { youngs_modulus, poissons_ratio, thickness, law };
    /// layer.validate()?;
    /// assert!((layer.pressure(0.2) - 0.05 * 23.116).abs() < 1e-3);
    /// # Ok::<(), overlap::JointContactError>(())
    /// ```
    #[must_use]
    pub fn pressure(&self, depth: f64) -> f64 {
        /// Strain up to which the logarithm is taken.
        const MAX_STRAIN: f64 = 0.99;

        let nu = self.poissons_ratio;
        let modulus = (1.0 - nu) * self.youngs_modulus / ((1.0 + nu) * (1.0 - 2.0 * nu));
        let strain = depth.max(0.0) / self.thickness;
        match self.law {
            FoundationLaw::Linear => modulus * strain,
            FoundationLaw::Logarithmic => -modulus * (-strain.min(MAX_STRAIN)).ln_1p(),
        }
    }
}
