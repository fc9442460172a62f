//! Static detection over a whole scene: every pair that comes within the margin.

use crate::pair::{self, PairReport, Scratch};
use crate::{Scene, SceneError, parallel};

/// What to look for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckParams {
    /// How far outside contact vertices are still reported, in the scene's
    /// length unit, `>= 0`.
    pub margin: f64,
}

impl Scene {
    /// Looks at every pair of bodies in their present state, and reports those
    /// that overlap or have points within `margin` of each other, in the order
    /// of the bodies.
    ///
    /// Exact: whether and where faces cross, and which vertices are inside.
    /// Within rounding of a distance: depths and gaps.
    ///
    /// # Errors
    ///
    /// - [`SceneError::Margin`] when the margin is negative or not finite.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    pub fn check(&mut self, params: &CheckParams) -> Result<Vec<PairReport>, SceneError> {
        let CheckParams { margin } = *params;
        if !(margin.is_finite() && margin >= 0.0) {
            return Err(SceneError::Margin { margin });
        }
        self.bound_states()?;
        let scene = &*self;
        let pairs = scene.pairs_within(margin);
        let reports = parallel::map_with(&pairs, Scratch::default, |scratch, &(a, b)| {
            pair::examine((a, scene.body(a)), (b, scene.body(b)), margin, scratch)
        });
        Ok(reports.into_iter().flatten().collect())
    }
}
