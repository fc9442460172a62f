//! Vertices that follow those that reduced surfaces have kept.

use response::{Follower, Followers, ResponseError};
use scene::Scene;
use surface::Term;

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
            let first = scene.body(id).particles().start;
            for (vertex, particle) in (0..).zip(scene.body(id).particles()) {
                // Vertices that lead themselves were kept, or have no faces.
                let leaders = coarse.leaders(vertex);
                if leaders[0].0 != vertex {
                    let term = |(leader, weight)| Term { particle: first + leader, weight };
                    followers.push(Follower { particle, leaders: leaders.map(term) });
                }
            }
        }
        Followers::new(followers).map_err(ResponseError::into)
    }
}
