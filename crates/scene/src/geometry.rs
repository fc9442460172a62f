//! Shape of an overlap: the parts of both surfaces inside each other, and the crossing curve.

use glam::DVec3;
use kdop::Workspace;
use overlap::{ClippedFace, CurveChain, Overlap, OverlapDetector};
use proximity::SurfaceTree;
use surface::progress::{Interrupted, Progress};

use crate::{PairId, Scene, SceneError};

/// Shape of the overlap of two bodies.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct OverlapGeometry {
    /// Parts of the faces of A inside B, and of B inside A; empty where "inside" is undefined or a
    /// place is covered more than once.
    pub patches: [Vec<PatchFace>; 2],
    /// The curve in which the surfaces cross: arcs first, then loops.
    pub curve: Vec<CurveChain>,
}

/// Part of a face inside another body, with depths.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PatchFace {
    /// The face, its region and the polygons that border the part.
    pub part: ClippedFace,
    /// Depths at the points of these polygons: distances from the other body's surface.
    pub depths: Vec<Vec<f64>>,
}

impl Scene {
    /// Computes the shape of the overlap of each of some pairs in their present state.
    ///
    /// Regions have the numbers that they have in [`PairOverlap`](crate::PairOverlap).
    ///
    /// ```
    /// use scene::glam::DVec3;
    /// use scene::{BodyKind, PairId, Progress, Scene};
    ///
    /// let cube = fixtures::shapes::cube(1.0);
    /// let other = cube.clone().translated(DVec3::splat(0.75));
    /// let mut scene = Scene::new();
    /// let a = scene.add("a", BodyKind::Rigid, cube.surface(), cube.positions)?;
    /// let b = scene.add("b", BodyKind::Rigid, other.surface(), other.positions)?;
    ///
    /// // One corner in the other: three sides of each, and one loop of six edges.
    /// let shapes = scene.overlap_geometries(&[PairId::new(a, b)], Progress::none())?;
    /// assert_eq!(shapes[0].curve.len(), 1);
    /// assert!(shapes[0].patches.iter().all(|faces| faces.len() >= 3));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// - [`SceneError::NoSuchBody`] when a body is of another scene.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    /// - [`SceneError::Interrupted`] when `progress` ends the call.
    pub fn overlap_geometries(
        &mut self,
        pairs: &[PairId],
        progress: Progress<'_>,
    ) -> Result<Vec<OverlapGeometry>, SceneError> {
        for pair in pairs {
            self.get_mut(pair.a)?.fit()?;
            self.get_mut(pair.b)?.fit()?;
        }
        self.map_pairs(pairs, OverlapDetector::default, progress, |detector, pair, progress| {
            let Some(bodies) = self.outward_trees(pair) else { return Ok(None) };
            Ok(Some(OverlapGeometry::new(bodies, detector, progress)?))
        })
    }
}

impl OverlapGeometry {
    fn new(
        [a, b]: [&SurfaceTree; 2],
        detector: &mut OverlapDetector,
        progress: Progress<'_>,
    ) -> Result<Self, Interrupted> {
        detector.try_measure_into([a, b], &mut Overlap::default(), progress)?;
        let patches_of_a = with_depths(detector.patches(0, a), a, b, progress)?;
        let patches_of_b = with_depths(detector.patches(1, b), b, a, progress)?;
        Ok(Self { patches: [patches_of_a, patches_of_b], curve: detector.curve() })
    }
}

/// Computes the depths at the points of some parts of `own` inside `other`.
fn with_depths(
    parts: Vec<ClippedFace>,
    own: &SurfaceTree,
    other: &SurfaceTree,
    progress: Progress<'_>,
) -> Result<Vec<PatchFace>, Interrupted> {
    /// Parts between two polls for interruption: about a millisecond.
    const POLL_INTERVAL: u32 = 256;

    let mut query = DepthQuery { other, hint: None, workspace: Workspace::default() };
    let mut faces = Vec::with_capacity(parts.len());
    let mut polls = progress.every(POLL_INTERVAL);
    for part in parts {
        polls.step()?;
        // Points of the curve are on both surfaces: only corners of the face are deeper.
        let corners = own.corners(part.face);
        let mut depths = Vec::with_capacity(part.loops.len());
        for points in &part.loops {
            let mut of_loop = Vec::with_capacity(points.len());
            for &point in points {
                of_loop.push(if corners.contains(&point) { query.depth(point) } else { 0.0 });
            }
            depths.push(of_loop);
        }
        faces.push(PatchFace { part, depths });
    }
    Ok(faces)
}

/// Queries of depth, each of which starts at the nearest face of the one before.
struct DepthQuery<'a> {
    other: &'a SurfaceTree,
    hint: Option<u32>,
    workspace: Workspace,
}

impl DepthQuery<'_> {
    fn depth(&mut self, point: DVec3) -> f64 {
        let (other, hint) = (self.other, self.hint);
        let found = other.closest_point(point, f64::INFINITY, hint, &mut self.workspace);
        let Some(found) = found else { return 0.0 };
        self.hint = Some(found.face);
        found.distance
    }
}
