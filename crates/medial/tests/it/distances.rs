//! Exact distances beside dense sampling of the weights, and planted feet.

use fixtures::random::Random;
use glam::DVec3;
use medial::{Ball, FootRule, cone_foot, foot, pair_foot, slab_foot};

use crate::support::{grid_weights, number, one_in, slab, vector};

/// Subdivisions of the sides of a sampled slab.
const STEPS: u32 = 60;

/// Upper bound on the difference of f between neighboring weights of the grid.
fn grid_error(balls: &[Ball; 3]) -> f64 {
    let side = |i: usize, j: usize| {
        balls[i].center.distance(balls[j].center) + (balls[i].radius - balls[j].radius).abs()
    };
    side(0, 1).max(side(1, 2)).max(side(2, 0)) / f64::from(STEPS)
}

fn is_on_simplex(weights: [f64; 3]) -> bool {
    weights.iter().all(|&w| w >= 0.0) && (weights.iter().sum::<f64>() - 1.0).abs() < 1e-14
}

fn ball(random: &mut Random) -> Ball {
    Ball::new(vector(random, 20.0), number(random, 0.0, 10.0))
}

#[test]
fn slab_foot_is_the_minimum_over_all_balls() {
    let mut random = Random(8);
    for _ in 0..2000 {
        let (p, balls) = (vector(&mut random, 20.0), slab(&mut random));
        let exact = slab_foot(p, &balls);
        assert!(is_on_simplex(exact.weights), "{exact:?}");
        let at = |weights| Ball::interpolate(&balls, weights).distance(p);
        let sampled = grid_weights(STEPS).map(at).fold(f64::INFINITY, f64::min);
        assert!(exact.distance <= sampled + 1e-12, "{exact:?} above {sampled}");
        assert!(exact.distance >= sampled - grid_error(&balls), "{exact:?} below {sampled}");
        for [i, j] in [[0, 1], [1, 2], [2, 0]] {
            let side = cone_foot(p, balls[i], balls[j]).distance;
            assert!(exact.distance <= side + 1e-12, "{exact:?} above {side} of {i}, {j}");
        }
        let attained = at(exact.weights);
        assert!((attained - exact.distance).abs() < 1e-12, "{exact:?} is not attained");
    }
}

#[test]
fn cone_foot_is_the_minimum_over_all_balls() {
    let mut random = Random(9);
    for _ in 0..1000 {
        let p = vector(&mut random, 20.0);
        let (a, b) = (ball(&mut random), ball(&mut random));
        let exact = cone_foot(p, a, b);
        let mut sampled = f64::INFINITY;
        for k in 0..=4000_u32 {
            let t = f64::from(k) / 4000.0;
            let between = Ball::interpolate(&[a, b, b], [1.0 - t, t, 0.0]);
            sampled = sampled.min(between.distance(p));
        }
        assert!(exact.distance <= sampled + 1e-12, "{exact:?} above {sampled}");
        assert!(exact.distance >= sampled - 0.02, "{exact:?} below {sampled}");
    }
}

/// A point at height h over a ball inside a slab, along the direction in which that ball is
/// stationary, has that ball as its foot.
#[test]
fn slab_foot_finds_a_planted_foot() {
    let mut random = Random(10);
    let mut planted_feet = 0;
    for _ in 0..5000 {
        let balls = [0; 3].map(|_| ball(&mut random));
        let [a, b, c] = balls.map(|ball| ball.center);
        let normal = (b - a).cross(c - a);
        // m in the plane with m·(b−a) = r_b−r_a and m·(c−a) = r_c−r_a.
        let n = normal / normal.length_squared();
        let [grow_b, grow_c] = [1, 2].map(|k| balls[k].radius - balls[0].radius);
        let m = grow_b * (c - a).cross(n) + grow_c * n.cross(b - a);
        if normal.length() < 1.0 || m.length_squared() > 0.99 {
            continue;
        }

        // Stationary where the normal is that of the plane that touches the balls.
        let rise = (1.0 - m.length_squared()).sqrt() * normal.normalize();
        let planted = Ball::interpolate(&balls, random.weights());
        let height = number(&mut random, 0.01, 30.0);
        let side = if one_in(&mut random, 2) { rise } else { -rise };
        let p = planted.center + height * (side - m);
        let found = slab_foot(p, &balls);
        assert!((found.distance - (height - planted.radius)).abs() < 1e-10, "{found:?}");
        assert!(found.ball.center.distance(planted.center) < 1e-6, "{found:?} not {planted:?}");
        planted_feet += 1;
    }
    assert!(planted_feet > 1000, "{planted_feet}");
}

#[test]
fn pair_foot_is_the_minimum_over_all_pairs() {
    let mut random = Random(11);
    for _ in 0..1000 {
        let (a, mut b) = (slab(&mut random), slab(&mut random));
        if one_in(&mut random, 4) {
            // Parallel, or in one plane.
            let is_same = one_in(&mut random, 2);
            let by = if is_same { DVec3::ZERO } else { vector(&mut random, 20.0) };
            b = a.map(|ball| Ball::new(ball.center + by, ball.radius));
        }
        let exact = pair_foot(&a, &b);
        assert!(is_on_simplex(exact.weights_a) && is_on_simplex(exact.weights_b), "{exact:?}");

        // The exact foot on the other slab halves the dimensions to sample.
        let at = |weights| {
            let ball = Ball::interpolate(&a, weights);
            slab_foot(ball.center, &b).distance - ball.radius
        };
        let sampled = grid_weights(STEPS).map(at).fold(f64::INFINITY, f64::min);
        assert!(exact.distance <= sampled + 1e-11, "{exact:?} above {sampled}");
        assert!(exact.distance >= sampled - grid_error(&a), "{exact:?} below {sampled}");
        let mirrored = pair_foot(&b, &a);
        assert!((mirrored.distance - exact.distance).abs() < 1e-11, "{mirrored:?} {exact:?}");
    }
}

/// Takes ever smaller random steps from the answer: none is lower.
#[test]
fn pair_foot_is_a_local_minimum_to_rounding() {
    let mut random = Random(12);
    for _ in 0..5000 {
        let (a, b) = (slab(&mut random), slab(&mut random));
        let exact = pair_foot(&a, &b);
        for exponent in 1..=10 {
            let size = 0.1_f64.powi(exponent);
            let v = stepped(&mut random, exact.weights_a, size);
            let w = stepped(&mut random, exact.weights_b, size);
            let (near_a, near_b) = (Ball::interpolate(&a, v), Ball::interpolate(&b, w));
            let value = near_a.center.distance(near_b.center) - near_a.radius - near_b.radius;
            assert!(value >= exact.distance - 1e-11, "{value} below {exact:?}");
        }
    }
}

/// Weights a random step away.
fn stepped(random: &mut Random, weights: [f64; 3], size: f64) -> [f64; 3] {
    let moved = weights.map(|weight| (weight + size * number(random, -1.0, 1.0)).max(0.0));
    let sum: f64 = moved.iter().sum();
    if sum > 0.0 { moved.map(|weight| weight / sum) } else { weights }
}

#[test]
fn the_bare_face_is_never_nearer() {
    let mut random = Random(13);
    for _ in 0..20_000 {
        let (p, balls) = (vector(&mut random, 20.0), slab(&mut random));
        let exact = foot(p, &balls, FootRule::Exact);
        let bare = foot(p, &balls, FootRule::BareFace);
        assert!(bare.distance >= exact.distance - 1e-10, "{bare:?} nearer than {exact:?}");
    }
}
