//! Contact records of near vertices, for sides that yield and sides that do not.

use fixtures::shapes;
use glam::DVec3;
use proximity::{ContactSurface, PairProximity, ParticleNumbers, SurfaceTree, contact};

/// Two balls that overlap: the first is numbered from 100, and of the second some vertices are kept
/// from a finer surface.
#[test]
fn stencils_name_particles_by_their_numbers_and_hold_their_identity() {
    let [a, b] = [0.0, 17.0].map(|x| {
        let ball = shapes::icosphere(10.0, 2).translated(DVec3::new(x, 0.3, 0.2));
        SurfaceTree::new(ball.surface(), ball.positions).expect("a tree")
    });
    let kept: Vec<u32> = (0..162).map(|vertex| 3 * vertex + 1).collect();
    let numbers = [
        ParticleNumbers { first: 100, kept: None },
        ParticleNumbers { first: 1000, kept: Some(&kept) },
    ];
    assert_eq!(ParticleNumbers::from(100), numbers[0]);
    assert_eq!([numbers[0].particle(7), numbers[1].particle(7)], [107, 1022]);
    let position = |particle: u32| match particle {
        1000.. => b.position((particle - 1001) / 3),
        _ => a.position(particle - 100),
    };

    let mut pair = PairProximity::default();
    pair.compute(&a, &b, 0.5).expect("few faces are near");
    for rigid in [[false, false], [false, true], [true, false], [true, true]] {
        let [p, q] = [0, 1].map(|k| ContactSurface {
            surface: [&a, &b][k].surface(),
            positions: [&a, &b][k].positions(),
            particles: numbers[k],
            is_rigid: rigid[k],
        });
        let near = pair.sides()[0].near();
        assert!(near.len() > 10 && near.iter().any(|near| near.gap < 0.0));
        for near in near {
            let contact = contact(&p, &q, near);
            assert!(contact.identity_error(position) < 1e-12, "{contact:?}");
            assert_eq!(contact.gap.to_bits(), near.gap.to_bits());

            // What does not yield is the anchor, and has no particle in the stencil.
            let (vertex, corners) = (100 + near.vertex, q.surface.faces()[near.face as usize]);
            let corners = corners.map(|corner| 1001 + 3 * corner);
            let particles: Vec<u32> =
                contact.stencil.terms().iter().map(|term| term.particle).collect();
            let anchor = contact.anchor.map(|anchor| anchor.point);
            match rigid {
                [false, false] => {
                    assert_eq!(particles, [vertex, corners[0], corners[1], corners[2]]);
                    assert_eq!((anchor, contact.normal), (None, near.normal));
                }
                [_, true] => {
                    assert_eq!(particles, [vertex]);
                    assert_eq!((anchor, contact.normal), (Some(near.foot), near.normal));
                }
                [true, false] => {
                    assert_eq!(particles, corners);
                    assert_eq!(anchor, Some(a.position(near.vertex)));
                    assert_eq!(contact.normal, -near.normal);
                }
            }
        }
    }
}
