//! Static detection over a whole scene: every pair that comes within reach.

use crate::pair::{self, PairReport, Scratch};
use crate::{Scene, SceneError, parallel};

/// What to look for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckParams {
    /// How far outside contact vertices are still reported, in the scene's
    /// length unit, `>= 0`.
    pub reach: f64,
}

impl Scene {
    /// Looks at every pair of bodies in their present state, and reports those
    /// that overlap or have points within `reach` of each other, in the order
    /// of the bodies.
    ///
    /// Exact: whether and where faces cross, and which vertices are inside.
    /// Within rounding of a distance: depths and gaps.
    ///
    /// # Errors
    ///
    /// - [`SceneError::Reach`] when the reach is negative or not finite.
    /// - [`SceneError::Tree`] when a body is too large to build bounds for.
    pub fn check(&mut self, params: &CheckParams) -> Result<Vec<PairReport>, SceneError> {
        let CheckParams { reach } = *params;
        if !(reach.is_finite() && reach >= 0.0) {
            return Err(SceneError::Reach { reach });
        }
        self.bound_states()?;
        let scene = &*self;
        let pairs = scene.pairs_within(reach);
        let reports = parallel::map_with(&pairs, Scratch::default, |scratch, &(a, b)| {
            pair::examine((a, scene.body(a)), (b, scene.body(b)), reach, scratch)
        });
        Ok(reports.into_iter().flatten().collect())
    }
}
