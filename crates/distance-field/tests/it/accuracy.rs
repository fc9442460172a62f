//! Errors of each method in distances and directions, near the surface.
//!
//! `cargo test --release -p distance-field --test it accuracy -- --nocapture` prints the
//! table of `docs/accuracy-distance-field.md`.

use std::rc::Rc;

use distance_field::{
    DistanceField, FieldMethod, FieldParams, Interpolation, NodeValues, QueryParams, SampleBatch,
    Storage, Voxelization,
};
use fixtures::femur::{femur, height};
use fixtures::sampling::{Errors, PointTruth, points_near};
use fixtures::{Mesh, data};
use surface::glam::DVec3;

use crate::support::{Exact, INTERPOLATING, build, lowest_node};

/// The generated femur with its vertices moved onto the very surface it was cut
/// from: facets as flat as those of a segmented and smoothed bone.
fn smooth_femur(cell: f64) -> Mesh {
    let slope = |p: DVec3| {
        let along = |axis: DVec3| (height(p + 1e-5 * axis) - height(p - 1e-5 * axis)) / 2e-5;
        DVec3::new(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
    };
    let newton = |p: DVec3| {
        let slope = slope(p);
        p - slope * (height(p) / slope.length_squared())
    };
    femur(cell).mapped(|p| newton(newton(newton(p))))
}

/// Fields of a bone, each built once.
struct Fields<'a> {
    mesh: &'a Mesh,
    built: Vec<(FieldParams, Rc<DistanceField>)>,
}

impl<'a> Fields<'a> {
    const fn new(mesh: &'a Mesh) -> Self {
        Self { mesh, built: Vec::new() }
    }

    fn with(&mut self, params: &FieldParams) -> Rc<DistanceField> {
        if let Some((_, field)) = self.built.iter().find(|(built, _)| built == params) {
            return Rc::clone(field);
        }
        let field = Rc::new(build(self.mesh, params).expect("a bone fits"));
        self.built.push((*params, Rc::clone(&field)));
        field
    }
}

/// Truth within 2 mm of the surface; signs are those of the default field.
fn truths(fields: &mut Fields<'_>, count: u32) -> Vec<PointTruth> {
    let mesh = fields.mesh;
    let mut exact = Exact::new(mesh);
    let field = fields.with(&FieldParams { samples: 0, ..FieldParams::new(1.0) });
    let truth = |point: DVec3| {
        let side = field.evaluate(point, Interpolation::Cubic)?.distance;
        PointTruth::new(point, exact.closest(point), side)
    };
    points_near(mesh, count, 2.0).into_iter().filter_map(truth).collect()
}

fn errors(field: &DistanceField, truths: &[PointTruth], interpolation: Interpolation) -> Errors {
    let points: Vec<DVec3> = truths.iter().map(|truth| truth.point).collect();
    let mut samples = SampleBatch::default();
    field.query_batch(
        &points,
        &QueryParams { interpolation, ..QueryParams::default() },
        &mut samples,
    );
    Errors::new(truths, samples.distance.into_iter().zip(samples.gradient))
}

fn band(band: f64) -> FieldParams {
    let method = FieldMethod::ExactBand { band, node_values: NodeValues::QuasiInterpolating };
    FieldParams { method, samples: 0, ..FieldParams::new(1.0) }
}

fn voxel(voxelization: Voxelization) -> FieldParams {
    let method = FieldMethod::Voxel { voxelization };
    FieldParams { method, samples: 0, ..FieldParams::voxel(1.0) }
}

/// One line of the table: spacing, name, params, interpolation, and what it
/// may be off by at most: rms and worst [mm], rms of directions [degrees].
type Row = (f64, &'static str, FieldParams, Interpolation, [f64; 3]);

/// The default with exact distances put in place of its own at every node near a
/// point, signed as it is: what is left is the interpolation's own error.
fn exact_at_nodes(field: &DistanceField, mesh: &Mesh, truths: &[PointTruth]) -> DistanceField {
    let (grid, mut values) = (*field.grid(), field.values());
    let mut exact = Exact::new(mesh);
    let mut is_done = vec![false; values.len()];
    let [nx, ny, nz] = grid.dims();
    for truth in truths {
        let [i, j, k] = lowest_node(&grid, truth.point);
        let around = |n: usize, count: usize| n.saturating_sub(1)..(n + 3).min(count);
        for (k, j) in around(k, nz).flat_map(|k| around(j, ny).map(move |j| (k, j))) {
            for i in around(i, nx) {
                let node = grid.index([i, j, k]);
                if !std::mem::replace(&mut is_done[node], true) {
                    #[expect(clippy::cast_possible_truncation, reason = "as values are kept")]
                    let distance = exact.distance(grid.position([i, j, k])) as f32;
                    values[node] = distance.copysign(values[node]);
                }
            }
        }
    }
    DistanceField::from_values(grid, values, Storage::Float).expect("finite values")
}

/// What no exact values at nodes 1 mm apart could better, printed below a table.
fn print_floor(fields: &mut Fields<'_>, truths: &[PointTruth]) {
    let field = fields.with(&FieldParams { method: INTERPOLATING, ..band(3.0) });
    let exact = exact_at_nodes(&field, fields.mesh, truths);
    for (name, interpolation) in [
        ("exact at every node", TRILINEAR),
        ("the same, smooth gradient", Interpolation::Smooth),
        ("the same, cubic", Interpolation::Cubic),
    ] {
        let [ours, floor] = [&*field, &exact].map(|field| errors(field, truths, interpolation));
        let Errors { rms, worst, direction } = floor;
        println!("| {name} | 1 | {rms:.4} | {worst:.3} | {direction:.2} |");
        // Nodes that interpolate are at the floor of each interpolation.
        assert!(ours.rms <= 1.15 * rms + 1e-4, "{name}: {ours:?} over {floor:?}");
        assert!(ours.direction <= 1.15 * direction, "{name}: {ours:?} over {floor:?}");
    }
    // Nodes that give way are well below it.
    let giving = fields.with(&band(3.0));
    let [ours, floor] = [&*giving, &exact].map(|field| errors(field, truths, TRILINEAR).rms);
    assert!(ours <= 0.75 * floor, "{ours} over {floor}");
}

fn check(bone: &str, mesh: &Mesh, rows: &[Row]) {
    let fields = &mut Fields::new(mesh);
    let truths = truths(fields, 4000);
    println!(
        "\n| {bone}, 2 mm around the surface | spacing [mm] | rms [mm] | worst [mm] | direction rms [°] |"
    );
    println!("|---|--:|--:|--:|--:|");
    let mut short = Vec::new();
    for (spacing, name, params, interpolation, allowed) in rows {
        let params = FieldParams { spacing: *spacing, ..*params };
        let field = fields.with(&params);
        let Errors { rms, worst, direction } = errors(&field, &truths, *interpolation);
        println!("| {name} | {spacing} | {rms:.4} | {worst:.3} | {direction:.2} |");
        if params == (FieldParams { spacing: 1.0, ..band(3.0) }) {
            let told = format!("{interpolation:?}").to_lowercase();
            let line = |what, value, allowed| {
                println!("measured: {bone}, 1 mm, {told}: {what} | {value} | {allowed}");
            };
            line("rms error [mm]", format!("{rms:.4}"), allowed[0]);
            line("worst error [mm]", format!("{worst:.3}"), allowed[1]);
            line("rms of directions [°]", format!("{direction:.2}"), allowed[2]);
        }
        if rms > allowed[0] || worst > allowed[1] || direction > allowed[2] {
            short.push(format!("{name} at {spacing}: {rms} {worst} {direction} over {allowed:?}"));
        }
    }
    print_floor(fields, &truths);
    assert!(short.is_empty(), "{short:#?}");
}

const TRILINEAR: Interpolation = Interpolation::Trilinear;

#[test]
fn table_of_the_femur() {
    let exact = band(3.0);
    let fixed = FieldParams { method: INTERPOLATING, ..exact };
    let steps = FieldParams { storage: Storage::Quantized { step: 0.001 }, ..exact };
    check(
        "Femur of 83,000 vertices",
        &smooth_femur(2.0),
        &[
            (2.0, "voxels, Bresenham", voxel(Voxelization::Bresenham), TRILINEAR, [0.5, 1.5, 28.0]),
            (2.0, "exact band of 3", exact, TRILINEAR, [0.012, 0.07, 2.5]),
            (2.0, "the same, cubic", exact, Interpolation::Cubic, [0.007, 0.04, 1.5]),
            (
                1.0,
                "voxels, Bresenham",
                voxel(Voxelization::Bresenham),
                TRILINEAR,
                [0.23, 0.8, 22.0],
            ),
            (
                1.0,
                "voxels, six-separating",
                voxel(Voxelization::SixSeparating),
                TRILINEAR,
                [0.19, 0.6, 19.0],
            ),
            (
                1.0,
                "voxels, conservative",
                voxel(Voxelization::Conservative),
                TRILINEAR,
                [0.3, 0.8, 23.0],
            ),
            (1.0, "exact band of 1.75", band(1.75), TRILINEAR, [0.02, 0.3, 2.4]),
            (1.0, "exact band of 3, interpolating", fixed, TRILINEAR, [0.008, 0.04, 1.7]),
            (1.0, "the same, cubic", fixed, Interpolation::Cubic, [0.004, 0.03, 1.4]),
            (1.0, "exact band of 3 (default)", exact, TRILINEAR, [0.005, 0.03, 1.7]),
            (1.0, "the same, smooth gradient", exact, Interpolation::Smooth, [0.005, 0.03, 1.5]),
            (1.0, "the same, cubic", exact, Interpolation::Cubic, [0.004, 0.03, 1.4]),
            (1.0, "the same, 16-bit steps of 1 µm", steps, TRILINEAR, [0.005, 0.03, 1.7]),
            (0.5, "exact band of 3 (default)", exact, TRILINEAR, [0.005, 0.07, 1.5]),
            (0.5, "the same, cubic", exact, Interpolation::Cubic, [0.006, 0.07, 1.6]),
            (0.5, "exact band of 5", band(5.0), TRILINEAR, [0.005, 0.07, 1.5]),
        ],
    );
}

#[test]
fn table_of_real_bones() {
    let Some(folder) = data::anatomy("table_of_real_bones") else {
        return;
    };
    let exact = band(3.0);
    let fixed = FieldParams { method: INTERPOLATING, ..exact };
    let rows = |limits: [[f64; 3]; 3]| -> [Row; 7] {
        [
            // Leaks on the femur, whose faces span three voxels.
            (
                1.0,
                "voxels, Bresenham",
                voxel(Voxelization::Bresenham),
                TRILINEAR,
                [9.0, 9.0, 180.0],
            ),
            (
                1.0,
                "voxels, six-separating",
                voxel(Voxelization::SixSeparating),
                TRILINEAR,
                limits[0],
            ),
            (1.0, "exact band of 3, interpolating", fixed, TRILINEAR, [0.025, 0.45, 5.0]),
            (1.0, "the same, cubic", fixed, Interpolation::Cubic, limits[2]),
            (1.0, "exact band of 3 (default)", exact, TRILINEAR, limits[1]),
            (1.0, "the same, smooth gradient", exact, Interpolation::Smooth, limits[1]),
            (1.0, "the same, cubic", exact, Interpolation::Cubic, limits[2]),
        ]
    };
    let mesh = data::mesh(&folder.join("vhf_left_thigh/bone_femur.ply"));
    let femur = rows([[0.18, 0.6, 19.0], [0.012, 0.16, 3.0], [0.0095, 0.15, 2.5]]);
    check("Femur of 7,300 vertices", &mesh, &femur);
    let mesh = data::mesh(&folder.join("vhf_left_thigh/bone_pelvis.ply"));
    let pelvis = rows([[0.25, 1.1, 24.0], [0.016, 0.35, 5.0], [0.014, 0.35, 4.0]]);
    check("Pelvis of 14,900 vertices", &mesh, &pelvis);
}

/// A point that slides along the bone: values follow the way, directions turn
/// gently.
#[test]
fn nothing_jumps_along_a_way() {
    let mesh = smooth_femur(4.0);
    let field = build(&mesh, &FieldParams::new(1.0)).expect("a bone fits");
    let stated = field.report().measured_error.expect("compared by default").max;
    let (step, length) = (0.01, 40_000);
    // Along the shaft and around it, within 5 mm of its surface.
    let way = |n: i32| {
        let t = f64::from(n) * step;
        let turn = 0.05 * t;
        let radius = 16.0 + 3.0 * (0.11 * t).sin();
        let advance = (step * step - (0.05 * radius * step).powi(2)).max(0.0).sqrt() / step;
        DVec3::new(1.0 + radius * turn.cos(), 6.0 + radius * turn.sin(), 0.6 * advance * t - 70.0)
    };
    for interpolation in [Interpolation::Trilinear, Interpolation::Smooth, Interpolation::Cubic] {
        let (mut jump, mut turned) = (0.0_f64, 0.0_f64);
        let mut before: Option<(DVec3, distance_field::Sample)> = None;
        for n in 0..length {
            let p = way(n);
            let Some(here) = field.evaluate(p, interpolation) else { break };
            if let Some((last, before)) = before {
                let moved = p.distance(last);
                jump = jump.max((here.distance - before.distance).abs() - moved);
                let clear = here.gradient.length().min(before.gradient.length()) > 0.9;
                if clear {
                    let angle = here.gradient.angle_between(before.gradient).to_degrees();
                    turned = turned.max(angle);
                }
            }
            before = Some((p, here));
        }
        println!("{interpolation:?}: {jump:.5} mm over the step, {turned:.3}° a step");
        let name = format!("sliding by 0.01 mm, {interpolation:?}").to_lowercase();
        println!(
            "measured: {name}: value beyond the step [mm] | {:.5} | {stated:.4}",
            jump.max(0.0)
        );
        assert!(jump < stated, "{interpolation:?}: {jump}");
        let allowed = match interpolation {
            Interpolation::Trilinear => 90.0,
            Interpolation::Smooth => 0.5,
            Interpolation::Cubic => 5.0,
        };
        println!("measured: {name}: turn off the medial axis [°] | {turned:.2} | {allowed}");
        assert!(turned < allowed, "{interpolation:?}: {turned}");
    }
}

/// The measured error does not depend on how truncated values are rounded: no sample is where nothing but the truncation is
/// stored.
#[test]
fn the_measured_deep_error_is_the_same_in_any_unit() {
    let ball = fixtures::shapes::icosphere(8.0, 3);
    let measured = |unit: f64, step: Option<f64>| {
        let storage = step.map_or(Storage::Float, |step| Storage::Quantized { step: unit * step });
        let params = FieldParams { storage, ..FieldParams::new(0.5 * unit) };
        let field = build(&ball.clone().mapped(|p| unit * p), &params).expect("a ball fits");
        field.report().measured_deep_error.expect("a ball has a middle").max / unit
    };
    let expected = measured(1.0, None);
    assert!(expected > 0.02, "{expected}");
    for unit in [1e-3, 0.1, 0.3, 0.7, 25.4] {
        let found = measured(unit, None);
        assert!((found - expected).abs() < 1e-3 * expected, "{found} in {unit}, not {expected}");
    }
    for step in [0.011, 0.017, 0.021] {
        let found = measured(1.0, Some(step));
        assert!((found - expected).abs() < step, "{found} by {step}, not {expected}");
    }
}

/// The measured error far from the surface covers that of 40,000 places all over the grid, nearly:
/// at most a hundredth of them exceed it, and none by more than half.
#[test]
fn the_measured_deep_error_covers_deep_places() {
    let shapes = [("femur", smooth_femur(4.0)), ("sphere", fixtures::shapes::icosphere(12.0, 3))];
    for (name, mesh) in shapes {
        let mut exact = Exact::new(&mesh);
        let params = FieldParams { truncation: None, ..FieldParams::new(1.5) };
        let field = build(&mesh, &params).expect("a bone fits");
        let measured = field.report().measured_deep_error.expect("a bone has deep places");
        assert_eq!(measured.points, 64, "{name}");

        let (grid, mut worst, mut above, mut count) = (field.grid(), 0.0_f64, 0, 0);
        let extent = grid.position(grid.dims().map(|n| n - 1)) - grid.origin();
        for n in 0..40_000 {
            let n = f64::from(n);
            let place =
                DVec3::new(0.754_877_666_2 * n, 0.569_840_290_9 * n, 0.438_579_4 * n).fract();
            let point = grid.origin() + place * extent;
            let Some(found) = field.evaluate(point, Interpolation::Trilinear) else { continue };
            if found.distance.abs() > 3.0 {
                let error = (found.distance.abs() - exact.distance(point)).abs();
                worst = worst.max(error);
                above += u32::from(error > measured.max);
                count += 1;
            }
        }
        println!("measured: deep error of a field, {name} | {:.4} | {worst:.4}", measured.max);
        assert!(count > 1000, "{name}: {count} deep places");
        assert!(worst <= 1.5 * measured.max, "{name}: {worst} of {}", measured.max);
        assert!(above * 100 <= count, "{name}: {above} of {count} exceed {}", measured.max);
    }
}
