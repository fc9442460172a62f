//! Exact distances beside dense sampling of the weights, and planted feet.

use arbitrary::{Result, Unstructured};
use arbtest::arbtest;
use glam::DVec3;
use medial::{Ball, FootRule, cone_foot, foot, pair_foot, slab_foot};

fn coordinate(u: &mut Unstructured<'_>) -> Result<f64> {
    Ok(f64::from(u.int_in_range(-2000_i32..=2000)?) / 100.0)
}

fn point(u: &mut Unstructured<'_>) -> Result<DVec3> {
    Ok(DVec3::new(coordinate(u)?, coordinate(u)?, coordinate(u)?))
}

fn ball(u: &mut Unstructured<'_>) -> Result<Ball> {
    Ok(Ball::new(point(u)?, f64::from(u.int_in_range(0_i32..=1000)?) / 100.0))
}

/// A slab, often with balls that coincide, lie on a line or swallow others.
fn slab(u: &mut Unstructured<'_>) -> Result<[Ball; 3]> {
    let [a, b, mut c] = [ball(u)?, ball(u)?, ball(u)?];
    match u.int_in_range(0..=7)? {
        0 => c = b,
        1 => c.center = a.center.lerp(b.center, 0.3),
        2 => c.center = 2.0 * b.center - a.center,
        3 => return Ok([a; 3]),
        4 => c.center = b.center + 1e-9 * c.center,
        _ => {}
    }
    Ok([a, b, c])
}

const STEPS: i32 = 60;

/// Weights on a regular grid over the slab.
fn grid() -> impl Iterator<Item = [f64; 3]> {
    (0..=STEPS).flat_map(|i| {
        (0..=STEPS - i).map(move |j| {
            let [b, c] = [i, j].map(|k| f64::from(k) / f64::from(STEPS));
            [1.0 - b - c, b, c]
        })
    })
}

/// The most that f can fall between neighboring grid weights.
fn grid_error(balls: &[Ball; 3]) -> f64 {
    let side = |i: usize, j: usize| {
        balls[i].center.distance(balls[j].center) + (balls[i].radius - balls[j].radius).abs()
    };
    side(0, 1).max(side(1, 2)).max(side(2, 0)) / f64::from(STEPS)
}

fn is_on_simplex(weights: [f64; 3]) -> bool {
    weights.iter().all(|&w| w >= 0.0) && (weights.iter().sum::<f64>() - 1.0).abs() < 1e-14
}

#[test]
fn slab_foot_is_the_least_over_all_balls() {
    arbtest(|u| {
        let (p, balls) = (point(u)?, slab(u)?);
        let exact = slab_foot(p, &balls);
        assert!(is_on_simplex(exact.weights), "{exact:?}");
        let sampled = grid()
            .map(|weights| Ball::interpolate(&balls, weights).distance(p))
            .fold(f64::INFINITY, f64::min);
        assert!(exact.distance <= sampled + 1e-12, "{exact:?} above {sampled}");
        assert!(exact.distance >= sampled - grid_error(&balls), "{exact:?} below {sampled}");
        for [i, j] in [[0, 1], [1, 2], [2, 0]] {
            let side = cone_foot(p, balls[i], balls[j]).distance;
            assert!(exact.distance <= side + 1e-12, "{exact:?} above {side} of {i}, {j}");
        }
        let attained = Ball::interpolate(&balls, exact.weights).distance(p);
        assert!((attained - exact.distance).abs() < 1e-12, "{exact:?} is not attained");
        Ok(())
    });
}

#[test]
fn cone_foot_is_the_least_over_all_balls() {
    arbtest(|u| {
        let (p, a, b) = (point(u)?, ball(u)?, ball(u)?);
        let exact = cone_foot(p, a, b);
        let sampled = (0..=4000)
            .map(|k| {
                let t = f64::from(k) / 4000.0;
                Ball::interpolate(&[a, b, b], [1.0 - t, t, 0.0]).distance(p)
            })
            .fold(f64::INFINITY, f64::min);
        assert!(exact.distance <= sampled + 1e-12, "{exact:?} above {sampled}");
        assert!(exact.distance >= sampled - 0.02, "{exact:?} below {sampled}");
        Ok(())
    });
}

/// A point at height h over a ball inside a slab, along the direction in which
/// that ball is stationary, has that ball as its foot.
#[test]
fn slab_foot_finds_a_planted_foot() {
    arbtest(|u| {
        let balls = [ball(u)?, ball(u)?, ball(u)?];
        let [a, b, c] = balls.map(|ball| ball.center);
        let normal = (b - a).cross(c - a);
        if normal.length() < 1.0 {
            return Ok(());
        }
        // m in the plane with m·(b−a) = r_b−r_a and m·(c−a) = r_c−r_a.
        let n = normal / normal.length_squared();
        let [grow_b, grow_c] = [1, 2].map(|k| balls[k].radius - balls[0].radius);
        let m = grow_b * (c - a).cross(n) + grow_c * n.cross(b - a);
        if m.length_squared() > 0.99 {
            return Ok(());
        }
        let rise = (1.0 - m.length_squared()).sqrt() * normal.normalize();
        let share = f64::from(u.int_in_range(0_u8..=100)?) / 100.0;
        let other = (1.0 - share) * f64::from(u.int_in_range(0_u8..=100)?) / 100.0;
        let weights = [1.0 - share - other, share, other];
        let planted = Ball::interpolate(&balls, weights);
        let height = f64::from(u.int_in_range(1_u16..=3000)?) / 100.0;
        let side = if u.arbitrary()? { rise } else { -rise };
        // Stationary where n·(side of the slab) is less the growth: n = rise − m.
        let p = planted.center + height * (side - m);
        let found = slab_foot(p, &balls);
        assert!((found.distance - (height - planted.radius)).abs() < 1e-10, "{found:?}");
        assert!(found.ball.center.distance(planted.center) < 1e-6, "{found:?} not {planted:?}");
        Ok(())
    });
}

#[test]
fn pair_foot_is_the_least_over_all_pairs() {
    arbtest(|u| {
        let (a, mut b) = (slab(u)?, slab(u)?);
        if u.ratio(1, 4)? {
            // Parallel, or in one plane.
            let by = if u.arbitrary()? { DVec3::ZERO } else { point(u)? };
            b = a.map(|ball| Ball::new(ball.center + by, ball.radius));
        }
        let exact = pair_foot(&a, &b);
        assert!(is_on_simplex(exact.weights_a) && is_on_simplex(exact.weights_b), "{exact:?}");
        // The other slab's exact foot halves the dimensions to sample.
        let sampled = grid()
            .map(|weights| {
                let ball = Ball::interpolate(&a, weights);
                slab_foot(ball.center, &b).distance - ball.radius
            })
            .fold(f64::INFINITY, f64::min);
        assert!(exact.distance <= sampled + 1e-11, "{exact:?} above {sampled}");
        assert!(exact.distance >= sampled - grid_error(&a), "{exact:?} below {sampled}");
        let mirrored = pair_foot(&b, &a);
        assert!((mirrored.distance - exact.distance).abs() < 1e-11, "{mirrored:?} {exact:?}");
        Ok(())
    });
}

/// Descends by ever smaller random steps from the answer: nothing is lower.
#[test]
fn pair_foot_is_locally_least_to_rounding() {
    arbtest(|u| {
        let (a, b) = (slab(u)?, slab(u)?);
        let exact = pair_foot(&a, &b);
        for exponent in 1..=10 {
            let size = 0.1_f64.powi(exponent);
            let step = |u: &mut Unstructured<'_>, weights: [f64; 3]| -> Result<[f64; 3]> {
                let mut moved = weights;
                for weight in &mut moved {
                    *weight = (*weight + size * coordinate(u)? / 20.0).max(0.0);
                }
                let sum: f64 = moved.iter().sum();
                Ok(if sum > 0.0 { moved.map(|w| w / sum) } else { weights })
            };
            let (v, w) = (step(u, exact.weights_a)?, step(u, exact.weights_b)?);
            let (near_a, near_b) = (Ball::interpolate(&a, v), Ball::interpolate(&b, w));
            let value = near_a.center.distance(near_b.center) - near_a.radius - near_b.radius;
            assert!(value >= exact.distance - 1e-11, "{value} below {exact:?}");
        }
        Ok(())
    });
}

#[test]
fn the_bare_face_never_comes_nearer() {
    arbtest(|u| {
        let (p, balls) = (point(u)?, slab(u)?);
        let exact = foot(p, &balls, FootRule::Exact);
        let bare = foot(p, &balls, FootRule::BareFace);
        assert!(bare.distance >= exact.distance - 1e-10, "{bare:?} nearer than {exact:?}");
        Ok(())
    });
}
