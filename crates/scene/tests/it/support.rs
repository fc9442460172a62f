//! Scenes of shapes, and numbers to vary them by.

use arbitrary::{Result, Unstructured};
use fixtures::Mesh;
use glam::DVec3;
use scene::{BodyId, BodyKind, Scene};

/// A scene of these meshes, all deformable, and their numbers.
pub(crate) fn scene_of(meshes: &[&Mesh]) -> (Scene, Vec<BodyId>) {
    let mut scene = Scene::new();
    let add = |(i, mesh): (usize, &&Mesh)| {
        let name = format!("body {i}");
        scene.add(name, BodyKind::Deformable, mesh.surface(), mesh.positions.clone())
    };
    let ids: Result<_, _> = meshes.iter().enumerate().map(add).collect();
    (scene, ids.expect("shapes make a scene"))
}

/// A number of this range.
pub(crate) fn share(u: &mut Unstructured<'_>, from: f64, to: f64) -> Result<f64> {
    Ok(from + (to - from) * f64::from(u.int_in_range(0_u16..=1000)?) / 1000.0)
}

/// A vector with components of at most this size.
pub(crate) fn vector(u: &mut Unstructured<'_>, size: f64) -> Result<DVec3> {
    Ok(DVec3::new(share(u, -size, size)?, share(u, -size, size)?, share(u, -size, size)?))
}
