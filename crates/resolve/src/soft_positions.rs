//! Positions of all soft bodies of a scene.

use glam::DVec3;
use scene::{Body, Scene};
use surface::parallel;

use crate::ResolveError;

/// Returns the positions of all soft bodies, with none for rigid ones.
pub(crate) fn soft_positions(scene: &Scene) -> Vec<Vec<DVec3>> {
    let soft = |body: &Body| if body.is_rigid() { Vec::new() } else { body.positions().to_vec() };
    parallel::map_slice_with(scene.bodies(), || (), |(), body| soft(body))
}

/// Moves all soft bodies to the positions given for them.
pub(crate) fn move_soft_bodies(
    scene: &mut Scene,
    positions: &[Vec<DVec3>],
) -> Result<(), ResolveError> {
    for (id, x) in scene.ids().zip(positions) {
        if !scene.body(id).is_rigid() {
            scene.move_body(id, x)?;
        }
    }
    Ok(())
}
