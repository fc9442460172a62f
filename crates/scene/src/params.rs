//! Parameters of static detection.

use crate::SceneError;

/// Parameters of static detection.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CheckParams {
    /// Largest distance from the other body at which vertices outside are still
    /// reported, in the scene's length unit, `>= 0`.
    pub margin: f64,
    /// True to measure overlaps and near areas: [`PairReport::overlap`](crate::PairReport::overlap),
    /// [`PairReport::near_areas`](crate::PairReport::near_areas).
    pub measures: bool,
    /// Width of the brackets on depths, `> 0`, in the scene's length unit. `None` for 1 % of the
    /// depth, and 1e-5 of the smaller body's size where that is wider.
    pub depth_tolerance: Option<f64>,
}

impl CheckParams {
    /// Returns parameters that measure every overlap, its depth within 1 %.
    #[must_use]
    pub const fn new(margin: f64) -> Self {
        Self { margin, measures: true, depth_tolerance: None }
    }

    /// Returns parameters that report vertices and crossing faces alone, for callers that need no
    /// volume, area or depth of surfaces. It takes some half of the time.
    #[must_use]
    pub const fn without_measures(margin: f64) -> Self {
        Self { margin, measures: false, depth_tolerance: None }
    }

    /// Checks that the parameters are in their ranges.
    ///
    /// # Errors
    ///
    /// - [`SceneError::Margin`] when the margin is negative or not finite.
    /// - [`SceneError::DepthTolerance`] when the tolerance is not finite or not above 0.
    pub fn validate(&self) -> Result<(), SceneError> {
        let Self { margin, depth_tolerance, .. } = *self;
        if !(margin.is_finite() && margin >= 0.0) {
            return Err(SceneError::Margin { margin });
        }
        match depth_tolerance {
            Some(tolerance) if !(tolerance.is_finite() && tolerance > 0.0) => {
                Err(SceneError::DepthTolerance { tolerance })
            }
            _ => Ok(()),
        }
    }
}
