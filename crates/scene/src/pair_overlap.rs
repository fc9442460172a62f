//! Measures of the overlap of a pair: volume, areas, curve, and certified depths.

use overlap::{Depth, DepthParams, Overlap, OverlapDetector};
use proximity::{NearVertex, NoInside, SurfaceTree};
use surface::progress::{Interrupted, Progress};

use crate::coincidence::size;
use crate::depth_bracket::DepthBracket;
use crate::edge_overlap::EdgeOverlap;
use crate::{CheckParams, PairId, Scene, SceneError};

/// Overlap of two bodies.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PairOverlap {
    /// Volume, areas and curve, of the whole and of each separate contact region.
    pub measures: Overlap,
    /// Greatest depth of the first body's surface in the second body; `None` where nothing of it is
    /// inside, or where "inside" is undefined.
    pub depth_of_a_in_b: Option<Depth>,
    /// Greatest depth of the second body's surface in the first body.
    pub depth_of_b_in_a: Option<Depth>,
    /// Deepest points of the regions in which no vertex is inside, in the order of the regions.
    pub edge_overlaps: Vec<EdgeOverlap>,
}

/// Depths that are to be bracketed.
pub(crate) struct DepthRequest<'a> {
    /// Width of the brackets; `None` for the default one.
    pub(crate) tolerance: Option<f64>,
    /// Closest points of vertices that are known, of each body on the other, ascending.
    pub(crate) known: [&'a [NearVertex]; 2],
    /// Trees of the pair that were measured, with faces that look outward.
    pub(crate) outward: [&'a SurfaceTree; 2],
}

impl Scene {
    /// Measures the overlap of each of some pairs in their present state, as [`check`](Self::check)
    /// does; `None` for a pair that shares nothing.
    ///
    /// ```
    /// use scene::glam::DVec3;
    /// use scene::{BodyKind, PairId, Progress, Scene};
    ///
    /// let cube = fixtures::shapes::cube(1.0);
    /// let other = cube.clone().translated(0.75 * DVec3::X);
    /// let mut scene = Scene::new();
    /// let a = scene.add("a", BodyKind::Rigid, cube.surface(), cube.positions)?;
    /// let b = scene.add("b", BodyKind::Rigid, other.surface(), other.positions)?;
    ///
    /// let overlaps = scene.pair_overlaps(&[PairId::new(a, b)], Some(1e-3), Progress::none())?;
    /// let depth = overlaps[0].as_ref().and_then(|overlap| overlap.max_depth()).ok_or("they overlap")?;
    /// assert!(depth.lower <= 0.25 && 0.25 <= depth.upper && depth.upper - depth.lower <= 1e-3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`SceneError::DepthTolerance`] when the tolerance is out of range.
    /// - [`SceneError::NoSuchBody`] when a body is of another scene.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    /// - [`SceneError::Interrupted`] when `progress` ends the call.
    pub fn pair_overlaps(
        &mut self,
        pairs: &[PairId],
        depth_tolerance: Option<f64>,
        progress: Progress<'_>,
    ) -> Result<Vec<Option<PairOverlap>>, SceneError> {
        CheckParams { depth_tolerance, ..CheckParams::new(0.0) }.validate()?;
        for id in pairs.iter().copied().flat_map(PairId::bodies) {
            self.get_mut(id)?.fit()?;
        }
        self.map_pairs(pairs, OverlapDetector::default, progress, |detector, pair, progress| {
            let trees = (self.trees(pair), self.outward_trees(pair));
            let (Some(bodies), Some(outward)) = trees else { return Ok(None) };
            let mut measures = Overlap::default();
            detector.try_measure_into(outward, &mut measures, progress)?;
            if measures.regions.is_empty() {
                return Ok(Some(None));
            }
            let depths = DepthRequest { tolerance: depth_tolerance, known: [&[]; 2], outward };
            let overlap =
                PairOverlap::new(pair, bodies, measures, Some(depths), detector, progress)?;
            Ok(Some(Some(overlap)))
        })
    }
}

impl PairOverlap {
    /// Adds the depths to the measures of a pair, which the detector has measured last.
    ///
    /// `depths` is `None` for no depths at all.
    pub(crate) fn new(
        pair: PairId,
        bodies: [&SurfaceTree; 2],
        measures: Overlap,
        depths: Option<DepthRequest<'_>>,
        detector: &mut OverlapDetector,
        progress: Progress<'_>,
    ) -> Result<Self, Interrupted> {
        let mut overlap = Self {
            measures,
            depth_of_a_in_b: None,
            depth_of_b_in_a: None,
            edge_overlaps: Vec::new(),
        };
        let Some(DepthRequest { tolerance, known, outward }) = depths else { return Ok(overlap) };
        let params = depth_params(bodies, tolerance);
        [overlap.depth_of_a_in_b, overlap.depth_of_b_in_a] =
            detector.depths_from(outward, known, &params, progress)?;

        // Regions without an inside vertex are named by their deepest point.
        for (region, measures) in (0..).zip(&overlap.measures.regions) {
            if measures.inside_vertices == [0, 0] {
                let depths = if overlap.measures.regions.len() == 1 {
                    [overlap.depth_of_a_in_b, overlap.depth_of_b_in_a]
                } else {
                    detector.depths_in_region(region, outward, &params, progress)?
                };
                overlap.edge_overlaps.extend(EdgeOverlap::new(region, pair, bodies, depths));
            }
        }
        Ok(overlap)
    }

    /// Brackets the larger of both depths; `None` where nothing is inside, and where the depth in one
    /// of the bodies is undefined: it may be the larger one. A surface with open edges has nothing
    /// inside, so that the depth in the other body is the larger one.
    #[must_use]
    pub fn max_depth(&self) -> Option<DepthBracket> {
        if self.has_undefined_depth(0) || self.has_undefined_depth(1) {
            return None;
        }
        let mut max: Option<DepthBracket> = None;
        for depth in [self.depth_of_a_in_b, self.depth_of_b_in_a].into_iter().flatten() {
            let bracket = max.get_or_insert_default();
            bracket.lower = bracket.lower.max(depth.lower);
            bracket.upper = bracket.upper.max(depth.upper);
        }
        max
    }

    /// Returns true if the depth in one body is undefined although places are inside it.
    fn has_undefined_depth(&self, side: usize) -> bool {
        let Overlap { covers_twice, no_inside, .. } = &self.measures;
        covers_twice[side] || matches!(no_inside[side], Some(NoInside::Misoriented { .. }))
    }
}

/// Returns parameters for brackets of a width, or of the default one.
fn depth_params(bodies: [&SurfaceTree; 2], tolerance: Option<f64>) -> DepthParams {
    /// Width of a bracket that is narrow enough, relative to the smaller body's size: some
    /// micrometers for a muscle. Smaller takes long where surfaces coincide up to noise.
    const FLOOR: f64 = 1e-5;
    /// Closest points and divisions per depth, some seconds: reached where large surfaces are equally deep.
    const MAX_QUERIES: u32 = 2_000_000;

    let [size_a, size_b] = bodies.map(size);
    match tolerance {
        Some(tolerance) => {
            DepthParams { relative_tolerance: 0.0, tolerance, max_queries: MAX_QUERIES }
        }
        None => DepthParams {
            relative_tolerance: 0.01,
            tolerance: FLOOR * size_a.min(size_b),
            max_queries: MAX_QUERIES,
        },
    }
}
