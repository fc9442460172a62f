//! Faces of one body that cross each other.

use musculo_collide::kdop::Workspace;
use musculo_collide::surface::parallel;
use musculo_collide::{Body, Scene, SceneError};
use serde::Serialize;

use super::text::{counted, length};
use crate::scene::Unit;

/// Pairs of faces of one body that cross.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SelfCrossings {
    /// Number of pairs; faces with a common corner are not compared.
    count: usize,
    /// All pairs, ascending.
    pairs: Vec<CrossingFaces>,
}

/// Two faces of a body that cross.
#[derive(Clone, Copy, Debug, Serialize)]
struct CrossingFaces {
    faces: [u32; 2],
    /// Point halfway between the centers of the faces.
    at: [f64; 3],
}

/// Finds the self-crossings of every body, in the order of the scene; `None` without any.
pub(crate) fn self_crossings(scene: &mut Scene) -> Result<Vec<Option<SelfCrossings>>, SceneError> {
    // Bodies far from all others have no trees yet.
    scene.fit_all()?;
    #[expect(clippy::cast_precision_loss, reason = "an estimate of the time")]
    let cost = |body: &Body| body.surface().faces().len() as f64;
    let bodies = scene.bodies();
    Ok(parallel::map_costly_first(bodies, cost, Workspace::default, SelfCrossings::find))
}

impl SelfCrossings {
    fn find(workspace: &mut Workspace, body: &Body) -> Option<Self> {
        // Faces with a common corner always touch, and their crossings are not told apart.
        let mut pairs = Vec::new();
        for faces in body.tree()?.self_crossings(workspace) {
            let [a, b] = faces.map(|face| body.corners(face));
            let at = (a.into_iter().chain(b).sum::<glam::DVec3>() / 6.0).to_array();
            pairs.push(CrossingFaces { faces, at });
        }
        (!pairs.is_empty()).then_some(Self { count: pairs.len(), pairs })
    }

    /// Describes the number of pairs, and the place of the first.
    pub(super) fn text(&self, unit: Unit) -> String {
        // The place is rounded as lengths are.
        let count = counted(self.count, "self-crossing");
        let Some(CrossingFaces { faces: [a, b], at }) = self.pairs.first() else { return count };
        let [x, y, z] = at.map(|coordinate| length(coordinate, unit));
        let which = if self.count == 1 { "" } else { "the first " };
        format!("{count}, {which}of faces {a} and {b} at ({x}, {y}, {z})")
    }
}
