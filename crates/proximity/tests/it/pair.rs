//! Pairs in memory that other pairs have used.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use fixtures::{Mesh, damage, shapes};
use glam::DVec3;
use proximity::{PairError, PairProximity, PairSide, SurfaceTree};
use surface::progress::Progress;

fn tree(mesh: Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions).expect("a tree")
}

#[test]
fn memory_of_another_pair_is_no_part_of_an_answer() {
    let a = tree(shapes::icosphere(10.0, 3));
    let mut used = PairProximity::default();
    let mut inside = 0;
    for (by, margin) in [(15.0, 0.0), (19.5, 0.5), (2.0, 0.0), (2.0, 1.0), (40.0, 1.0)] {
        let other = shapes::ellipsoid(DVec3::new(10.0, 4.0, 4.0), 3);
        let b = tree(other.translated(DVec3::new(by, 0.3, 0.1)));
        let mut fresh = PairProximity::default();
        fresh.compute(&a, &b, margin).expect("few faces are near");
        used.compute(&b, &a, 3.0 * margin).expect("few faces are near");
        used.compute(&a, &b, margin).expect("few faces are near");

        assert_eq!(used.crossing_faces(), fresh.crossing_faces(), "by {by}");
        for (used, fresh) in used.sides().into_iter().zip(fresh.sides()) {
            assert_eq!(used.inside_vertices(), fresh.inside_vertices(), "by {by}");
            assert_eq!(used.near(), fresh.near(), "by {by}");
            for face in 0..1280 {
                assert_eq!(used.near_faces().row(face), fresh.near_faces().row(face), "by {by}");
            }
            inside += fresh.inside_vertices().len();
        }

        // The first side alone is that of both.
        used.compute(&b, &a, margin).expect("few faces are near");
        used.compute_first(&a, &b, margin).expect("few faces are near");
        assert_eq!(used.crossing_faces(), fresh.crossing_faces(), "by {by}");
        let ([one, none], [same, _]) = (used.sides(), fresh.sides());
        assert_eq!(one.inside_vertices(), same.inside_vertices(), "by {by}");
        assert_eq!(one.near(), same.near(), "by {by}");
        assert!(none.near().is_empty() && none.inside_vertices().is_empty(), "by {by}");
    }
    assert!(inside > 20, "{inside}");
}

/// Vertices against a surface whose faces look inward: the same gaps and normals as where they look
/// outward, also at vertices that touch it, whose normals are those of faces.
#[test]
fn faces_that_look_inward_change_no_normal() {
    let plate = shapes::plate(DVec3::new(40.0, 30.0, 4.0), [8, 6]);
    let top = plate.positions.iter().map(|x| x.z).fold(f64::MIN, f64::max);
    let mut touching = 0;
    for (mesh, height) in [
        (shapes::cube(6.0), 3.0),
        (shapes::cube(6.0), 2.5),
        (shapes::octasphere(5.0, 2), 5.0),
        (shapes::icosphere(5.0, 2), 5.3),
        (shapes::icosphere(5.0, 2), 4.0),
    ] {
        let a = tree(mesh.translated(DVec3::new(0.3, 0.2, top + height)));
        let [outward, inward] = [tree(plate.clone()), tree(plate.clone().flipped())];
        assert!(inward.is_inside_out() && !outward.is_inside_out());
        let (mut found, mut turned) = (PairProximity::default(), PairProximity::default());
        found.compute(&a, &outward, 1.0).expect("few faces are near");
        turned.compute(&a, &inward, 1.0).expect("few faces are near");
        let [near, of_turned] = [&found, &turned].map(|found| found.sides()[0].near());
        assert_eq!(near.len(), of_turned.len());
        for (near, turned) in near.iter().zip(of_turned) {
            let [one, other] = [near, turned].map(|it| (it.vertex, it.face));
            assert_eq!(one, other);
            assert!((near.gap - turned.gap).abs() < 1e-12, "{near:?} {turned:?}");
            assert!(near.normal.distance(turned.normal) < 1e-9, "{near:?} {turned:?}");
            touching += usize::from(near.gap.abs() < 1e-12);
        }
    }
    assert!(touching >= 5, "{touching}");
}

/// Computes a pair, ended by the poll of a number.
fn compute_until(
    pair: &mut PairProximity,
    [a, b]: [&SurfaceTree; 2],
    last: usize,
) -> Result<(), PairError> {
    let polls = AtomicUsize::new(0);
    let handler = |_: f64| {
        let poll = polls.fetch_add(1, Ordering::Relaxed);
        if poll < last { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    pair.try_compute(a, b, 0.5, Progress::new(&handler))
}

#[test]
fn nothing_is_left_of_a_pair_that_was_interrupted() {
    let [a, b] = [0.0, 15.0].map(|x| tree(shapes::icosphere(10.0, 2).translated(x * DVec3::X)));
    let mut pair = PairProximity::default();
    let mut polls = 0;
    loop {
        // The pair before overlaps.
        pair.compute(&b, &a, 1.0).expect("few faces are near");
        if compute_until(&mut pair, [&a, &b], polls).is_ok() {
            break;
        }
        assert!(!pair.overlaps() && !pair.has_contact(), "ended by poll {polls}");
        assert!(pair.meeting_faces().is_empty() && pair.tested_faces() == 0, "poll {polls}");
        let is_empty = |side: &PairSide| side.near_faces().iter().next().is_none();
        assert!(pair.sides().into_iter().all(is_empty), "poll {polls}");
        polls += 1;
    }
    assert!(pair.overlaps() && polls > 4, "{polls}");
}

#[test]
fn a_body_deeper_inside_than_the_margin_is_near_with_all_of_its_vertices() {
    let (small, large) = (tree(shapes::cube(1.0)), tree(shapes::cube(9.0)));
    let mut pair = PairProximity::default();
    for margin in [0.0, 0.5, 5.0] {
        pair.compute(&small, &large, margin).expect("few faces are near");
        let near = pair.sides()[0].near();
        assert_eq!(near.len(), 8, "margin {margin}");
        assert!(near.iter().all(|near| (near.gap + 4.0).abs() < 1e-12), "margin {margin}");
    }
}

/// The vertex is on the face exactly; its computed foot is 2e-16 beside it.
#[test]
fn a_vertex_that_touches_a_face_is_within_any_margin() {
    let triangle = |corners: [[f64; 3]; 3]| {
        let positions = corners.map(DVec3::from_array).to_vec();
        tree(Mesh { positions, faces: vec![[0, 1, 2]] })
    };
    let a = triangle([[1.0, 1.0, 1.0], [3.0, 2.0, 1.0], [1.0, 2.0, 3.0]]);
    let b = triangle([[4.0, 0.0, 2.0], [2.0, 1.0, 0.0], [3.0, 3.0, 1.0]]);
    for bodies in [[&a, &b], [&b, &a]] {
        let mut pair = PairProximity::default();
        for margin in [0.0, 1e-300, 1e-15, 0.1] {
            pair.compute(bodies[0], bodies[1], margin).expect("few faces are near");
            let near: Vec<_> = pair.sides().iter().flat_map(|side| side.near()).collect();
            let touching = near.iter().filter(|near| near.vertex == 1 && near.gap < 1e-15);
            assert_eq!(touching.count(), 1, "{near:?} within {margin}");
            assert_eq!(pair.meeting_faces(), [[0, 0]], "within {margin}");
            assert!(pair.has_contact() && !pair.overlaps(), "within {margin}");
            let distance = pair.distance(bodies[0], bodies[1], margin).expect("they meet");
            assert!(distance == 0.0, "{distance} within {margin}");
        }
    }
}

/// Heights of whole numbers over faces that are not aligned, whose computed distances may be rounded
/// up.
#[test]
fn vertices_at_exactly_the_margin_are_near() {
    let mut rounded_up = 0;
    for k in 0..200_u32 {
        // Normals (2, -2, 1) / 3: a vertex that many normals from the plane is that far.
        let steps = [k % 7 + 1, k % 13 + 1, k % 11 + 1].map(f64::from);
        let (u, v) = (DVec3::new(1.0, 1.0, 0.0), DVec3::new(1.0, 0.0, -2.0));
        let origin = DVec3::new(steps[2], steps[0], -steps[1]);
        let corners =
            [origin, origin + (7.0 * u + v) * steps[0], origin + (13.0 * v + u) * steps[1]];
        let b = tree(Mesh { positions: corners.to_vec(), faces: vec![[0, 1, 2]] });
        let margin = 3.0 * f64::from(k % 4 + 1);
        let vertex =
            origin + steps[0] * u + steps[1] * v + margin / 3.0 * DVec3::new(2.0, -2.0, 1.0);
        let up = DVec3::new(20.0, -20.0, 10.0);
        let positions = vec![vertex, vertex + up, vertex + up + u];
        let a = tree(Mesh { positions, faces: vec![[0, 1, 2]] });

        let mut pair = PairProximity::default();
        pair.compute(&a, &b, margin).expect("few faces are near");
        let near = pair.sides()[0].near().to_vec();
        let [near] = near[..] else { panic!("{near:?} at {k}") };
        assert!(near.vertex == 0 && (near.gap - margin).abs() < 1e-13, "{near:?} at {k}");
        let distance = pair.distance(&a, &b, margin).expect("within the margin");
        assert!((distance - margin).abs() < 1e-13, "{distance} for {margin}");
        rounded_up += usize::from(near.gap > margin);
    }
    assert!(rounded_up >= 5, "{rounded_up} of 200");
}

/// Of a cube that stands on another, the vertices on its face are at a distance of 0: within any
/// margin, and inside of nothing.
#[test]
fn vertices_on_a_surface_are_within_a_margin_of_zero() {
    let floor = tree(shapes::cube(8.0));
    let mut pair = PairProximity::default();
    for (height, expected) in [(5.0, 4), (5.0_f64.next_up(), 0)] {
        let cube = tree(shapes::cube(2.0).translated(DVec3::new(0.25, 0.125, height)));
        pair.compute(&cube, &floor, 0.0).expect("few faces are near");
        let near = pair.sides()[0].near();
        assert_eq!(near.len(), expected, "at {height}");
        assert!(near.iter().all(|near| near.gap == 0.0 && near.normal == DVec3::Z), "{near:?}");
        assert!(!pair.overlaps());
        assert_eq!(pair.has_contact(), expected > 0, "at {height}");
    }
}

/// The difference of two points far from the origin is noise where they nearly coincide.
#[test]
fn normals_are_those_of_the_face_where_a_vertex_is_on_it_but_for_rounding() {
    let far = DVec3::new(1e6, -2e6, 3e6);
    let slope = DVec3::new(1.0, 2.0, 3.0);
    let plate = shapes::cube(8.0).rotated(slope, 0.1).translated(far);
    let up = (plate.normal(0)).normalize();
    let foot = plate.centroid(0);
    let floor = tree(plate);
    let mut pair = PairProximity::default();
    for (height, tolerance) in [(0.0, 1e-9), (1e-3, 1e-5), (0.1, 1e-7)] {
        let mut tip = shapes::tetrahedron(1.0);
        let lowest = (0..4).min_by(|i, j| {
            let [p, q] = [i, j].map(|k| tip.positions[*k].dot(up));
            p.total_cmp(&q)
        });
        let lowest = lowest.expect("a corner");
        let by = foot + height * up - tip.positions[lowest];
        tip = tip.translated(by);
        pair.compute(&tree(tip), &floor, 0.2).expect("few faces are near");
        let near = pair.sides()[0].near().iter().find(|near| near.vertex as usize == lowest);
        let near = near.expect("the tip is near");
        assert!((near.gap - height).abs() < 1e-8, "{near:?}");
        assert!(near.normal.distance(up) < tolerance, "{height}: {near:?} for {up}");
    }
}

/// What lies within a surface with a hole or a face too many is inside, though rays and parity decide nothing there; what lies in
/// a cup, reaches out of a sleeve, or is in a surface that is declared open is not.
#[test]
fn what_a_surface_with_holes_surrounds_is_inside() {
    let ball = || shapes::icosphere(10.0, 3);
    let dented = |radius: f64| damage::hole(ball(), 10.0 * DVec3::X, radius);
    let mut doubled = ball();
    doubled.faces.push(doubled.faces[0]);
    let small = |x: f64| tree(shapes::icosphere(2.0, 2).translated(DVec3::new(x, 0.1, 0.2)));
    let inside = |a: &SurfaceTree, b: &SurfaceTree| {
        let mut found = PairProximity::default();
        found.compute(a, b, 1.0).expect("few faces are near");
        let [of_a, of_b] = found.sides();
        assert!(of_a.inside_vertices().is_empty(), "the hollow one is in the other");
        assert_eq!(found.overlaps(), !of_b.inside_vertices().is_empty(), "by vertices");
        assert!(of_b.inside_count().is_err(), "no inside");
        (of_b.inside_vertices().len(), found.max_vertex_depth())
    };

    let whole = small(0.0).surface().vertex_count();
    for surface in [dented(2.0), dented(8.0), doubled.clone(), doubled.flipped()] {
        let (count, depth) = inside(&tree(surface), &small(3.0));
        assert_eq!(count, whole, "all of it");
        assert!(depth > 8.0 && depth < 10.0, "{depth}");
    }
    let cup = tree(damage::hole(ball(), 10.0 * DVec3::X, 15.0));
    for x in [3.0, 6.0, 14.0] {
        assert_eq!(inside(&cup, &small(x)).0, 0, "{x}");
    }
    let sleeve = damage::hole(dented(5.0), -10.0 * DVec3::X, 5.0);
    let along = shapes::capsule(1.0, 30.0, 12);
    let along = along.mapped(|p| DVec3::new(p.z, p.x, p.y));
    assert_eq!(inside(&tree(sleeve), &tree(along)).0, 0, "it reaches out");
    assert_eq!(inside(&tree(dented(2.0)).declared_open(), &small(0.0)).0, 0, "declared open");
}
