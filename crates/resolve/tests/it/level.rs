//! Bodies that overlap with their sides level: no face crosses another, and no vertex is inside.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use fixtures::{Mesh, shapes};
use glam::DVec3;
use resolve::{ResolveError, ResolveParams};
use scene::{BodyKind, Scene};
use surface::progress::Progress;

use crate::{PARAMS, scene_of};

const SIDE: f64 = 10.0;
const WITH_GAP: ResolveParams = ResolveParams { gap: 0.05, ..PARAMS };

/// Boxes of two triangles per side, the first one at the origin and each other at a place.
fn boxes(places: &[DVec3], first: BodyKind, placed: impl Fn(Mesh) -> Mesh) -> Scene {
    let kinds = std::iter::once(first).chain(std::iter::repeat(BodyKind::Deformable));
    let places = std::iter::once(&DVec3::ZERO).chain(places);
    let names = ["first", "second", "third"];
    scene_of(
        names.into_iter().zip(kinds).zip(places).map(|((name, kind), &place)| {
            (name, kind, placed(shapes::cube(SIDE).translated(place)))
        }),
    )
}

#[test]
fn boxes_in_a_row_come_apart() {
    let along = |depth: f64| (SIDE - depth) * DVec3::X;
    for (places, count, depth) in [
        (vec![along(1.0)], 1, 1.0),
        (vec![along(0.5 * SIDE)], 1, 0.5 * SIDE),
        (vec![along(0.1) - along(0.1).length() * DVec3::Z], 1, 0.1),
        (vec![along(1.0), 2.0 * along(1.0)], 2, 1.0),
    ] {
        for first in [BodyKind::Rigid, BodyKind::Deformable] {
            let mut scene = boxes(&places, first, |mesh| mesh);
            let resolution = resolve::resolve(&mut scene, &WITH_GAP, Progress::none());
            let resolution = resolution.expect("a resolution");
            assert!(resolution.resolved, "{places:?} {first:?}: {:?}", resolution.remaining);
            assert!(resolution.gap.holds(), "{places:?} {first:?}");

            // By the side that is level, and not across a box.
            let longest = 1.7 * depth * f64::from(count) + 0.1;
            for change in &resolution.bodies {
                let moved = change.max_displacement;
                assert!(moved <= longest, "{places:?} {first:?}: {moved} of {longest}");
            }
        }
    }
}

#[test]
fn level_boxes_come_apart_in_any_unit_and_axes() {
    let axis = DVec3::new(0.3, 1.0, 0.2).normalize();
    for unit in [1e-3, 1e3] {
        let params =
            ResolveParams { gap: 0.05 * unit, ..ResolveParams::with_smoothing(6.0 * unit) };
        let placed = |mesh: Mesh| mesh.rotated(axis, 1.0 / 6.0).scaled(DVec3::splat(unit));
        let mut scene = boxes(&[9.0 * DVec3::X], BodyKind::Rigid, placed);
        let resolution = resolve::resolve(&mut scene, &params, Progress::none());
        assert!(resolution.expect("a resolution").resolved, "{unit}");
    }
}

#[test]
fn an_interrupted_start_puts_level_boxes_back() {
    let mut scene = boxes(&[9.0 * DVec3::X], BodyKind::Deformable, |mesh| mesh);
    let before = scene.particle_positions();
    let mut interrupted = 0;
    for last in 0.. {
        let polls = AtomicUsize::new(0);
        let stop = |_| {
            let goes_on = polls.fetch_add(1, Ordering::Relaxed) < last;
            if goes_on { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
        };
        match resolve::resolve(&mut scene, &WITH_GAP, Progress::new(&stop)) {
            Err(ResolveError::Interrupted(_)) => interrupted += 1,
            ended => {
                assert!(ended.expect("a resolution").resolved, "the boxes come apart");
                break;
            }
        }
        assert_eq!(scene.particle_positions(), before, "{last} polls");
    }
    assert!(interrupted > 20, "{interrupted} interruptions");
}
