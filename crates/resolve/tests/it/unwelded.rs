//! Meshes whose vertices are not welded: each face has corners of its own, or a seam has vertices twice.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use resolve::resolve;
use scene::BodyKind;
use surface::progress::Progress;

use crate::{PARAMS, scene_of};

/// Gives each of the first faces corners of its own.
fn separated(mut mesh: Mesh, count: usize) -> Mesh {
    for face in mesh.faces.iter_mut().take(count) {
        for vertex in face {
            mesh.positions.push(mesh.positions[*vertex as usize]);
            *vertex = u32::try_from(mesh.positions.len() - 1).expect("few");
        }
    }
    mesh
}

#[test]
fn a_muscle_that_would_tear_is_refused_by_name() {
    for kind in [BodyKind::Deformable, BodyKind::Open] {
        for (separate, seams) in [(usize::MAX, 3840), (1, 6)] {
            let bone = shapes::plate(DVec3::new(40.0, 40.0, 8.0), [8, 8]);
            let muscle = shapes::icosphere(8.0, 3).translated(DVec3::Z * 11.0);
            let muscle = separated(muscle, separate);
            let start = muscle.positions.clone();
            let mut scene = scene_of([("bone", BodyKind::Rigid, bone), ("muscle", kind, muscle)]);

            let resolution = resolve(&mut scene, &PARAMS, Progress::none());
            let refused = resolution.map(|resolution| resolution.resolved).expect_err("tears");
            let words = format!(
                "'muscle' would tear: the vertices are not welded: {seams} edges with one face only are in the place of others"
            );
            assert!(refused.to_string().starts_with(&words), "{refused}");
            assert_eq!(scene.bodies()[1].positions(), start);
        }
    }
}

#[test]
fn a_bone_with_a_seam_pushes_as_before() {
    let bone = separated(shapes::plate(DVec3::new(40.0, 40.0, 8.0), [8, 8]), 1);
    let muscle = shapes::icosphere(8.0, 3).translated(DVec3::Z * 12.5);
    let bodies = [("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle)];
    let mut scene = scene_of(bodies);
    let resolved = resolve(&mut scene, &PARAMS, Progress::none()).expect("a resolution").resolved;
    assert!(resolved);
}
