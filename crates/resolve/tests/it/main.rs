//! Tests of overlap removal.

mod absurd;
mod accepted;
mod anatomy;
mod cells;
mod extremes;
mod gap;
mod inside_out;
mod interruption;
mod knee;
mod level;
mod planted;
mod seams;
mod self_contact;
mod set_aside;
mod thigh;
mod unwelded;
mod voxels;
mod walk;

use fixtures::Mesh;
use glam::DVec3;
use resolve::{Resolution, ResolveParams};
use scene::{BodyId, BodyKind, CheckParams, Scene};
use surface::progress::Progress;

const PARAMS: ResolveParams = ResolveParams::with_smoothing(6.0);

/// Builds a scene of named meshes.
fn scene_of(bodies: impl IntoIterator<Item = (&'static str, BodyKind, Mesh)>) -> Scene {
    let mut scene = Scene::new();
    for (name, kind, mesh) in bodies {
        scene.add(name, kind, mesh.surface(), mesh.positions).expect("a body of the scene");
    }
    scene
}

fn resolve(scene: &mut Scene) -> Resolution {
    resolve::resolve(scene, &PARAMS, Progress::none()).expect("a resolution")
}

/// Returns the depth of the deepest overlap, as detection finds it.
fn max_depth(scene: &mut Scene) -> f64 {
    let pairs =
        scene.check(&CheckParams::without_measures(0.0), Progress::none()).expect("a check");
    pairs.iter().map(|pair| pair.max_vertex_depth).fold(0.0, f64::max)
}

/// Moves all vertices of all bodies.
fn move_all(scene: &mut Scene, mut to: impl FnMut(BodyId, DVec3) -> DVec3) {
    for id in scene.ids() {
        let x: Vec<DVec3> = scene.body(id).positions().iter().map(|&x| to(id, x)).collect();
        scene.move_body(id, &x).expect("finite positions");
    }
}
