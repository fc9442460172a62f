//! Validation, bounds and text of medial surfaces.

use fixtures::random::Random;
use glam::DVec3;
use medial::{Ball, MedialError, MedialSurface};

use crate::support::random_medial;

fn balls(count: u32) -> Vec<Ball> {
    (0..count).map(|k| Ball::new(DVec3::X * f64::from(k), 0.5 + 0.1 * f64::from(k))).collect()
}

#[test]
fn invalid_balls_and_primitives_are_refused() {
    assert_eq!(MedialSurface::new(vec![], vec![], vec![]), Err(MedialError::Empty));
    let out = MedialError::BallOutOfRange { kind: "slab", index: 1, ball: 9, balls: 4 };
    assert_eq!(MedialSurface::new(balls(4), vec![], vec![[0, 1, 2], [0, 9, 1]]), Err(out));
    let twice = MedialError::RepeatedBall { kind: "cone", index: 0, ball: 2 };
    assert_eq!(MedialSurface::new(balls(4), vec![[2, 2]], vec![]), Err(twice));
    for radius in [-1e-9, f64::NAN, f64::INFINITY] {
        let mut bad = balls(3);
        bad[1].radius = radius;
        let error = MedialSurface::new(bad, vec![], vec![]).unwrap_err();
        assert!(matches!(error, MedialError::InvalidBall { ball: 1, .. }), "{error}");
    }
    let mut medial = MedialSurface::new(balls(3), vec![], vec![[0, 1, 2]]).unwrap();
    let before = medial.clone();
    let error = medial.set_centers(&[DVec3::ZERO, DVec3::NAN, DVec3::X]).unwrap_err();
    assert!(matches!(error, MedialError::InvalidBall { ball: 1, .. }), "{error}");
    assert_eq!(medial.set_centers(&[]), Err(MedialError::BallCount { expected: 3, got: 0 }));
    assert_eq!(medial, before, "a refusal changes nothing");
}

#[test]
fn bounds_contain_every_ball() {
    let medial = MedialSurface::new(balls(5), vec![[3, 4]], vec![[0, 1, 2]]).unwrap();
    let bounds = medial.bounds();
    for ball in medial.balls() {
        assert!((ball.center - ball.radius).cmpge(bounds.min).all(), "{ball:?}");
        assert!((ball.center + ball.radius).cmple(bounds.max).all(), "{ball:?}");
    }
    assert!((bounds.max.x - 4.9).abs() < 1e-15);
}

/// Cones come back in ascending order, without those that are sides of slabs.
#[test]
fn text_comes_back_to_the_bit() {
    let mut random = Random(14);
    for _ in 0..1000 {
        let written = random_medial(&mut random, 1e3);
        let read = MedialSurface::from_ma(&written.to_ma()).unwrap();
        assert_eq!(read.balls(), written.balls());
        assert_eq!(read.slabs(), written.slabs());

        let is_side = |[a, b]: [u32; 2]| {
            written.slabs().iter().any(|slab| slab.contains(&a) && slab.contains(&b))
        };
        let mut cones: Vec<[u32; 2]> =
            written.cones().map(|[a, b]| [a.min(b), a.max(b)]).filter(|&c| !is_side(c)).collect();
        cones.sort_unstable();
        cones.dedup();
        assert_eq!(read.cones().collect::<Vec<_>>(), cones);
        assert_eq!(MedialSurface::from_ma(&read.to_ma()).as_ref(), Ok(&read));
    }
}

#[test]
fn invalid_text_is_reported_by_its_line() {
    let cases = [
        ("", 1, "the text is empty"),
        ("1 0\n", 1, "a number is missing"),
        ("1 0 0\nv 0 0 0\n", 2, "a number is missing"),
        ("1 0 0\nv 0 0 0 1 7\n", 2, "there are more numbers than expected"),
        ("1 0 0\n\n# a comment\nw 0 0 0 1\n", 4, "expected a line of v, e or f"),
        ("2 1 0\nv 0 0 0 1\nv 1 0 0 1\ne 0 x\n", 4, "a word is not a number of its kind"),
        ("2 0 0\nv 0 0 0 1\n", 2, "the count of vertices is not that of the first line"),
    ];
    for (text, line, reason) in cases {
        let expected = MedialError::Text { line, reason };
        assert_eq!(MedialSurface::from_ma(text), Err(expected), "{text:?}");
    }
    let nan = MedialSurface::from_ma("1 0 0\nv 0 NaN 0 1\n").unwrap_err();
    assert!(matches!(nan, MedialError::InvalidBall { ball: 0, .. }), "{nan}");
}
