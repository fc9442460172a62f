//! Queries: poses, offsets, batches, storage, and gradients against values.

use distance_field::{
    DistanceField, FieldGrid, FieldParams, Interpolation, NodeValues, Pose, QueryParams, Sample,
    SampleBatch, Storage,
};
use fixtures::generate::cases;
use fixtures::sampling::spread;
use fixtures::shapes;
use surface::glam::{DQuat, DVec3};

use crate::support::{build, lowest_node, nodes};

const ALL: [Interpolation; 3] =
    [Interpolation::Trilinear, Interpolation::Smooth, Interpolation::Cubic];

/// A field whose values a formula gives.
fn sampled(formula: impl Fn(DVec3) -> f64) -> DistanceField {
    let grid = FieldGrid::new(DVec3::new(-3.0, 1.0, 2.0), 0.5, [12, 10, 11]).expect("a small grid");
    let nodes = nodes([12, 10, 11]);
    #[expect(clippy::cast_possible_truncation, reason = "that is how values are kept")]
    let values = nodes.map(|node| formula(grid.position(node)) as f32).collect();
    DistanceField::from_values(grid, values, Storage::Float).expect("finite values")
}

/// Every interpolation gives back what it can represent, up to the border.
#[test]
fn linear_fields_come_back_exactly() {
    let normal = DVec3::new(0.5, -0.25, 0.75);
    let field = sampled(|p| normal.dot(p) - 1.0);
    cases(1, 1000, |u| {
        let mut share = || Ok(f64::from(u.int_in_range(0..=1000_u16)?) / 1000.0);
        let at = DVec3::new(share()?, share()?, share()?);
        let p = DVec3::new(-3.0, 1.0, 2.0) + at * DVec3::new(5.5, 4.5, 5.0);
        for interpolation in ALL {
            let Sample { distance, gradient } = field.evaluate(p, interpolation).unwrap();
            assert!((distance - (normal.dot(p) - 1.0)).abs() < 1e-6, "{interpolation:?} {p}");
            assert!(gradient.distance(normal) < 1e-5, "{interpolation:?} {p} {gradient}");
        }
        Ok(())
    });
}

/// The cubic also gives back squares, inside; and its gradient and the
/// trilinear one are what their own values say.
#[test]
fn gradients_are_the_slopes_of_values() {
    let square = |p: DVec3| p.x * p.x - 2.0 * p.y * p.z + p.z * p.z;
    let field = sampled(square);
    cases(1, 1000, |u| {
        let mut share = || Ok(f64::from(u.int_in_range(1..=998_u16)?) / 999.7);
        let at = DVec3::new(share()?, share()?, share()?);
        let p = DVec3::new(-2.5, 1.5, 2.5) + at * DVec3::new(4.5, 3.5, 4.0);
        for interpolation in [Interpolation::Trilinear, Interpolation::Cubic] {
            let Sample { distance, gradient } = field.evaluate(p, interpolation).unwrap();
            if interpolation == Interpolation::Cubic {
                assert!((distance - square(p)).abs() < 1e-5, "{p}: {distance}");
            }
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let step = 1e-5 * axis;
                let [below, above] = [p - step, p + step]
                    .map(|p| field.evaluate(p, interpolation).unwrap().distance);
                let [a, b] = [p - step, p + step].map(|p| lowest_node(field.grid(), p));
                let same_cell = a == b;
                let slope = (above - below) / 2e-5;
                assert!(!same_cell || (slope - gradient.dot(axis)).abs() < 1e-4, "{p} {axis}");
            }
        }
        Ok(())
    });
}

/// Of nodes that gave way, the cubic still gives back squares: it puts back what they
/// took off.
#[test]
fn the_cubic_knows_what_nodes_hold() {
    let square = |p: DVec3| p.x * p.x - 2.0 * p.y * p.z + p.z * p.z;
    // A twelfth of the second differences along x and z, nodes 0.5 apart.
    let field = sampled(|p| square(p) - 0.25 * (2.0 + 2.0) / 12.0);
    let field = field.with_node_values(NodeValues::QuasiInterpolating);
    for n in 0..500 {
        let p = DVec3::new(-2.5, 1.5, 2.5) + spread(n) * DVec3::new(4.5, 3.5, 4.0);
        let Sample { distance, gradient } = field.evaluate(p, Interpolation::Cubic).unwrap();
        let slope = DVec3::new(2.0 * p.x, -2.0 * p.z, 2.0 * (p.z - p.y));
        assert!((distance - square(p)).abs() < 1e-5, "{p}: {distance}");
        assert!(gradient.distance(slope) < 1e-4, "{p}: {gradient}");
    }
}

/// The same answer as by moving the point into the body's frame by hand.
#[test]
fn poses_turn_points_in_and_gradients_out() {
    let field = build(&shapes::torus(20.0, 6.0, [48, 24]), &FieldParams::new(1.0)).unwrap();
    let rotation = DQuat::from_axis_angle(DVec3::new(0.36, 0.48, 0.8), 1.1);
    let translation = DVec3::new(400.0, -120.0, 33.0);
    // Not normalized: a pose takes care of that.
    let pose = Pose::new(rotation * 3.0, translation);
    for n in 0..500 {
        let local = (spread(n) - 0.5) * DVec3::new(60.0, 60.0, 24.0);
        let world = rotation * local + translation;
        for interpolation in ALL {
            let query = QueryParams { interpolation, offset: 0.25, pose };
            let plain = field.evaluate(local, interpolation).unwrap();
            let posed = field.query(world, &query).unwrap();
            assert!((posed.distance - (plain.distance - 0.25)).abs() < 1e-9);
            assert!(posed.gradient.distance(rotation * plain.gradient) < 1e-8);
        }
    }
}

/// To the bit, however the field is kept, wherever it is, whatever lanes are left over.
#[test]
fn batches_are_single_answers_and_outside_is_infinite() {
    let turn = DQuat::from_axis_angle(DVec3::new(0.36, 0.48, 0.8), 0.7);
    let pose = Pose::new(turn, DVec3::new(3.0, -1.0, 2.0));
    let ball = shapes::octasphere(10.0, 3);
    for storage in [Storage::Float, Storage::Quantized { step: 0.001 }] {
        let field = build(&ball, &FieldParams { storage, ..FieldParams::new(1.0) }).unwrap();
        let points: Vec<DVec3> = (0..9001).map(|n| (spread(n) - 0.5) * 48.0).collect();
        for query in
            [QueryParams::default(), QueryParams { pose, offset: 0.3, ..QueryParams::default() }]
        {
            let mut samples = SampleBatch::default();
            field.query_batch(&points, &query, &mut samples);
            let mut outside = 0;
            for (n, &p) in points.iter().enumerate() {
                let one = field.query(p, &query).unwrap_or(Sample::OUTSIDE);
                let (distance, gradient) = (samples.distance[n], samples.gradient[n]);
                assert_eq!(one, Sample { distance, gradient }, "{storage:?} {p}");
                outside += u32::from(one.distance == f64::INFINITY);
            }
            assert!((500..8000).contains(&outside), "{outside}");
            // Used again with fewer points, a batch holds just these.
            field.query_batch(&points[..7], &query, &mut samples);
            assert_eq!((samples.distance.len(), samples.gradient.len()), (7, 7));
        }
    }
}

/// What is beyond any one border, or not a number, is outside in a batch too.
#[test]
fn batches_end_at_each_border() {
    let field = build(&shapes::octasphere(5.0, 3), &FieldParams::new(1.0)).unwrap();
    let grid = *field.grid();
    let last = grid.position(grid.dims().map(|n| n - 1));
    let middle = 0.5 * (grid.origin() + last);
    let mut points = vec![grid.origin(), last, middle];
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        let across = middle * (DVec3::ONE - axis);
        for beyond in [grid.origin() - 1e-9, last + 1e-9, DVec3::NAN, DVec3::INFINITY] {
            points.push(DVec3::select(axis.cmpgt(DVec3::ZERO), beyond, across));
        }
    }
    let mut samples = SampleBatch::default();
    field.query_batch(&points, &QueryParams::default(), &mut samples);
    assert!(samples.distance[..3].iter().all(|distance| distance.is_finite()));
    assert!(samples.distance[3..].iter().all(|distance| *distance == f64::INFINITY));
    assert!(samples.gradient[3..].iter().all(|gradient| *gradient == DVec3::ZERO));
}

#[test]
fn quantized_values_are_off_by_half_a_step_at_most() {
    let torus = shapes::torus(40.0, 6.0, [96, 24]);
    let with = |storage| {
        let params = FieldParams { storage, truncation: Some(6.0), ..FieldParams::new(1.0) };
        build(&torus, &params).unwrap()
    };
    let floats = with(Storage::Float);
    let steps = with(Storage::Quantized { step: 0.002 });
    let errors = floats.values().into_iter().zip(steps.values()).map(|(a, b)| (a - b).abs());
    assert!(errors.fold(0.0, f32::max) <= 0.001 + 1e-6);
    assert_eq!(steps.bytes() * 2, floats.bytes());
}

/// Nodes are found where the grid says they are, however its lengths round.
#[test]
fn the_last_node_is_inside_at_any_spacing() {
    for spacing in [0.1, 0.3, 0.7, 1.0 / 3.0, 1.1] {
        let origin = DVec3::new(-0.3, 1017.7, 1e-3) * spacing;
        let grid = FieldGrid::new(origin, spacing, [31, 12, 7]).unwrap();
        let mut values = vec![0.0; grid.node_count()];
        values[grid.index([30, 11, 6])] = 1.0;
        let field = DistanceField::from_values(grid, values, Storage::Float).unwrap();
        let at = |node| field.evaluate(grid.position(node), Interpolation::Trilinear);
        assert!((at([30, 11, 6]).expect("the last node is inside").distance - 1.0).abs() < 1e-9);
        assert_eq!(at([30, 11, 7]), None);
    }
}
