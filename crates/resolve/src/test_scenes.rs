//! Scenes for unit tests.

use fixtures::Mesh;
use scene::{BodyKind, Scene};

/// Builds a scene of a rigid body and a deformable one.
pub(crate) fn bone_and_muscle(bone: Mesh, muscle: Mesh) -> Scene {
    let mut scene = Scene::new();
    for (name, kind, mesh) in
        [("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle)]
    {
        scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body");
    }
    scene
}
