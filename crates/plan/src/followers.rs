//! Vertices that follow those that reduced surfaces have kept.

use response::{Follower, Followers, ResponseError};
use scene::Scene;

use crate::{Plan, PlanError};

impl Plan {
    /// Returns the particles that follow others where the plan compares reduced surfaces, for a
    /// [`SceneStep`](scene::SceneStep): contacts are of the vertices that these have kept.
    ///
    /// # Errors
    ///
    /// [`PlanError::OtherScene`] when the scene has other bodies than planned.
    pub fn followers(&self, scene: &Scene) -> Result<Followers, PlanError> {
        self.check_scene(scene)?;
        let mut followers = Vec::new();
        for id in scene.ids() {
            let Some(coarse) = self.structures.coarse(id) else { continue };
            for (particle, leaders) in coarse.followers(scene.body(id).particles()) {
                followers.push(Follower { particle, leaders });
            }
        }
        Followers::new(followers).map_err(ResponseError::into)
    }
}
