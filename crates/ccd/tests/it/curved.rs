//! First contacts of points that turn about an axis, beside closed forms and dense samples.

use std::f64::consts::PI;

use arbitrary::Unstructured;
use ccd::{CcdParams, PathBounds, Primitives, chord_deviation, first_contact_on_paths};
use glam::{DQuat, DVec3};

use crate::random::{check, point};

/// Steps of the random search.
const STEPS: u64 = 20_000;

/// Share of steps whose contact may be earlier than [`EARLINESS`].
const EARLY: f64 = 0.01;

/// Earliness of most contacts, as a share of the step.
const EARLINESS: f64 = 1e-6;

fn share(u: &mut Unstructured<'_>) -> arbitrary::Result<f64> {
    Ok(f64::from(u.int_in_range(0..=1_000_000)?) / 1e6)
}

/// A vertex turns about z through an origin anywhere, and meets the plane at a distance from the
/// axis where the cosine of its angle says. Arms of 1 to 1000, steps of 0.1 to 90 degrees.
#[test]
#[expect(clippy::print_stdout, reason = "the test prints what it measures")]
fn a_vertex_on_an_arm_meets_a_plane_at_the_angle_of_its_cosine() {
    let [early, met, certain] = [0, 0, 0].map(std::cell::Cell::new);
    check(STEPS, |u| {
        let arm = 10.0_f64.powf(3.0 * share(u)?);
        let step = 0.1_f64.to_radians() * 900.0_f64.powf(share(u)?);
        let center = point(u, 1000.0)?;
        let from = -PI + share(u)? * PI;

        // The plane is met at an angle within one and a half steps of the start, approached from
        // outside: the cosine rises as the angle goes to zero.
        let angle = from + 1.5 * share(u)? * step;
        if angle > -1e-3 {
            return Ok(());
        }
        let plane = arm * angle.cos();
        let frame = DQuat::from_axis_angle(point(u, 1.0)?.normalize_or(DVec3::X), share(u)?);
        let face = [[0.0, -9.0], [9.0, 9.0], [-9.0, 9.0]]
            .map(|[y, z]| center + frame * DVec3::new(plane, arm * y, arm * z));
        let at = |time: f64| {
            let (sin, cos) = (from + time * step).sin_cos();
            [center + frame * DVec3::new(arm * cos, arm * sin, 0.0), face[0], face[1], face[2]]
        };
        let rounding = 64.0 * f64::EPSILON * (2000.0 + 20.0 * arm);
        let bounds = PathBounds { bend: arm * step * step * (1.0 + 1e-12), rounding };
        let params = CcdParams::DEFAULT;
        let found = first_contact_on_paths(Primitives::VertexFace, at, bounds, [0.0, 1.0], &params)
            .expect("finite points");

        let expected = (angle - from) / step;
        if expected > 1.0 + 1e-9 {
            // Near the end of the step, the plane is within the deviation of a piece.
            let is_early = found.is_some_and(|found| found.lo < 1.0 - 1e-4 / step.min(1.0));
            assert!(!is_early || expected < 1.001, "{found:?} before {expected}");
            return Ok(());
        }
        let found = found.unwrap_or_else(|| panic!("missed: {expected} of {step} at {arm}"));
        assert!(found.lo <= expected + 1e-12, "late: {} after {expected}", found.lo);
        met.set(met.get() + 1);
        if found.is_certain() {
            certain.set(certain.get() + 1);
            assert!(expected <= found.hi + 1e-12, "{expected} is not by {}", found.hi);
        }
        if found.lo < expected - EARLINESS {
            early.set(early.get() + 1);
        }
        Ok(())
    });
    println!(
        "measured: contacts on arcs, early by more than 1e-6 | {} | {}",
        early.get(),
        met.get()
    );
    assert!(met.get() > STEPS / 4, "few of the steps meet: {}", met.get());
    let count = met.get();
    #[expect(clippy::cast_precision_loss, reason = "small counts")]
    let (early, met) = (early.get() as f64, met.get() as f64);
    assert!(early <= EARLY * met, "{early} of {met} are early");
    assert!(10 * certain.get() > 9 * count, "{} of {count} are certain", certain.get());
}

/// Both edges turn about skew axes. Between dense samples of the distance nothing may come near
/// before the reported time.
#[test]
fn edges_that_turn_about_skew_axes_are_never_late() {
    const SAMPLES: u32 = 2_000;
    let met = std::cell::Cell::new(0);
    check(400, |u| {
        let mut turns = Vec::new();
        for _ in 0..2 {
            let axis = point(u, 1.0)?.normalize_or(DVec3::Z);
            turns.push((point(u, 5.0)?, axis, 2.0 * share(u)?));
        }
        let ends = [point(u, 9.0)?, point(u, 9.0)?, point(u, 9.0)?, point(u, 9.0)?];
        let at = |time: f64| -> [DVec3; 4] {
            std::array::from_fn(|k| {
                let (center, axis, angle) = turns[k / 2];
                center + DQuat::from_axis_angle(axis, time * angle) * (ends[k] - center)
            })
        };
        let bend = |k: usize| {
            let (center, axis, angle) = turns[k / 2];
            (ends[k] - center).cross(axis).length() * angle * angle * (1.0 + 1e-12)
        };
        let bends = bend(0).max(bend(1)) + bend(2).max(bend(3));
        let bounds = PathBounds { bend: bends, rounding: 1e-12 };
        let params = CcdParams::DEFAULT;
        let found = first_contact_on_paths(Primitives::EdgeEdge, at, bounds, [0.0, 1.0], &params)
            .expect("finite points");

        // A change of side between samples, with the lines crossing within both edges, is contact.
        let free_until = found.map_or(1.0, |found| found.lo);
        met.set(met.get() + u64::from(found.is_some()));
        let mut before: Option<(f64, bool)> = None;
        for sample in 0..=SAMPLES {
            let time = free_until * f64::from(sample) / f64::from(SAMPLES);
            let [p, q, r, s] = at(time);
            let side = (q - p).cross(s - r).dot(r - p);
            let crosses = crossing_within(p, q, r, s);
            if let Some((last, crossed)) = before {
                let is_contact = crosses && crossed && last.signum() * side.signum() < 0.0;
                assert!(!is_contact, "contact before {free_until} at {time}");
            }
            before = Some((side, crosses));
        }
        Ok(())
    });
    assert!(met.get() > 40, "few edges meet: {}", met.get());
}

/// Returns true if the common perpendicular of two lines has its feet well within both edges.
fn crossing_within(p: DVec3, q: DVec3, r: DVec3, s: DVec3) -> bool {
    let (u, v, w) = (q - p, s - r, p - r);
    let (a, b, c) = (u.dot(u), u.dot(v), v.dot(v));
    let (d, e) = (u.dot(w), v.dot(w));
    let determinant = a * c - b * b;
    let [on_first, on_second] = [(b * e - c * d) / determinant, (a * e - b * d) / determinant];
    [on_first, on_second].into_iter().all(|share| (0.001..0.999).contains(&share))
}

/// The chord is no way around: a vertex whose arc bulges through a face that its chord does not
/// reach is found, and one whose chord passes through a face that its arc goes around is not.
#[test]
fn arcs_count_and_not_chords() {
    let turn = |time: f64| {
        let angle = -0.5 + time;
        DVec3::new(10.0 * f64::cos(angle), 10.0 * f64::sin(angle), 0.0)
    };
    let bounds = PathBounds { bend: 10.0 * (1.0 + 1e-12), rounding: 1e-13 };
    let query = |x: f64, from_inside: bool| {
        let face = [[-9.0, -9.0], [9.0, -9.0], [0.0, 9.0]].map(|[y, z]| DVec3::new(x, y, z));
        let at = |time: f64| [turn(time), face[0], face[1], face[2]];
        let found = first_contact_on_paths(
            Primitives::VertexFace,
            at,
            bounds,
            [0.0, 1.0],
            &CcdParams::DEFAULT,
        );
        assert_eq!(from_inside, x > 10.0 * 0.5_f64.cos(), "the scene");
        found.expect("finite points")
    };

    // The arc reaches 10 in the middle, its ends 8.78.
    let bulge = query(9.9, true).expect("the arc passes 9.9");
    let expected = 0.5 - f64::acos(0.99);
    assert!(bulge.lo <= expected && expected - bulge.lo < 1e-6, "{} for {expected}", bulge.lo);
    assert!(query(10.001, true).is_none(), "the arc does not reach 10.001");
    assert!(query(8.7, false).is_none(), "the arc stays beyond 8.7");
    assert!(bulge.is_certain() && (bulge.lo..=bulge.hi).contains(&expected), "{bulge:?}");

    // What comes near within rounding, and does not pass through, is not certain.
    let touch = query(10.0, true).expect("the arc touches 10");
    assert!(!touch.is_certain(), "{touch:?}");
}

/// A vertex that passes the plane of a face beside its rim, by less than rounding, is reported, and
/// is not certain; one that passes well within it is.
#[test]
fn a_crossing_beside_the_rim_is_not_certain() {
    let at_rim = |rim: f64| {
        let face = [[-9.0, rim], [9.0, rim], [0.0, 9.0]].map(|[y, z]| DVec3::new(9.9, y, z));
        let at = |time: f64| {
            let (sin, cos) = (time - 0.5).sin_cos();
            [10.0 * DVec3::new(cos, sin, 0.0), face[0], face[1], face[2]]
        };
        let bounds = PathBounds { bend: 10.0 * (1.0 + 1e-12), rounding: 1e-10 };
        let params = CcdParams::DEFAULT;
        first_contact_on_paths(Primitives::VertexFace, at, bounds, [0.0, 1.0], &params)
            .expect("finite points")
            .expect("within rounding of the face")
    };
    assert!(!at_rim(5e-11).is_certain(), "beside the rim");
    assert!(at_rim(-0.1).is_certain(), "within the rim");
}

/// The bound is attained by a parabola, whose second derivative is constant.
#[test]
fn a_parabola_attains_the_deviation() {
    let parabola = |t: f64| 3.0 * t * t;
    for piece in [1.0, 0.5, 0.125] {
        let middle = parabola(0.5 * piece);
        let chord = 0.5 * parabola(piece);
        let deviation = chord_deviation(6.0, piece);
        assert!((chord - middle).abs() <= deviation && deviation < 1.0001 * (chord - middle));
    }
}

/// A vertex is carried along above a thin face, at a distance that the rounding of its normal
/// exceeds: it never passes through.
#[test]
fn a_vertex_that_rides_on_a_thin_face_has_no_certain_contact() {
    check(2000, |u| {
        let width = 10.0_f64.powf(-5.0 - 0.9 * share(u)?);
        let height = 10.0_f64.powf(-12.0 - share(u)?);
        let frame = DQuat::from_axis_angle(point(u, 1.0)?.normalize_or(DVec3::X), 6.0 * share(u)?);
        let way = point(u, 1.0)?;
        let at_rest = [
            DVec3::new(0.5, 0.3 * width, height),
            DVec3::ZERO,
            DVec3::X,
            DVec3::new(0.5, width, 0.0),
        ];
        let at = |time: f64| at_rest.map(|x| frame * x + time * way);
        let bounds = PathBounds { bend: 1e-9, rounding: 8.0 * f64::EPSILON };
        let params = CcdParams::DEFAULT;
        let found = first_contact_on_paths(Primitives::VertexFace, at, bounds, [0.0, 1.0], &params)
            .expect("finite points");
        assert!(!found.is_some_and(|found| found.is_certain()), "{found:?} at {width:e}");
        Ok(())
    });
}
