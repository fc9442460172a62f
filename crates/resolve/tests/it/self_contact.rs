//! Bodies that cross themselves: a strap bent to a ring whose ends pass through each other.

use fixtures::{Mesh, shapes};
use glam::DVec3;
use kdop::Workspace;
use proximity::SurfaceTree;
use resolve::{Conditions, Resolution, ResolveError, ResolveParams, Resolver};
use scene::{BodyKind, Scene};
use surface::progress::Progress;

use crate::planted::crossed_wedges;
use crate::{PARAMS, scene_of};

/// Bends a strap 4 thick around the y axis by more than a turn. Its ends are over each other, and
/// their middles are `apart`.
fn ring(apart: f64) -> Mesh {
    let strap = shapes::plate(DVec3::new(80.0, 10.0, 4.0), [36, 5]);
    strap.mapped(|p| {
        let angle = p.x / 11.6;
        let radius = 11.6 + p.z + apart * p.x / 80.0;
        DVec3::new(radius * angle.sin(), p.y, radius * angle.cos())
    })
}

/// Counts the self-crossings of the first body.
fn self_crossings(scene: &Scene) -> usize {
    let body = &scene.bodies()[0];
    let x = body.positions().to_vec();
    let tree = SurfaceTree::new(body.surface().clone(), x).expect("finite positions");
    tree.self_crossings(&mut Workspace::default(), Progress::none()).expect("no interruption").len()
}

fn uncross(scene: &mut Scene, gap: f64) -> Result<Resolution, ResolveError> {
    let uncrossed = scene.ids().collect();
    let conditions = Conditions { uncrossed, ..Conditions::default() };
    let params = ResolveParams { gap, ..PARAMS };
    let mut resolver = Resolver::new(params).expect("parameters").with_conditions(conditions);
    resolver.resolve(scene, Progress::none())
}

#[test]
fn ends_of_a_ring_that_cross_come_apart() {
    let mesh = ring(3.0);
    assert!(mesh.volume() > 0.0);
    let mut scene = scene_of([("ring", BodyKind::Deformable, mesh)]);
    let before = self_crossings(&scene);
    assert!(before > 20, "{before}");

    // Left as it is where that is not asked for.
    let resolution = crate::resolve(&mut scene);
    assert!(resolution.resolved && resolution.self_overlaps.is_empty());
    assert_eq!((resolution.bodies[0].moved, self_crossings(&scene)), (0, before));

    let resolution = uncross(&mut scene, 0.0).expect("a closed body");
    let change = &resolution.bodies[0];
    assert_eq!((self_crossings(&scene), change.self_crossings), (0, [before, 0]));
    assert!(resolution.resolved && change.flipped_faces == 0, "{:?}", resolution.rounds);
    let volume = change.volume_ratio.expect("closed");
    assert!((volume - 1.0).abs() < 0.01, "{volume}");

    // Each end by about half of the overlap, and not around by the other side.
    assert!(change.max_displacement < 1.5, "{}", change.max_displacement);
}

#[test]
fn edges_of_one_body_that_cross_come_apart() {
    let [lower, upper] = crossed_wedges(0.25);
    let mut scene = scene_of([("wedges", BodyKind::Deformable, lower.joined(&upper))]);
    assert!(self_crossings(&scene) > 0);
    let resolution = uncross(&mut scene, 0.0).expect("a closed body");
    assert!(resolution.resolved && self_crossings(&scene) == 0, "{:?}", resolution.rounds);
}

#[test]
fn a_body_that_cannot_be_uncrossed_is_named() {
    // As deep in each other as they are thick: no side is the right one.
    let mut scene = scene_of([("ring", BodyKind::Deformable, ring(0.0))]);
    let resolution = uncross(&mut scene, 0.0).expect("a closed body");
    let left = self_crossings(&scene) > 0;
    assert_eq!(resolution.self_overlaps.len(), usize::from(left));
    assert_eq!(resolution.resolved, !left, "{:?}", resolution.rounds);

    // A sheet has no inside, and no side to leave by.
    let sheet = Mesh { faces: ring(3.0).faces[..40].to_vec(), ..ring(3.0) };
    let mut scene = scene_of([("sheet", BodyKind::Open, sheet)]);
    let refused = uncross(&mut scene, 0.0).expect_err("open");
    assert!(matches!(refused, ResolveError::NoInside { .. }), "{refused}");
}
