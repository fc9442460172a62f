//! Measures of the overlap of a pair: volume, areas, curve, and certified depths.

use overlap::{Depth, DepthParams, Overlap, OverlapDetector};
use proximity::SurfaceTree;

use crate::coincidence::size;
use crate::edge_overlap::EdgeOverlap;
use crate::{CheckParams, PairReport, Scene};

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

/// Certified bracket on the depth of an overlap.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DepthBracket {
    /// A depth that a point of one surface has.
    pub lower: f64,
    /// A depth that no point of either surface exceeds.
    pub upper: f64,
}

impl PairOverlap {
    /// Brackets the larger of both depths; `None` where nothing is inside, or "inside" is
    /// undefined.
    #[must_use]
    pub fn max_depth(&self) -> Option<DepthBracket> {
        let depths = [self.depth_of_a_in_b, self.depth_of_b_in_a];
        let brackets = depths.into_iter().flatten();
        brackets.map(|Depth { lower, upper, .. }| DepthBracket { lower, upper }).reduce(|p, q| {
            DepthBracket { lower: p.lower.max(q.lower), upper: p.upper.max(q.upper) }
        })
    }
}

impl Scene {
    /// Adds the depths to the measures of a pair, which the detector has measured last.
    pub(crate) fn with_depths(
        &self,
        report: &PairReport,
        measures: Overlap,
        params: &CheckParams,
        detector: &mut OverlapDetector,
    ) -> PairOverlap {
        let (mut depths, mut edge_overlaps) = ([None; 2], Vec::new());

        // Surfaces that only touch have no depth but rounding.
        if report.overlaps
            && let Some(bodies) = self.trees(report.pair)
        {
            let params = depth_params(bodies, params);
            depths = detector.depths(bodies, &params);
            for (region, measures) in (0..).zip(&measures.regions) {
                if measures.inside_vertices == [0, 0] {
                    let depths = detector.depths_in_region(region, bodies, &params);
                    edge_overlaps.extend(EdgeOverlap::new(region, report.pair, bodies, depths));
                }
            }
        }
        let [depth_of_a_in_b, depth_of_b_in_a] = depths;
        PairOverlap { measures, depth_of_a_in_b, depth_of_b_in_a, edge_overlaps }
    }
}

fn depth_params(bodies: [&SurfaceTree; 2], params: &CheckParams) -> DepthParams {
    /// Width of a bracket that is narrow enough, relative to the smaller body's size: some
    /// micrometers for a muscle. Smaller takes long where surfaces coincide up to noise.
    const FLOOR: f64 = 1e-5;
    /// Closest points per depth, some seconds: reached where whole surfaces are equally deep.
    const MAX_QUERIES: u32 = 2_000_000;

    match params.depth_tolerance {
        Some(tolerance) => {
            DepthParams { relative_tolerance: 0.0, tolerance, max_queries: MAX_QUERIES }
        }
        None => DepthParams {
            relative_tolerance: 0.01,
            tolerance: FLOOR * bodies.map(size).into_iter().fold(f64::INFINITY, f64::min),
            max_queries: MAX_QUERIES,
        },
    }
}
