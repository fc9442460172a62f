//! Static detection over a whole scene: every pair within a margin.

use overlap::{Overlap, OverlapDetector};
use proximity::{PairProximity, Region, SurfaceTree, regions};
use surface::Aabb;
use surface::progress::Progress;

use crate::coincidence::{Coincidence, shares_volume};
use crate::scene::map_pairs;
use crate::{BodyId, PairId, PairReport, Scene, SceneError};

/// Parameters of static detection.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CheckParams {
    /// Largest distance from the other body at which vertices outside are still
    /// reported, in the scene's length unit, `>= 0`.
    pub margin: f64,
    /// True to measure overlaps and near areas: [`PairReport::overlap`],
    /// [`PairReport::near_areas`].
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

/// Detectors of one thread, with their memory.
#[derive(Debug, Default)]
struct PairDetectors {
    proximity: PairProximity,
    overlap: OverlapDetector,
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
    /// - [`SceneError::Interrupted`] when `progress` ends the call.
    pub fn check(
        &mut self,
        params: &CheckParams,
        progress: Progress<'_>,
    ) -> Result<Vec<PairReport>, SceneError> {
        params.validate()?;
        let pairs = self.close_pairs(params.margin)?;
        let reports = map_pairs(&pairs, PairDetectors::default, progress, |detectors, pair| {
            self.examine(pair, params, detectors)
        });
        Ok(reports?)
    }

    /// Examines one pair; `None` where nothing is within the margin. Trees must be fitted.
    fn examine(
        &self,
        pair: PairId,
        params: &CheckParams,
        detectors: &mut PairDetectors,
    ) -> Option<PairReport> {
        let bodies = self.trees(pair)?;
        let [a, b] = bodies;
        let PairDetectors { proximity: found, overlap: detector } = detectors;
        found.compute(a, b, params.margin);
        let distance = found.distance(a, b, params.margin);
        let is_near = distance.is_some() || found.has_contact();
        let may_enclose = self.may_enclose(pair);
        if !is_near && !may_enclose {
            return None;
        }

        let mut report = PairReport { distance, ..PairReport::new(pair, found) };
        report.coincidence = Coincidence::of_meshes(bodies);

        // Bodies that touch without crossing share a volume where they coincide, and a body is inside
        // a doubled one although the parity of crossings is even: only the measures decide it.
        let meets = report.overlaps || !found.meeting_faces().is_empty() || may_enclose;
        if meets && (params.measures || !report.overlaps) {
            let mut measures = Overlap::default();
            detector.measure_candidates(bodies, found.meeting_faces(), &mut measures);
            report.overlaps |= shares_volume(&measures, bodies);
            report.coincidence = report.coincidence.or(Coincidence::of_overlap(&measures, bodies));
            if params.measures && !measures.regions.is_empty() {
                report.overlap = Some(self.with_depths(&report, measures, params, detector));
            }
        }
        if params.measures && !report.overlaps {
            report.near_areas = Some(detector.near_areas(bodies, params.margin));
        }
        (is_near || report.overlaps).then_some(report)
    }

    /// Returns true if the box of one body holds that of the other.
    fn may_enclose(&self, pair: PairId) -> bool {
        let holds = |p: Aabb, q: Aabb| p.min.cmple(q.min).all() && p.max.cmpge(q.max).all();
        let [a, b] = pair.bodies().map(|id| self.body(id).known_bounds());
        a.zip(b).is_some_and(|(a, b)| holds(a, b) || holds(b, a))
    }

    /// Returns the trees of a pair that are fitted.
    pub(crate) fn trees(&self, pair: PairId) -> Option<[&SurfaceTree; 2]> {
        Some([self.body(pair.a).tree()?, self.body(pair.b).tree()?])
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
