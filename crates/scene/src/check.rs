//! Static detection over a whole scene: every pair within a margin.

use overlap::{NearAreas, Overlap, OverlapDetector};
use proximity::{PairProximity, PairSide, Region, SurfaceTree, regions};
use surface::Aabb;
use surface::progress::Progress;

use crate::coincidence::Coincidence;
use crate::pair_overlap::{DepthRequest, PairOverlap};
use crate::{BodyId, CheckParams, PairId, PairReport, Scene, SceneError};

/// Detectors of one thread, with their memory.
#[derive(Debug, Default)]
struct PairDetectors {
    proximity: PairProximity,
    overlap: OverlapDetector,
    near_areas: NearAreas,
}

impl Scene {
    /// Examines every pair of bodies in their present state, and reports those that overlap or
    /// have points within the margin of each other, in the order of the bodies.
    ///
    /// Exact: whether and where faces cross, and which vertices are inside. Within rounding of a
    /// distance: depths of vertices, gaps and measures. Certified brackets: depths of surfaces.
    ///
    /// # Errors
    ///
    /// - [`SceneError::Margin`] and [`SceneError::DepthTolerance`] for parameters out of range.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    /// - [`SceneError::NearFaces`] when more than 2²⁶ pairs of faces of two bodies are within the margin
    ///   of each other.
    /// - [`SceneError::Interrupted`] when `progress` ends the call.
    pub fn check(
        &mut self,
        params: &CheckParams,
        progress: Progress<'_>,
    ) -> Result<Vec<PairReport>, SceneError> {
        params.validate()?;
        let pairs = self.close_pairs_with(params.margin, progress)?;
        self.map_pairs(&pairs, PairDetectors::default, progress, |detectors, pair, progress| {
            self.examine(pair, params, detectors, progress)
        })
    }

    /// Examines one pair; `None` where nothing is within the margin. Trees must be fitted.
    fn examine(
        &self,
        pair: PairId,
        params: &CheckParams,
        detectors: &mut PairDetectors,
        progress: Progress<'_>,
    ) -> Result<Option<PairReport>, SceneError> {
        let Some(bodies) = self.trees(pair) else { return Ok(None) };
        let [a, b] = bodies;
        let PairDetectors { proximity: found, overlap: detector, near_areas } = detectors;
        // Vertices and crossing faces of the pair, exactly.
        let computed = found.try_compute(a, b, params.margin, progress);
        computed.map_err(|error| SceneError::of_pair(self.names(pair), error))?;
        let distance = found.try_distance(a, b, params.margin, progress)?;
        let is_near = distance.is_some() || found.has_contact();
        let may_enclose = self.may_enclose(pair);
        if !is_near && !may_enclose {
            return Ok(None);
        }

        // Meshes that are one are named before anything is measured.
        let mut report = PairReport { distance, ..PairReport::new(pair, found) };
        report.coincidence = Coincidence::of_meshes(bodies);

        // Bodies that touch without crossing share a volume where they coincide, and a body is inside
        // a doubled one although the parity of crossings is even: only the measures decide it.
        let outward = self.outward_trees(pair).unwrap_or(bodies);
        let meets = report.overlaps || !found.meeting_faces().is_empty() || may_enclose;
        if meets && (params.measures || !report.overlaps) {
            let mut measures = Overlap::default();
            let meeting = found.meeting_faces();
            detector.measure_candidates(outward, meeting, &mut measures, progress)?;
            let volume = measures.total.volume;
            report.overlaps |= volume.is_some_and(|volume| volume > detector.volume_rounding());
            report.coincidence = report.coincidence.or(Coincidence::of_overlap(&measures, bodies));
            if params.measures && !measures.regions.is_empty() {
                // Surfaces that only touch have no depth but rounding.
                let known = found.sides().map(PairSide::near);
                let tolerance = params.depth_tolerance;
                let depths = DepthRequest { tolerance, known, outward };
                let depths = report.overlaps.then_some(depths);
                let overlap = PairOverlap::new(pair, bodies, measures, depths, detector, progress)?;
                report.overlap = Some(overlap);
            }
        }
        if params.measures && !report.overlaps {
            let near_faces = found.sides().map(PairSide::near_faces);
            let areas = near_areas.measure(bodies, params.margin, near_faces, progress)?;
            report.near_areas = Some(areas);
        }
        Ok((is_near || report.overlaps).then_some(report))
    }

    /// Returns true if the box of one body holds that of the other.
    fn may_enclose(&self, pair: PairId) -> bool {
        let bounds = (self.body(pair.a).known_bounds(), self.body(pair.b).known_bounds());
        let (Some(a), Some(b)) = bounds else { return false };
        holds(a, b) || holds(b, a)
    }

    /// Returns the trees of a pair that are fitted.
    pub(crate) fn trees(&self, pair: PairId) -> Option<[&SurfaceTree; 2]> {
        Some([self.body(pair.a).tree()?, self.body(pair.b).tree()?])
    }

    /// Returns the trees of a pair that are fitted, with faces that look outward. Their corners may be in another
    /// order than those of the bodies.
    pub(crate) fn outward_trees(&self, pair: PairId) -> Option<[&SurfaceTree; 2]> {
        Some([self.body(pair.a).outward().fitted()?, self.body(pair.b).outward().fitted()?])
    }

    /// Cuts `body` by `by` in their present state: finds the regions of `body` that do not meet
    /// `by`, largest first. See [`regions`].
    ///
    /// # Errors
    ///
    /// - [`SceneError::NoSuchBody`] when a body is of another scene.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    pub fn segment(&mut self, body: BodyId, by: BodyId) -> Result<Vec<Region>, SceneError> {
        self.get_mut(body)?.fit()?;
        self.get_mut(by)?.fit()?;
        let trees = self.body(body).tree().zip(self.body(by).tree());
        Ok(trees.map_or(Vec::new(), |(body, by)| regions(body, by)))
    }
}

/// Returns true if a box holds another.
fn holds(outer: Aabb, inner: Aabb) -> bool {
    outer.min.cmple(inner.min).all() && outer.max.cmpge(inner.max).all()
}
