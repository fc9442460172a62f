//! Whole answers beside those of all vertices and faces.

use fixtures::generate::{cases, convex, turned};
use fixtures::random::Random;
use fixtures::{Mesh, damage, reference, shapes};
use glam::DVec3;
use kdop::Workspace;
use proximity::{NearVertex, NoInside, PairProximity, PairSide, SurfaceTree};
use surface::progress::Progress;
use surface::{closest_between_triangles, triangles_meet, winding_number};

/// Bound on the rounding of distances between bodies of 40.
const ROUNDING: f64 = 1e-11;

fn tree(mesh: &Mesh) -> SurfaceTree {
    SurfaceTree::new(mesh.surface(), mesh.positions.clone()).expect("a tree")
}

fn numbers(count: usize) -> std::ops::Range<u32> {
    0..u32::try_from(count).expect("a small mesh")
}

/// Checks a vertex that is near against the closest of all faces.
fn check_near(near: &NearVertex, p: &Mesh, q: &Mesh, is_inside: bool) {
    let position = p.positions[near.vertex as usize];
    let closest = reference::closest(q, position).expect("a face");
    assert!((near.gap.abs() - closest.distance).abs() < ROUNDING, "{near:?}, {closest:?}");
    assert_eq!(near.gap < 0.0, is_inside, "{near:?}");
    assert!(near.normal.is_normalized(), "{near:?}");
    let identity = near.foot + near.gap * near.normal;
    assert!(identity.distance(position) < ROUNDING, "{near:?} for {position}");

    let corners = q.corners(near.face as usize);
    let by_weights: DVec3 = (0..3).map(|k| near.barycentric[k] * corners[k]).sum();
    assert!(by_weights.distance(near.foot) < ROUNDING, "{near:?}");
}

/// Returns the vertices of `p` that `q` surrounds without meeting it: all, where all winding numbers are beyond a half.
fn surrounded(p: &Mesh, q: &Mesh, meets: bool) -> Vec<u32> {
    let q = tree(q);
    let is_within = |p: &DVec3| winding_number(q.surface(), q.positions(), *p).abs() > 0.5;
    let all = !meets && p.positions.iter().all(is_within);
    if all { numbers(p.positions.len()).collect() } else { Vec::new() }
}

/// Checks the vertices of `p` against `q`; returns how many are inside, and how many are near.
fn check_side(side: &PairSide, p: &Mesh, q: &Mesh, margin: f64, meets: bool) -> [usize; 2] {
    let is_closed = tree(q).has_inside().is_ok();
    let inside = if is_closed { reference::vertices_inside(p, q) } else { surrounded(p, q, meets) };
    assert_eq!(side.inside_vertices(), inside, "closed: {is_closed}");
    assert_eq!(side.inside_count().ok(), is_closed.then_some(inside.len()), "{inside:?}");

    let mut near = side.near().iter();
    for vertex in numbers(p.positions.len()) {
        let distance =
            reference::closest(q, p.positions[vertex as usize]).expect("a face").distance;
        let is_inside = inside.contains(&vertex);
        if is_inside || distance <= margin {
            let found = near.next().expect("all vertices that are near");
            assert_eq!(found.vertex, vertex, "of distance {distance}");
            check_near(found, p, q, is_inside);
        }
    }
    assert_eq!(near.next(), None, "within {margin}");
    [inside.len(), side.near().len()]
}

/// Checks the faces of a pair: those within the margin are in the lists of both sides, and no others
/// meet. Returns how many do.
fn check_faces(pair: &PairProximity, [a, b]: [&Mesh; 2], margin: f64) -> usize {
    let [of_a, of_b] = pair.sides().map(PairSide::near_faces);
    let mut meeting = Vec::new();
    for f in numbers(a.faces.len()) {
        for g in numbers(b.faces.len()) {
            let corners = [a.corners(f as usize), b.corners(g as usize)];
            if closest_between_triangles(corners[0], corners[1]).distance() < margin {
                assert!(of_a.row(f).contains(&g), "{f}, {g} within {margin}");
                assert!(of_b.row(g).contains(&f), "{f}, {g} within {margin}");
            }
            if triangles_meet(corners[0], corners[1]).shares_a_point() {
                meeting.push([f, g]);
            }
        }
    }

    let mut found = pair.meeting_faces().to_vec();
    found.sort_unstable();
    assert_eq!(found, meeting, "within {margin}");
    assert!(pair.tested_faces() >= meeting.len(), "{}", pair.tested_faces());
    assert_eq!(pair.crossing_faces(), reference::crossing_faces(a, b), "within {margin}");
    meeting.len()
}

/// Checks all that is known of a pair within a margin; returns how many vertices are inside, and how
/// many are near.
fn check_pair(pair: &mut PairProximity, [a, b]: [&Mesh; 2], margin: f64) -> [usize; 2] {
    let trees = [tree(a), tree(b)];
    pair.compute(&trees[0], &trees[1], margin).expect("few faces are near");
    let meeting = check_faces(pair, [a, b], margin);
    let [of_a, of_b] = pair.sides();
    let of_a = check_side(of_a, a, b, margin, meeting > 0);
    let of_b = check_side(of_b, b, a, margin, meeting > 0);

    // What sums up a pair is that of its lists.
    let gaps = pair.sides().into_iter().flat_map(PairSide::near).map(|near| near.gap);
    let min_gap = gaps.min_by(f64::total_cmp);
    assert_eq!(pair.min_gap(), min_gap, "within {margin}");
    let depth = min_gap.map_or(0.0, |gap| (-gap).max(0.0));
    assert_eq!(pair.max_vertex_depth().to_bits(), depth.to_bits(), "{min_gap:?}");
    let overlaps = !pair.crossing_faces().is_empty() || of_a[0] + of_b[0] > 0;
    assert_eq!(pair.overlaps(), overlaps, "within {margin}");
    assert_eq!(pair.has_contact(), overlaps || min_gap.is_some(), "within {margin}");

    let distance = pair.distance(&trees[0], &trees[1], margin);
    let apart = reference::distance_between(a, b, margin);
    let expected = if meeting > 0 { Some(0.0) } else { apart };
    let difference = distance.unwrap_or(f64::MAX) - expected.unwrap_or(f64::MAX);
    assert!(difference.abs() < ROUNDING, "{distance:?} for {expected:?} within {margin}");
    [of_a[0] + of_b[0], of_a[1] + of_b[1]]
}

/// Bodies apart, pressed into each other, and one within the other, of any shape.
#[test]
fn pairs_of_closed_bodies_agree_with_all_vertices_and_faces() {
    let (mut pair, mut counts, mut apart) = (PairProximity::default(), [0; 2], 0);
    cases(3, 60, |u| {
        let a = convex(u)?;
        let b = match u.int_in_range(0_u8..=3)? {
            0 => turned(u, shapes::torus(20.0, 6.0, [14, 8]))?,
            _ => convex(u)?,
        };
        let direction =
            DVec3::new(0.6, 0.64, 0.48) * f64::from(u.int_in_range(0_u16..=700)?) / 10.0;
        let b = turned(u, b)?.translated(direction);
        let margin = f64::from(u.int_in_range(0_u8..=3)?) * 2.1;
        let found = check_pair(&mut pair, [&a, &b], margin);
        counts = [counts[0] + found[0], counts[1] + found[1]];
        apart += usize::from(!pair.has_contact());
        Ok(())
    });
    assert!(
        counts[0] > 300 && counts[1] > counts[0] + 200 && apart > 5,
        "{counts:?}, {apart} apart"
    );
}

/// An open surface has sides, and no inside but for what it surrounds as a whole.
#[test]
fn a_surface_with_a_hole_has_no_inside_but_surrounds_bodies() {
    let open = damage::hole(shapes::icosphere(10.0, 2), 10.0 * DVec3::Y, 3.0);
    let ball = shapes::icosphere(6.0, 2).rotated(DVec3::new(1.0, 2.0, 3.0), 0.1);
    let (mut pair, mut surrounded) = (PairProximity::default(), 0);
    for (x, margin) in [(0.0, 1.0), (3.9, 0.2), (6.0, 0.0), (6.0, 1.0), (15.9, 0.5), (30.0, 2.0)] {
        let ball = ball.clone().translated(DVec3::new(x, 0.1, 0.2));
        check_pair(&mut pair, [&open, &ball], margin);
        assert!(pair.sides()[1].inside_count().is_err(), "at {x}");
        surrounded += usize::from(pair.overlaps() && pair.crossing_faces().is_empty());
        check_pair(&mut pair, [&ball, &open], margin);
    }
    assert!(surrounded > 0, "the ball is within it at first");
}

/// What is declared open has no inside either, and all else stays.
#[test]
fn nothing_is_inside_a_surface_that_is_declared_open() {
    let large = tree(&shapes::icosphere(10.0, 2));
    let small = tree(&shapes::cube(3.0));
    let mut pair = PairProximity::default();
    pair.compute(&small, &large, 8.7).expect("few faces are near");
    let closed = pair.sides()[0].near().to_vec();
    assert_eq!(pair.sides()[0].inside_vertices().len(), 8);

    let open = large.declared_open();
    assert_eq!(open.has_inside(), Err(NoInside::DeclaredOpen));
    assert_eq!(open.has_winding_number(), Err(NoInside::DeclaredOpen));
    pair.compute(&small, &open, 8.7).expect("few faces are near");
    assert_eq!(pair.sides()[0].inside_count(), Err(NoInside::DeclaredOpen));
    assert!(!pair.overlaps() && pair.has_contact());
    for (near, before) in pair.sides()[0].near().iter().zip(&closed) {
        assert_eq!((near.gap, near.normal), (-before.gap, -before.normal), "{near:?}");
    }
    assert_eq!(pair.sides()[0].near().len(), closed.len());
}

/// Spikes through others, anywhere along a surface.
#[test]
fn crossings_of_a_surface_with_itself_are_those_of_all_faces() {
    let (mut crossings, mut at_corners) = (0, 0);
    cases(5, 20, |u| {
        let mut mesh = convex(u)?;
        let pressed = u.choose_index(mesh.positions.len())?;
        mesh.positions[pressed] *= -1.5;
        let found = tree(&mesh).self_crossings(&mut Workspace::default(), Progress::none());
        let expected = reference::self_crossings(&mesh);
        let common = |[f, g]: [u32; 2]| {
            let [f, g] = [f, g].map(|face| mesh.faces[face as usize]);
            f.iter().filter(|corner| g.contains(corner)).count()
        };
        crossings += expected.len();
        at_corners += expected.iter().filter(|pair| common(**pair) == 1).count();
        assert_eq!(found, Ok(expected));
        Ok(())
    });
    assert!(crossings > 50 && at_corners > 10, "{crossings}, {at_corners} of a common corner");
}

/// Fans about one vertex: once around and flat, folded, twice around, open, and with faces of both sides.
#[test]
fn crossings_of_faces_at_a_vertex_are_those_of_all_pairs() {
    let (mut random, mut with_crossings) = (Random(6), 0);
    for case in 0..400 {
        let count = if case % 20 == 0 { 50 } else { 3 + random.below(7) };
        let turns = f64::from(1 + case % 2);
        let is_closed = case % 3 > 0;
        let height = [1e-3, 0.1, 1.0][random.below(3)];
        let spokes: Vec<f64> = (0..count).map(|_| 0.4 * random.unit()).collect();
        let step = std::f64::consts::TAU * turns / f64::from(u32::try_from(count).expect("few"));
        let mut positions = vec![DVec3::ZERO];
        for (spoke, shift) in (0..).map(f64::from).zip(spokes) {
            let (sin, cos) = (step * (spoke + shift)).sin_cos();
            let length = 1.0 + 0.5 * random.unit();
            positions.push(length * DVec3::new(cos, sin, height * random.unit()));
        }
        let spokes = u32::try_from(count).expect("few");
        let faces = 0..spokes - u32::from(!is_closed);
        let faces = faces.map(|spoke| [0, 1 + spoke, 1 + (spoke + 1) % spokes]).collect();
        let mesh = Mesh { positions, faces };
        let found = tree(&mesh).self_crossings(&mut Workspace::default(), Progress::none());
        let expected = reference::self_crossings(&mesh);
        with_crossings += usize::from(!expected.is_empty());
        assert_eq!(found, Ok(expected), "case {case}");
    }
    assert!((50..350).contains(&with_crossings), "{with_crossings}");
}
