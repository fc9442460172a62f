//! Bodies whose faces look inward: pushed apart as those whose faces look outward.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use resolve::{Resolution, ResolveParams};
use scene::{BodyKind, Scene};
use surface::progress::Progress;

use crate::{PARAMS, scene_of};

/// A bone and a muscle that overlap: two balls, a ball in a plate, a plate in a ball, a ring around a rod,
/// and edges that cross.
fn overlaps() -> [[Mesh; 2]; 5] {
    let ball = shapes::icosphere(10.0, 3);
    let bone = shapes::octasphere(10.0, 0).rotated(DVec3::Y, 0.125);
    let edge = 10.0 / f64::sqrt(2.0);
    let crossing = bone.clone().rotated(DVec3::Z, 0.25).translated(DVec3::Z * (2.0 * edge - 0.3));
    [
        [ball.clone(), ball.rotated(DVec3::Z, 0.1).translated(DVec3::X * 18.6)],
        [
            shapes::icosphere(6.0, 3).translated(DVec3::Z * 6.2),
            shapes::plate(DVec3::new(60.0, 60.0, 2.0), [24, 24]),
        ],
        [
            shapes::plate(DVec3::new(60.0, 60.0, 2.0), [12, 12]).translated(-DVec3::Z),
            shapes::icosphere(12.0, 3).translated(DVec3::Z * 10.4),
        ],
        [
            shapes::capsule(10.0, 40.0, 40).rotated(DVec3::Z, 0.05),
            shapes::torus(12.0, 4.0, [60, 24]),
        ],
        [bone, crossing],
    ]
}

/// Resolves an overlap with faces of the bone, and of the muscle, as they are or turned over.
fn resolve([bone, muscle]: &[Mesh; 2], turned: [bool; 2], gap: f64) -> (Scene, Resolution) {
    let [bone, muscle] = [(bone, turned[0]), (muscle, turned[1])]
        .map(|(mesh, turned)| if turned { mesh.clone().flipped() } else { mesh.clone() });
    let bodies = [("bone", BodyKind::Rigid, bone), ("muscle", BodyKind::Deformable, muscle)];
    let (mut scene, params) = (scene_of(bodies), ResolveParams { gap, ..PARAMS });
    let resolution = resolve::resolve(&mut scene, &params, Progress::none());
    (scene, resolution.expect("a resolution"))
}

#[test]
fn faces_that_look_inward_change_no_resolution() {
    for (number, bodies) in overlaps().iter().enumerate() {
        for gap in [0.0, 0.05] {
            let (scene, outward) = resolve(bodies, [false; 2], gap);
            assert!(outward.resolved, "{number}: {:?}", outward.remaining);
            for turned in [[false, true], [true, false], [true, true]] {
                let (other, inward) = resolve(bodies, turned, gap);
                assert!(inward.resolved, "{number}, {turned:?}: {:?}", inward.remaining);
                assert_eq!(inward.rounds.len(), outward.rounds.len(), "{number}, {turned:?}");

                // Corners come in another order, by which ties between faces are decided.
                let x = scene.particle_positions().into_iter().zip(other.particle_positions());
                let apart = x.map(|(p, q)| p.distance(q)).fold(0.0, f64::max);
                assert!(apart < 0.01, "{number}, {turned:?}, gap {gap}: {apart} apart");
            }
        }
    }
}
