//! Static detection over a whole scene: every pair within a margin.

use proximity::{PairProximity, Region, regions};
use surface::progress::Progress;

use crate::scene::map_pairs;
use crate::{BodyId, PairId, PairReport, Scene, SceneError};

/// Parameters of static detection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckParams {
    /// Largest distance from the other body at which vertices outside are still
    /// reported, in the scene's length unit, `>= 0`.
    pub margin: f64,
}

impl CheckParams {
    /// Checks that the parameters are in their ranges.
    ///
    /// # Errors
    ///
    /// [`SceneError::Margin`] when the margin is negative or not finite.
    pub fn validate(&self) -> Result<(), SceneError> {
        let Self { margin } = *self;
        let is_valid = margin.is_finite() && margin >= 0.0;
        if is_valid { Ok(()) } else { Err(SceneError::Margin { margin }) }
    }
}

impl Scene {
    /// Examines every pair of bodies in their present state, and reports those that overlap or
    /// have points within the margin of each other, in the order of the bodies.
    ///
    /// Exact: whether and where faces cross, and which vertices are inside. Within rounding of a
    /// distance: depths and gaps.
    ///
    /// # Errors
    ///
    /// - [`SceneError::Margin`] when the margin is negative or not finite.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    /// - [`SceneError::Interrupted`] when `progress` ends the call.
    pub fn check(
        &mut self,
        params: &CheckParams,
        progress: Progress<'_>,
    ) -> Result<Vec<PairReport>, SceneError> {
        params.validate()?;
        let pairs = self.close_pairs(params.margin)?;
        let reports = map_pairs(&pairs, PairProximity::default, progress, |found, pair| {
            self.examine(pair, params.margin, found)
        });
        Ok(reports?)
    }

    /// Examines one pair; `None` where nothing is within the margin. Trees must be fitted.
    fn examine(&self, pair: PairId, margin: f64, found: &mut PairProximity) -> Option<PairReport> {
        let (a, b) = (self.body(pair.a).tree()?, self.body(pair.b).tree()?);
        found.compute(a, b, margin);
        let distance = found.distance(a, b, margin);
        if distance.is_none() && !found.has_contact() {
            return None;
        }
        let patches = found.patches(a);
        Some(PairReport { distance, patches, ..PairReport::new(pair, found) })
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
