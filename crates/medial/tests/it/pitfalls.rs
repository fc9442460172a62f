//! Scenes in which simpler methods fail, each with the size of their error.

use std::f64::consts::SQRT_2;

use fixtures::random::Random;
use fixtures::{Mesh, reference, shapes};
use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use medial::{
    Ball, Deviation, FootRule, MedialBounds, MedialContactParams, MedialParams, MedialScratch,
    MedialSurface, ParticleOffsets, PrimitiveContact, PrimitiveTree, QueryPoints, foot, pair_foot,
    point_contacts, primitive_contacts, slab_foot,
};
use surface::Contact;

use crate::support::{Detected, generated, muscle, vector, with_balls};

fn surface_of(balls: Vec<Ball>, cones: Vec<[u32; 2]>, slabs: Vec<[u32; 3]>) -> MedialSurface {
    MedialSurface::new(balls, cones, slabs).expect("valid by construction")
}

fn capsule(from: DVec3, to: DVec3, radius: f64) -> MedialSurface {
    surface_of(vec![Ball::new(from, radius), Ball::new(to, radius)], vec![[0, 1]], vec![])
}

/// A wide sheet at z = 0 of half thickness `r`.
fn sheet(r: f64) -> MedialSurface {
    let corners = [(-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)];
    let balls = corners.map(|(x, y)| Ball::new(DVec3::new(x, y, 0.0), r)).to_vec();
    surface_of(balls, vec![], vec![[0, 1, 2], [0, 2, 3]])
}

/// Contacts of bare points.
fn touching(points: &[DVec3], medial: &MedialSurface, params: MedialContactParams) -> Vec<Contact> {
    let tree = Tree::build(Leaves::Points, points).expect("finite points");
    let query = QueryPoints { tree: &tree, points, radii: None };
    let on = MedialBounds { medial, tree: &PrimitiveTree::new(medial).expect("finite balls") };
    let particles = ParticleOffsets { first_point: 0, first_ball: 1000 };
    point_contacts(&query, on, &params, particles, &mut Workspace::default()).0
}

/// Pairs of primitives that overlap.
fn overlaps(a: &MedialSurface, b: &MedialSurface) -> Vec<PrimitiveContact> {
    let [of_a, of_b] = [a, b].map(|medial| PrimitiveTree::new(medial).expect("finite balls"));
    let on_a = MedialBounds { medial: a, tree: &of_a };
    let on_b = MedialBounds { medial: b, tree: &of_b };
    primitive_contacts(on_a, on_b, 0.0, &mut Workspace::default()).0
}

/// Two balls on a diagonal. Bounds without the norm of the direction separate them from √2 R on,
/// though they overlap up to 2 R: of all overlapping pairs of equal balls, 52 %.
#[test]
fn bounds_on_diagonals_contain_the_ball() {
    let mut overlapping = 0;
    let mut separated_without_norm = 0;
    let steps = -20..=20_i32;
    for i in steps.clone() {
        for j in steps.clone() {
            for k in steps.clone() {
                let d = DVec3::new(f64::from(i), f64::from(j), f64::from(k)) / 10.0;
                if d.length() >= 2.0 {
                    continue;
                }
                overlapping += 1;
                let bare = (0..9).any(|axis| d.dot(kdop::direction::<9>(axis)).abs() > 2.0);
                separated_without_norm += i32::from(bare);
            }
        }
    }
    let share = f64::from(separated_without_norm) / f64::from(overlapping);
    assert!((0.48..0.56).contains(&share), "{share}");
    let unit = surface_of(vec![Ball::new(DVec3::ZERO, 1.0)], vec![], vec![]);
    for length in [1.01 * SQRT_2, 1.7, 1.999] {
        let center = length * DVec3::new(1.0, 1.0, 0.0) / SQRT_2;
        let other = surface_of(vec![Ball::new(center, 1.0)], vec![], vec![]);
        assert_eq!(overlaps(&unit, &other).len(), 1, "balls {length} apart");
    }
}

/// On a cone of slope k = 0.5 and radius 1, the distance of a point on the surface by the bare face
/// is 1/√(1 − k²) − 1 = 0.155, with a normal 30° off.
#[test]
fn the_bare_face_is_wrong_on_slopes() {
    let k = 0.5_f64;
    let cone = [Ball::new(DVec3::ZERO, 1e-3), Ball::new(DVec3::X * 20.0, 10.0 + 1e-3)];
    let cone = [cone[0], cone[1], cone[1]];
    // The ball of radius 1 touches the cone's surface at sin = k ahead.
    let center = DVec3::X * (1.0 - 1e-3) / k;
    let normal = DVec3::new(-k, (1.0 - k * k).sqrt(), 0.0);
    let p = center + normal;
    let exact = foot(p, &cone, FootRule::Exact);
    let bare = foot(p, &cone, FootRule::BareFace);
    assert!(exact.distance.abs() < 1e-12, "{exact:?}");
    let radius = bare.ball.radius;
    let relative = bare.distance / radius;
    assert!((relative - (1.0 / (1.0 - k * k).sqrt() - 1.0)).abs() < 1e-9, "{relative}");
    let angle = bare.normal(p).unwrap().angle_between(normal).to_degrees();
    assert!((angle - 30.0).abs() < 1e-6, "{angle}");
}

/// Two capsules of length 6 r crossed at their middles. Balls at the ends are outside the other
/// capsule; the primitives overlap by 2 r.
#[test]
fn crossed_capsules_are_detected_by_primitives_alone() {
    let r = 1.0;
    let a = capsule(-3.0 * DVec3::X, 3.0 * DVec3::X, r);
    let b = capsule(-3.0 * DVec3::Y, 3.0 * DVec3::Y, r);
    for (balls, of) in [(&a, &b), (&b, &a)] {
        let other = of.primitive_balls(0);
        for ball in balls.balls() {
            assert!(slab_foot(ball.center, &other).distance - ball.radius >= 1.0 - 1e-12);
        }
    }
    let found = overlaps(&a, &b);
    assert!((found[0].gap + 2.0 * r).abs() < 1e-12, "{found:?}");
    // With edges no longer than a radius, balls lose overlaps of 0.006 r at most.
    let mut worst = 0.0_f64;
    for i in 0..=200 {
        for j in 0..=200 {
            let [x, angle] = [f64::from(i) / 200.0 - 0.5, f64::from(j) / 200.0 * 1.57];
            let turn = DVec3::new(angle.cos(), angle.sin(), 0.0) / 2.0;
            let (short, lifted) = (DVec3::X / 2.0, DVec3::new(x, 0.0, 1.99));
            let a = capsule(-short, short, 1.0).primitive_balls(0);
            let b = capsule(lifted - turn, lifted + turn, 1.0).primitive_balls(0);
            let exact = pair_foot(&a, &b).distance;
            let ends = |of: &[Ball; 3], on: &[Ball; 3]| {
                of.iter().map(|e| slab_foot(e.center, on).distance - 1.0).fold(9.0, f64::min)
            };
            let by_balls = ends(&a, &b).min(ends(&b, &a));
            if exact < 0.0 && by_balls > 0.0 {
                worst = worst.max(-exact);
            }
        }
    }
    assert!(worst < 0.011, "lost {worst} deep");
}

/// Number of projections out of a groove until all gaps are above `-1e-6`: the contacts of a step
/// are solved together, as one kept contact, or as all.
fn projections(phi: f64, max_contacts: usize) -> usize {
    // Two thick walls whose normals are `phi` apart, meeting along y at the origin.
    let wall = |sign: f64| {
        let (sin, cos) = (phi / 2.0).sin_cos();
        let normal = DVec3::new(sign * sin, 0.0, cos);
        let along = DVec3::new(sign * -cos, 0.0, sin);
        let foot = -normal * 10.0;
        [(40.0, -80.0), (40.0, 80.0), (-40.0, 0.0)]
            .map(|(s, t)| Ball::new(foot - s * along + DVec3::Y * t, 10.0))
    };
    let balls = [wall(1.0), wall(-1.0)].concat();
    let medial = surface_of(balls, vec![], vec![[0, 1, 2], [3, 4, 5]]);
    let mut p = DVec3::new(0.3, 0.0, -1.0);
    for step in 0..2000 {
        let params = MedialContactParams { max_contacts, ..MedialContactParams::new(0.0) };
        let found = touching(&[p], &medial, params);
        if found.iter().all(|contact| contact.gap > -1e-6) {
            return step;
        }
        // The smallest move that satisfies the one or two contacts.
        p += match found.as_slice() {
            [a] => -a.gap * a.normal,
            [a, b, ..] => {
                let cos = a.normal.dot(b.normal);
                let scale = 1.0 / (1.0 - cos * cos);
                let [x, y] = [(-a.gap + b.gap * cos) * scale, (-b.gap + a.gap * cos) * scale];
                x * a.normal + y * b.normal
            }
            [] => DVec3::ZERO,
        };
    }
    2000
}

/// In a groove whose normals are φ apart, one contact per point converges by |cos φ| per projection:
/// slowly where it is steep. Two are sufficient at once.
#[test]
fn grooves_need_more_than_one_contact() {
    for (degrees, rate, min_projections) in [(120.0_f64, 0.5_f64, 12), (150.0, 0.866, 60)] {
        let phi = degrees.to_radians();
        let one = projections(phi, 1);
        let expected = 1e-6_f64.ln() / rate.ln();
        assert!(one >= min_projections, "{degrees}: {one}");
        assert!(as_f64(one) < 1.5 * expected + 5.0, "{degrees}: {one}, {expected}");
        let all = projections(phi, 3);
        assert!(all <= 2, "{degrees}: {all}");
    }
}

fn as_f64(count: usize) -> f64 {
    f64::from(u32::try_from(count).expect("few steps"))
}

/// A point that moves by s per step through a sheet of half thickness r is first detected on the
/// wrong side, or not at all, with probability max(0, 1 − r/s).
#[test]
fn points_that_move_by_more_than_a_sheet_change_sides() {
    let r = 2.0;
    let medial = sheet(r);
    for s in [1.0, 2.0, 3.0, 3.9] {
        let phases = 400;
        let mut wrong = 0;
        for phase in 0..phases {
            // The first place inside or beyond.
            let above = r + s * (f64::from(phase) + 0.5) / f64::from(phases);
            let after = DVec3::new(1.0, 2.0, above - s);
            let found = touching(&[after], &medial, MedialContactParams::new(0.0));
            wrong += i32::from(!found.first().is_some_and(|c| c.normal.z > 0.0));
        }
        let share = f64::from(wrong) / f64::from(phases);
        assert!((share - (1.0 - r / s).max(0.0)).abs() < 0.01, "s = {s}: {share}");
    }
}

/// A point exactly in the middle has the sheet's own normal.
#[test]
fn a_point_in_the_middle_has_a_normal() {
    let middle = DVec3::new(3.0, -4.0, 0.0);
    let found = touching(&[middle], &sheet(2.0), MedialContactParams::new(0.0));
    assert!((found[0].normal - DVec3::Z).length() < 1e-12, "{found:?}");
    assert!((found[0].gap + 2.0).abs() < 1e-12, "{found:?}");
}

/// Of the balls of a muscle that contain a point, the one with the closest center is not the one that
/// the point is deepest in: its depth is wrong.
#[test]
fn the_deepest_contact_is_kept_not_the_closest() {
    let mesh = muscle();
    let medial = with_balls(&mesh, 40);
    let params =
        MedialContactParams { max_contacts: 1, ..MedialContactParams::new(f64::MAX.sqrt()) };
    let kept = touching(&mesh.positions, &medial, params);
    let mut squares = [0.0; 2];
    for (contact, &p) in kept.iter().zip(&mesh.positions) {
        let closest = (0_u32..)
            .zip(medial.primitives())
            .map(|(i, _)| medial.foot(p, i, FootRule::BareFace))
            .min_by(|a, b| a.ball.center.distance(p).total_cmp(&b.ball.center.distance(p)))
            .unwrap();
        // The points are on the surface: all depth is error.
        squares[0] += contact.gap * contact.gap;
        squares[1] += closest.distance * closest.distance;
    }
    let [deepest, closest] = squares.map(|sum| (sum / as_f64(kept.len())).sqrt());
    assert_eq!(kept.len(), mesh.positions.len());
    assert!(deepest < 0.7 * closest, "{deepest} {closest}");
}

fn halves(list: &[f64]) -> [&[f64]; 2] {
    list.split_at(list.len() / 2).into()
}

/// A binary tree over balls along a line, and the traversals of it.
fn printed_traversal(a: &[f64], b: &[f64], descend_alone: bool) -> usize {
    let hull = |list: &[f64]| [list[0] - 1.0, list[list.len() - 1] + 1.0];
    let ([a_low, a_high], [b_low, b_high]) = (hull(a), hull(b));
    if a_low > b_high || b_low > a_high {
        return 0;
    }
    let (a_parts, b_parts) = (halves(a), halves(b));
    match (a.len(), b.len()) {
        (1, 1) => 1,
        (1, _) if descend_alone => b_parts.iter().map(|b| printed_traversal(a, b, true)).sum(),
        (_, 1) if descend_alone => a_parts.iter().map(|a| printed_traversal(a, b, true)).sum(),
        (1, _) | (_, 1) => 0,
        _ => a_parts
            .iter()
            .flat_map(|a| b_parts.map(|b| printed_traversal(a, b, descend_alone)))
            .sum(),
    }
}

/// A traversal that descends only where both nodes have children loses every pair of trees of unequal
/// depth; ours loses none.
#[test]
fn trees_of_unequal_depth_lose_nothing() {
    let line =
        |count: u32, step: f64| -> Vec<f64> { (0..count).map(|k| f64::from(k) * step).collect() };
    let (few, many) = (line(8, 8.0), line(64, 1.0));
    let slow = few.iter().map(|a| many.iter().filter(|b| (a - **b).abs() <= 2.0).count()).sum();
    assert_eq!(printed_traversal(&few, &many, false), 0, "all are lost");
    assert_eq!(printed_traversal(&few, &many, true), slow);
    let medial = |xs: &[f64]| {
        let balls = xs.iter().map(|&x| Ball::new(DVec3::X * x, 1.0)).collect();
        surface_of(balls, vec![], vec![])
    };
    let (few, many) = (medial(&few), medial(&many));
    assert_eq!(overlaps(&few, &many).len(), slow);
}

/// Fitted to samples of the surface alone, a slab may leave the shape between them; balls held inside
/// keep the excess near the error.
#[test]
fn a_one_sided_fit_extends_outside() {
    // A bent sheet: a flat slab between far balls leaves it in the middle.
    let mesh = shapes::torus(30.0, 8.0, [40, 16])
        .mapped(|p| DVec3::new(p.x, p.y, 0.35 * p.z + 0.0004 * p.x * p.x * p.x));
    let fit = |inscribed_weight: f64| {
        let params = MedialParams { inscribed_weight, ..MedialParams::balls(24) };
        generated(&mesh, &params).unwrap().deviation
    };
    let (one_sided, two_sided) = (fit(0.0), fit(MedialParams::balls(1).inscribed_weight));
    let over = |d: &Deviation| d.medial_to_surface.upper;
    assert!(over(&one_sided) > 1.5 * over(&two_sided), "{one_sided:?} {two_sided:?}");
    assert!(two_sided.rms < 1.3 * one_sided.rms, "{one_sided:?} {two_sided:?}");
}

/// An impulse of friction J at the medial point P̄ instead of the surface leaves an angular momentum of
/// offset × J; at the surface none.
#[test]
fn friction_acts_at_the_surface() {
    let r = 2.0;
    let p = DVec3::new(3.0, 4.0, r);
    let contact = touching(&[p], &sheet(r), MedialContactParams::new(0.1))[0];
    let j = DVec3::X * 5.0;
    let medial = sheet(r);
    let at = |k: u32| if k == 0 { p } else { medial.balls()[k as usize - 1000].center };
    let lever = contact.separation(at);
    assert!((lever.cross(j).length() - contact.offset * j.length()).abs() < 1e-12);
    let on_surface = lever + contact.offset * contact.normal;
    assert!(on_surface.cross(j).length() < 1e-12, "{on_surface}");
}

/// Where one ball contains the other, the cone is the larger ball, and no value is NaN.
#[test]
fn a_contained_ball_has_no_effect() {
    let (small, big) = (Ball::new(DVec3::ZERO, 1.0), Ball::new(DVec3::X, 2.5));
    for third in [small, big, Ball::new(DVec3::Y * 0.2, 0.1)] {
        for p in [DVec3::ZERO, DVec3::X, DVec3::new(-4.0, 3.0, 1.0), DVec3::Y * 9.0] {
            let found = slab_foot(p, &[small, big, third]);
            assert!((found.distance - big.distance(p)).abs() < 1e-12, "{found:?}");
            assert!(found.weights.iter().all(|w| w.is_finite()), "{found:?}");
        }
    }
    let just = Ball::new(DVec3::X, 2.0);
    let found = slab_foot(DVec3::new(-4.0, 3.0, 1.0), &[small, just, just]);
    assert!(found.distance.is_finite() && found.weights[1] > 0.999, "{found:?}");
}

/// A cube whose edge from corner 3 to corner 7 is closed by faces without area: beside them, normals
/// do not tell inside from outside.
fn cube_with_needles() -> Mesh {
    let corners: [DVec3; 8] = std::array::from_fn(|k| {
        DVec3::from_array([k & 1, k >> 1 & 1, k >> 2].map(|bit| if bit > 0 { 5.0 } else { -5.0 }))
    });
    let on_edge = [DVec3::new(5.0, 5.0, -1.0), DVec3::new(5.0, 5.0, 1.0)];
    let needles = [[3, 9, 8], [3, 7, 9]];
    let divided = [[5, 3, 8], [5, 8, 9], [5, 9, 7]];
    let whole = [[0, 2, 3], [0, 3, 1], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4], [2, 6, 7]];
    let sides = [[2, 7, 3], [0, 4, 6], [0, 6, 2], [1, 3, 5]];
    let faces = [&needles[..], &divided[..], &whole[..], &sides[..]].concat();
    Mesh { positions: [&corners[..], &on_edge[..]].concat(), faces }
}

/// The cube as it is, turned by a rounded angle, and far from the origin of coordinates, where the
/// needles are as wide as the rounding there; and that rounding.
fn cubes_with_needles() -> Vec<(Mesh, f64)> {
    let cube = cube_with_needles();
    let turned = cube.clone().rotated(DVec3::new(1.0, 2.0, 3.0), 1.0 / 6.0);
    let mut cubes = vec![(cube, 0.0), (turned.clone(), 0.0)];
    let mut random = Random(11);
    for _ in 0..2 {
        cubes.push((turned.clone().translated(vector(&mut random, 1e6)), 1e-8));
    }
    cubes
}

/// Points of the edge with needles, and how far inward from there.
const BESIDE_NEEDLES: [(f64, f64); 4] = [(0.4, -0.5), (0.4, 0.5), (0.25, -0.5), (0.55, -0.2)];

/// Returns a point beside the edge with needles, towards the middle of the cube or away from it.
fn beside_needles(cube: &Mesh, along: f64, inward: f64) -> DVec3 {
    let [from, to] = [3, 7].map(|corner: usize| cube.positions[corner]);
    let middle = cube.bounds().center();
    middle + (from.lerp(to, along) - middle) * (1.0 - inward / 5.0)
}

#[test]
fn balls_outside_beside_needles_are_measured() {
    for (cube, rounding) in cubes_with_needles() {
        let surface = cube.surface();
        let x = surface.positions(&cube.positions).unwrap();
        for (along, inward) in BESIDE_NEEDLES {
            let center = beside_needles(&cube, along, inward);
            let ball = surface_of(vec![Ball::new(center, 1.5)], vec![], vec![]);
            let measured = Deviation::measure(&ball, &surface, x).unwrap().medial_to_surface;
            let foot = reference::closest(&cube, center).unwrap();
            let excess = 1.5 - foot.distance * inward.signum();
            let range = measured.lower - rounding..=measured.upper + rounding;
            assert!(range.contains(&excess), "{measured:?} {excess}");
        }
    }
}

#[test]
fn vertices_beside_needles_are_on_their_side() {
    for (cube, rounding) in cubes_with_needles() {
        let center = cube.bounds().center();
        let around = surface_of(vec![Ball::new(center, 9.0)], vec![], vec![]);
        let own = Detected::from_medial(&cube, around, 0.0, 4);
        for (along, inward) in BESIDE_NEEDLES {
            let p = beside_needles(&cube, along, inward);
            let body = shapes::tetrahedron(1.0).translated(p);
            let body = body.clone().translated(p - body.positions[0]);
            let body = Detected::from_medial(
                &body,
                surface_of(vec![Ball::new(p, 0.0)], vec![], vec![]),
                0.0,
                0,
            );

            let (mut near, scratch) = (Vec::new(), &mut MedialScratch::default());
            own.detector.near_vertices(&body.body(), &own.body(), 9.0, scratch, &mut near);
            let gap = near.iter().find(|near| near.vertex == 0).expect("in the ball").gap;
            let foot = reference::closest(&cube, p).unwrap();
            let expected = -foot.distance * inward.signum();
            assert!((gap - expected).abs() < 1e-9 + rounding, "{gap} {inward}");
        }
    }
}
