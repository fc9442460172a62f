//! Overlaps over a whole scene: what each pair of bodies shares, and how deep.

use overlap::{Depth, DepthParams, Overlap, OverlapDetector};
use surface::Aabb;
use surface::progress::Progress;

use crate::scene::map_pairs;
use crate::{PairId, Scene, SceneError};

/// Parameters of the measurement of overlaps.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OverlapParams {
    /// Width of the brackets on depths, `> 0`, in the scene's length unit. `None` for 1 % of the
    /// depth, and 1e-5 of the smaller body's size where that is wider.
    pub depth_tolerance: Option<f64>,
}

/// Overlap of two bodies.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PairOverlap {
    /// The pair.
    pub pair: PairId,
    /// Volume, areas and curve, of the whole and of each separate contact region.
    pub overlap: Overlap,
    /// Greatest depth of the first body's surface in the second body; `None` where nothing of it is
    /// inside, or where "inside" is undefined.
    pub depth_of_a_in_b: Option<Depth>,
    /// Greatest depth of the second body's surface in the first body.
    pub depth_of_b_in_a: Option<Depth>,
}

impl OverlapParams {
    /// Checks that the parameters are in their ranges.
    ///
    /// # Errors
    ///
    /// [`SceneError::DepthTolerance`] when the tolerance is not finite or not above 0.
    pub fn validate(&self) -> Result<(), SceneError> {
        match self.depth_tolerance {
            Some(tolerance) if !(tolerance.is_finite() && tolerance > 0.0) => {
                Err(SceneError::DepthTolerance { tolerance })
            }
            _ => Ok(()),
        }
    }
}

impl PairOverlap {
    /// Returns the larger of both depths, as far as it is certain: 0 where nothing is inside.
    #[must_use]
    pub fn max_depth(&self) -> f64 {
        let depths = [self.depth_of_a_in_b, self.depth_of_b_in_a];
        depths.iter().flatten().fold(0.0, |max: f64, depth| max.max(depth.lower))
    }
}

impl Scene {
    /// Measures every pair of bodies whose surfaces meet or of which one is inside the other, in the
    /// order of the bodies.
    ///
    /// Coincident bodies overlap by their volume; bodies that only touch are reported with the area
    /// in which they do, and without volume.
    ///
    /// ```
    /// use scene::{BodyKind, OverlapParams, Scene};
    /// use surface::progress::Progress;
    ///
    /// // A mesh that was loaded twice by mistake.
    /// let cube = fixtures::shapes::cube(10.0);
    /// let mut scene = Scene::new();
    /// for name in ["femur", "femur_copy"] {
    ///     scene.add(name, BodyKind::Rigid, cube.surface(), cube.positions.clone())?;
    /// }
    /// let pairs = scene.overlaps(&OverlapParams::default(), Progress::none())?;
    /// let total = pairs[0].overlap.total;
    /// assert!((total.volume.ok_or("closed")? - 1000.0).abs() < 1e-9);
    /// assert!((total.flush_area - 600.0).abs() < 1e-9);
    /// assert!(pairs[0].max_depth() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`SceneError::DepthTolerance`] when the tolerance is not finite or not above 0.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    /// - [`SceneError::Interrupted`] when `progress` ends the call.
    pub fn overlaps(
        &mut self,
        params: &OverlapParams,
        progress: Progress<'_>,
    ) -> Result<Vec<PairOverlap>, SceneError> {
        params.validate()?;
        let pairs = self.close_pairs(0.0)?;
        let overlaps = map_pairs(&pairs, OverlapDetector::default, progress, |detector, pair| {
            self.measure(pair, params, detector)
        });
        Ok(overlaps?)
    }

    /// Measures one pair; `None` where the bodies share nothing. Trees must be fitted.
    fn measure(
        &self,
        pair: PairId,
        params: &OverlapParams,
        detector: &mut OverlapDetector,
    ) -> Option<PairOverlap> {
        let bodies = [self.body(pair.a).tree()?, self.body(pair.b).tree()?];
        let overlap = detector.measure(bodies[0], bodies[1]);
        if overlap.regions.is_empty() {
            return None;
        }
        let [depth_of_a_in_b, depth_of_b_in_a] =
            detector.depths(bodies, &self.depth_params(pair, params));
        Some(PairOverlap { pair, overlap, depth_of_a_in_b, depth_of_b_in_a })
    }

    fn depth_params(&self, pair: PairId, params: &OverlapParams) -> DepthParams {
        /// Width of a bracket that is narrow enough, relative to the smaller body's size: some
        /// micrometers for a muscle. Smaller takes long where surfaces coincide up to noise.
        const FLOOR: f64 = 1e-5;
        /// Closest points per depth, some seconds: reached where whole surfaces are equally deep.
        const MAX_QUERIES: u32 = 2_000_000;

        let size = |id| Aabb::of_points(self.body(id).positions().iter().copied()).diagonal();
        match params.depth_tolerance {
            Some(tolerance) => {
                DepthParams { relative_tolerance: 0.0, tolerance, max_queries: MAX_QUERIES }
            }
            None => DepthParams {
                relative_tolerance: 0.01,
                tolerance: FLOOR * size(pair.a).min(size(pair.b)),
                max_queries: MAX_QUERIES,
            },
        }
    }
}
