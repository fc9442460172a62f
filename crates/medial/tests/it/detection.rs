//! Contacts of points and primitives beside brute force over all of them.

use fixtures::random::Random;
use glam::DVec3;
use kdop::{Extents, Leaves, Tree, Workspace};
use medial::{
    Ball, FootRule, MedialBounds, MedialContactParams, ParticleOffsets, PrimitiveTree, QueryPoints,
    pair_foot, point_contacts, primitive_contacts,
};

use crate::support::{brute_force_distance, number, one_in, random_medial, vector};

/// Coordinates among which radii of up to three are far apart.
const WIDE: f64 = 20.0;

#[test]
fn points_and_balls_meet_what_brute_force_meets() {
    let mut random = Random(5);
    let random = &mut random;
    for _ in 0..4000 {
        // Far apart, or most points in several primitives at once.
        let size = if one_in(random, 2) { WIDE } else { 4.0 };
        let medial = random_medial(random, size);
        let points: Vec<DVec3> = (0..=random.below(20)).map(|_| vector(random, size)).collect();
        let radii: Vec<f64> = points.iter().map(|p| p.x.abs() / 10.0).collect();
        let radii = one_in(random, 2).then_some(&radii[..]);
        let margin = number(random, 0.0, 2.0);
        let rule = if one_in(random, 2) { FootRule::Exact } else { FootRule::BareFace };
        let params = MedialContactParams { margin, rule, max_contacts: 1 + random.below(3) };

        let extents = radii.map(|radii| Extents::Balls { centers: &points, radii });
        let tree = match extents {
            Some(extents) => Tree::build_from(Leaves::Points, extents).unwrap(),
            None => Tree::build(Leaves::Points, &points).unwrap(),
        };
        let query = QueryPoints { tree: &tree, points: &points, radii };
        let on = MedialBounds { medial: &medial, tree: &PrimitiveTree::new(&medial).unwrap() };
        let particles = ParticleOffsets { first_point: 100, first_ball: 200 };
        let workspace = &mut Workspace::default();
        let (found, _) = point_contacts(&query, on, &params, particles, workspace);

        let at = |k: u32| match k.checked_sub(200) {
            Some(ball) => medial.balls()[ball as usize].center,
            None => points[k as usize - 100],
        };
        for contact in &found {
            assert!(contact.identity_error(at) < 1e-11, "{contact:?}");
            assert!((contact.normal.length() - 1.0).abs() < 1e-12 && contact.gap <= margin);
        }
        for (k, &p) in (100_u32..).zip(&points) {
            let mut least = f64::INFINITY;
            for (primitive, _) in (0_u32..).zip(medial.primitives()) {
                least = least.min(medial.foot(p, primitive, rule).distance);
            }
            least -= radii.map_or(0.0, |radii| radii[k as usize - 100]);

            let is_of_point = |c: &&surface::Contact| c.stencil.terms()[0].particle == k;
            let of_point: Vec<_> = found.iter().filter(is_of_point).collect();
            assert!(of_point.len() <= params.max_contacts);
            assert!(of_point.is_sorted_by(|a, b| a.gap <= b.gap), "{of_point:?}");
            match of_point.first() {
                Some(contact) => {
                    assert!((contact.gap - least).abs() < 1e-11, "{least} {contact:?}");
                }
                None => assert!(least > margin, "point {k} at {least} is lost"),
            }
        }
    }
}

#[test]
fn primitives_meet_what_brute_force_meets() {
    let mut random = Random(6);
    let random = &mut random;
    for _ in 0..1000 {
        let (a, b) = (random_medial(random, WIDE), random_medial(random, WIDE));
        let margin = number(random, 0.0, 2.0);
        let [of_a, of_b] = [&a, &b].map(|medial| PrimitiveTree::new(medial).unwrap());
        let on_a = MedialBounds { medial: &a, tree: &of_a };
        let on_b = MedialBounds { medial: &b, tree: &of_b };
        let (found, counts) = primitive_contacts(on_a, on_b, margin, &mut Workspace::default());

        let mut expected = Vec::new();
        for (i, _) in (0_u32..).zip(a.primitives()) {
            for (j, _) in (0_u32..).zip(b.primitives()) {
                let distance = pair_foot(&a.primitive_balls(i), &b.primitive_balls(j)).distance;
                if distance <= margin {
                    expected.push([i, j]);
                }
            }
        }
        assert_eq!(found.iter().map(|c| c.primitives).collect::<Vec<_>>(), expected);
        assert!(usize::try_from(counts.leaf_tests).unwrap() >= found.len());

        for contact in &found {
            let particles = ParticleOffsets { first_point: 0, first_ball: 100 };
            let mut separation = DVec3::ZERO;
            for term in contact.terms(&a, &b, particles) {
                let center = match term.particle.checked_sub(100) {
                    Some(ball) => b.balls()[ball as usize].center,
                    None => a.balls()[term.particle as usize].center,
                };
                separation += term.weight * center;
            }
            let error = contact.gap + contact.offset + separation.dot(contact.normal);
            assert!(error.abs() < 1e-11, "{error} {contact:?}");
        }
    }
}

#[test]
fn a_refitted_tree_finds_moved_balls() {
    let mut random = Random(7);
    let random = &mut random;
    for _ in 0..1000 {
        let mut medial = random_medial(random, WIDE);
        let mut tree = PrimitiveTree::new(&medial).unwrap();
        let mut moved = Vec::new();
        for ball in medial.balls() {
            moved.push(Ball::new(vector(random, WIDE), ball.radius * 1.5));
        }
        medial.set_balls(&moved).unwrap();
        tree.refit(&medial).unwrap();
        tree.tree().validate().unwrap();

        let p = vector(random, WIDE);
        let slow = brute_force_distance(&medial, p);
        let fast = tree.nearest(&medial, p, &mut Workspace::default()).foot.distance;
        assert!((fast - slow).abs() < 1e-15, "{fast} {slow}");
    }
}
