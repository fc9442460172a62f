//! Splines beside fields, fits beside what is known of them.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    reason = "fields keep single precision; tests count little"
)]

use std::f64::consts::TAU;

use benches::bodies::Body;
use distance_field::{BuildOptions, DistanceField, Grid, Interpolation, NodeValues, Storage};
use fixtures::random::Random;
use fixtures::sampling::{Errors, Truth, points_near, spread};
use fixtures::shapes::icosphere;
use glam::DVec3;
use indicatif::ProgressBar;

use crate::exact::truths;
use crate::fit::{Aim, Fit, answers, sort};
use crate::spline::{B_SPLINE, CATMULL_ROM, LINEAR, MEAN, Spline};
use crate::{BOTH, DISTANCES, SLOPES};

/// 28 nodes along each axis, `spacing` apart around the origin.
fn grid(spacing: f64) -> Grid {
    Grid::new(DVec3::splat(-13.5 * spacing), spacing, [28; 3]).unwrap()
}

fn noise(count: usize) -> Vec<f64> {
    let mut random = Random(7);
    (0..count).map(|_| f64::from((random.unit() - 0.5) as f32)).collect()
}

/// Points two spacings to either side of a quarter of a sphere, with the truth in closed form.
fn around_sphere(radius: f64, count: u32, grid: &Grid) -> Vec<Truth> {
    let truth = |n: u32| {
        let s = spread(n);
        let (z, turn) = (1.0 - 0.5 * s.x, TAU * s.y);
        let across = (1.0 - z * z).sqrt();
        let direction = DVec3::new(across * turn.cos(), across * turn.sin(), z);
        let distance = 2.0 * grid.spacing() * (2.0 * s.z - 1.0);
        Truth { point: (radius + distance) * direction, distance, direction }
    };
    let mut truths: Vec<Truth> = (0..count).map(truth).collect();
    sort(&mut truths, grid);
    truths
}

fn best<const N: usize>(
    spline: Spline<N>,
    grid: &Grid,
    truths: &[Truth],
    aim: &Aim,
    values: &[f64],
    steps: u64,
) -> Vec<f64> {
    Fit::new(spline, *grid, truths).best(aim, values, steps, || ())
}

fn errors<const N: usize>(
    spline: Spline<N>,
    grid: &Grid,
    truths: &[Truth],
    values: &[f64],
) -> Errors {
    Errors::new(truths, answers(spline, grid, values, truths))
}

/// What a fit makes as small as can be.
fn counted<const N: usize>(
    spline: Spline<N>,
    grid: &Grid,
    truths: &[Truth],
    aim: &Aim,
    values: &[f64],
) -> f64 {
    let answers = answers(spline, grid, values, truths);
    let square = |(truth, (value, gradient)): (&Truth, (f64, DVec3))| {
        let distance = (value - truth.distance) / grid.spacing();
        aim.distance * distance * distance + aim.slope * gradient.distance_squared(truth.direction)
    };
    truths.iter().zip(answers).map(square).sum()
}

#[test]
fn splines_answer_as_fields_do() {
    let grid = grid(0.7);
    let values = noise(grid.node_count());
    let stored = values.iter().map(|&value| value as f32).collect();
    let field = DistanceField::from_values(grid, stored, Storage::Dense).unwrap();
    let truths = around_sphere(7.0, 6000, &grid);
    let check = |field: &DistanceField, interpolation, answers: Vec<(f64, DVec3)>| {
        for (truth, (value, gradient)) in truths.iter().zip(answers) {
            let sample = field.sample(truth.point, interpolation).unwrap();
            assert!((sample.distance - value).abs() < 1e-12, "{sample:?} {value}");
            assert!((sample.gradient - gradient).length() < 1e-11, "{sample:?} {gradient}");
        }
    };
    check(&field, Interpolation::Trilinear, answers(LINEAR, &grid, &values, &truths));
    check(&field, Interpolation::Cubic, answers(CATMULL_ROM, &grid, &values, &truths));
    let field = field.with_nodes(NodeValues::QuasiInterpolating);
    check(&field, Interpolation::Cubic, answers(MEAN, &grid, &values, &truths));
}

/// The B-spline takes a sixth of either neighbour and two thirds of a node.
#[test]
fn the_b_spline_is_what_it_is_known_for() {
    let grid = grid(0.5);
    let [a, b, c] = [[13, 12, 14], [14, 12, 14], [15, 12, 14]].map(|node| grid.index(node));
    let mut values = vec![0.0; grid.node_count()];
    // Rows above and below alike, so that only x tells.
    for row in 0..9 {
        let at = |n: usize| n - 28 - 28 * 28 + 28 * (row % 3) + 28 * 28 * (row / 3);
        (values[at(a)], values[at(b)], values[at(c)]) = (6.0, 12.0, 30.0);
    }
    let point = grid.position([14, 12, 14]);
    let truth = Truth { point, distance: 0.0, direction: DVec3::X };
    let (value, gradient) = answers(B_SPLINE, &grid, &values, &[truth])[0];
    assert!(
        (value - 14.0).abs() < 1e-12 && (gradient - 24.0 * DVec3::X).length() < 1e-12,
        "{value} {gradient}"
    );
}

/// Every spline holds a plane, and finds it again from nodes that are off.
#[test]
fn a_plane_is_found_whatever_the_spline_and_the_aim() {
    fn check<const N: usize>(name: &str, spline: Spline<N>) {
        let grid = grid(0.7);
        let direction = DVec3::new(2.0, -3.0, 6.0) / 7.0;
        let mut truths = around_sphere(5.0, 6000, &grid);
        for truth in &mut truths {
            *truth = Truth { distance: direction.dot(truth.point) - 0.3, direction, ..*truth };
        }
        let height = |n: usize| direction.dot(grid.position([n % 28, n / 28 % 28, n / 784])) - 0.3;
        let noise = noise(grid.node_count());
        let values: Vec<f64> =
            noise.iter().enumerate().map(|(n, off)| height(n) + 0.1 * off).collect();
        for aim in [DISTANCES, BOTH, SLOPES] {
            let before = errors(spline, &grid, &truths, &values);
            let best = best(spline, &grid, &truths, &aim, &values, 200);
            let after = errors(spline, &grid, &truths, &best);
            let is_found = after.rms < 0.01 * before.rms;
            let is_turned = after.direction < 0.05 * before.direction;
            assert!(is_found && is_turned, "{name} {aim:?}: {before:?} {after:?}");
        }
    }
    check("linear", LINEAR);
    check("Catmull–Rom", CATMULL_ROM);
    check("mean", MEAN);
    check("B-spline", B_SPLINE);
}

/// Straight pieces bend by t (1 - t) times half the second derivative less than the surface: along
/// each axis its mean can be taken away, and a 180th of its square is left. Cubics follow it.
#[test]
fn floors_over_a_sphere_are_those_of_theory() {
    let (grid, radius) = (grid(0.5), 5.0);
    let truths = around_sphere(radius, 60_000, &grid);
    let position = |n: usize| grid.position([n % 28, n / 28 % 28, n / 784]);
    let values: Vec<f64> = (0..grid.node_count()).map(|n| position(n).length() - radius).collect();
    let floor = |truth: &Truth| {
        let n = truth.direction;
        let bends = (1.0 - n * n) * (0.25 / truth.point.length());
        0.25 * bends.length_squared() / 180.0
    };
    let floor = (truths.iter().map(floor).sum::<f64>() / truths.len() as f64).sqrt();
    let exact = errors(LINEAR, &grid, &truths, &values).rms;
    let linear = best(LINEAR, &grid, &truths, &DISTANCES, &values, 24);
    let linear = errors(LINEAR, &grid, &truths, &linear).rms;
    let cubic = best(B_SPLINE, &grid, &truths, &DISTANCES, &values, 24);
    let cubic = errors(B_SPLINE, &grid, &truths, &cubic).rms;
    assert!((linear / floor - 1.0).abs() < 0.05, "{linear} for {floor}");
    assert!(exact > 2.0 * linear, "{exact} {linear}");
    assert!(cubic < 0.1 * linear, "{cubic} {linear}");
}

/// On a body of flat faces: below the field that is built, and no change of nodes lowers it.
#[test]
fn nothing_fits_better_than_what_fits_best() {
    fn check<const N: usize>(
        name: &str,
        spline: Spline<N>,
        field: &DistanceField,
        truths: &[Truth],
    ) {
        let grid = field.grid();
        let values: Vec<f64> = field.values().into_iter().map(f64::from).collect();
        let noise = noise(values.len());
        for aim in [DISTANCES, BOTH, SLOPES] {
            let counted = |values: &[f64]| counted(spline, grid, truths, &aim, values);
            let best = best(spline, grid, truths, &aim, &values, 24);
            let least = counted(&best);
            assert!(least < counted(&values), "{name} {aim:?}: {least}");
            for size in [1e-2, -1e-2] {
                let moved: Vec<f64> =
                    best.iter().zip(&noise).map(|(x, off)| x + size * off).collect();
                assert!(
                    least < counted(&moved),
                    "{name} {aim:?} {size}: {least} {}",
                    counted(&moved)
                );
            }
        }
    }
    let mesh = icosphere(6.0, 1);
    let points = points_near(&mesh, 20_000, 2.0);
    let body = Body { surface: mesh.surface(), x: mesh.positions };
    let x = body.surface.positions(&body.x).unwrap();
    let field = DistanceField::build(&body.surface, x, &BuildOptions::default()).unwrap();
    let mut truths = truths(&body, &points, &ProgressBar::hidden());
    assert!(truths.len() > 18_000, "{} of 20,000 are not in doubt", truths.len());
    sort(&mut truths, field.grid());
    check("linear", LINEAR, &field, &truths);
    check("mean", MEAN, &field, &truths);
    check("B-spline", B_SPLINE, &field, &truths);
}

#[test]
fn threads_change_no_bit() {
    let grid = grid(0.5);
    let truths = around_sphere(5.0, 6000, &grid);
    let values = noise(grid.node_count());
    let fitted = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| best(MEAN, &grid, &truths, &BOTH, &values, 3))
    };
    let bits = |values: Vec<f64>| -> Vec<u64> { values.into_iter().map(f64::to_bits).collect() };
    assert!(bits(fitted(1)) == bits(fitted(3)), "the same bits");
}
