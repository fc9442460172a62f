//! The same bodies in other units: powers of two, so that all digits are the same.

use distance_field::{
    DistanceField, FieldContact, FieldContacts, FieldDetector, FieldDistance, FieldMethod,
    FieldParams, FieldReport, FieldWarning, Interpolation, MeasuredError, NodeValues, Pose,
    Storage, Voxelization,
};
use fixtures::sampling::spread;
use fixtures::{Mesh, shapes};
use proximity::{ParticleNumbers, SurfaceTree};
use surface::RigidState;
use surface::glam::{DQuat, DVec3};

use crate::support::{INTERPOLATING, build};

/// Sizes of units, up to those of the smallest and the largest spacings.
fn units() -> [f64; 4] {
    [-90, -10, 3, 90].map(|power| 2.0_f64.powi(power))
}

fn bodies() -> [(&'static str, Mesh); 4] {
    let mut open = shapes::ellipsoid(DVec3::new(7.0, 5.0, 4.0), 2);
    open.faces.truncate(open.faces.len() - 9);
    let plate = shapes::plate(DVec3::new(8.0, 7.0, 0.4), [4, 4]);
    let mut inverted = shapes::torus(6.0, 2.0, [16, 12]);
    inverted.faces.iter_mut().for_each(|face| face.swap(0, 1));
    [
        ("open", open),
        ("plate", plate),
        ("inverted", inverted),
        ("tetrahedron", shapes::tetrahedron(1.2)),
    ]
}

fn parameters() -> Vec<FieldParams> {
    let default = FieldParams { padding: 3.0, ..FieldParams::new(0.75) };
    let storage = Storage::Quantized { step: 0.01 };
    let wide = FieldMethod::ExactBand { band: 45.0, node_values: NodeValues::Interpolating };
    let mut parameters = vec![
        default,
        FieldParams { storage, truncation: Some(4.0), ..default },
        FieldParams { method: INTERPOLATING, truncation: None, ..default },
        FieldParams { method: wide, ..default },
    ];
    for voxelization in
        [Voxelization::Bresenham, Voxelization::SixSeparating, Voxelization::Conservative]
    {
        let method = FieldMethod::Voxel { voxelization };
        parameters.push(FieldParams { method, truncation: Some(4.0), ..default });
    }
    parameters
}

fn in_unit(unit: f64, params: &FieldParams) -> FieldParams {
    let storage = match params.storage {
        Storage::Quantized { step } => Storage::Quantized { step: unit * step },
        Storage::Float => Storage::Float,
    };
    FieldParams {
        spacing: unit * params.spacing,
        padding: unit * params.padding,
        truncation: params.truncation.map(|truncation| unit * truncation),
        storage,
        ..*params
    }
}

/// Returns a report with its lengths and its volume in another unit.
fn report_in_unit(unit: f64, report: &FieldReport) -> FieldReport {
    let error = |error: MeasuredError| MeasuredError {
        rms: unit * error.rms,
        max: unit * error.max,
        ..error
    };
    let mut scaled = report.clone();
    for warning in &mut scaled.warnings {
        if let FieldWarning::ThinnerThanGrid { thickness, .. } = warning {
            *thickness *= unit;
        }
    }
    scaled.measured_error = report.measured_error.map(error);
    scaled.measured_deep_error = report.measured_deep_error.map(error);
    scaled.error_bound = report.error_bound.map(|bound| unit * bound);
    scaled.inside_volume *= unit.powi(3);
    scaled
}

/// Values, report and samples of a field.
#[test]
fn fields_are_the_same_in_any_unit() {
    for (name, mesh) in bodies() {
        for params in parameters() {
            let Ok(field) = build(&mesh, &params) else { continue };
            for unit in units() {
                let scaled = mesh.clone().mapped(|p| unit * p);
                let scaled = build(&scaled, &in_unit(unit, &params)).expect("as the other");
                let report = report_in_unit(unit, field.report());
                assert_eq!(*scaled.report(), report, "{name} in {unit} by {params:?}");
                let same = |(a, b): (f32, f32)| f64::from(a) == unit * f64::from(b);
                let mut values = scaled.values().into_iter().zip(field.values());
                assert!(values.all(same), "{name} in {unit} by {params:?}");
                check_samples(&field, &scaled, unit);
            }
        }
    }
}

fn check_samples(field: &DistanceField, scaled: &DistanceField, unit: f64) {
    for n in 0..100 {
        let p = (spread(n) - 0.5) * 24.0;
        for interpolation in [Interpolation::Trilinear, Interpolation::Smooth, Interpolation::Cubic]
        {
            let [one, other] =
                [field.evaluate(p, interpolation), scaled.evaluate(unit * p, interpolation)];
            let one = one.map(|sample| (unit * sample.distance, sample.gradient));
            let other = other.map(|sample| (sample.distance, sample.gradient));
            assert_eq!(one, other, "{p} by {interpolation:?} in {unit}");
        }
    }
}

/// Contacts and distances of a field that is scaled by its values.
#[test]
fn contacts_are_the_same_in_any_unit() {
    let bone = shapes::ellipsoid(DVec3::new(9.0, 7.0, 5.0), 2);
    let params = FieldParams { samples: 0, ..FieldParams::new(0.75) };
    let pose = Pose::new(DQuat::from_axis_angle(DVec3::Y, 0.4), DVec3::new(3.0, -2.0, 8.0));
    let muscle = shapes::ellipsoid(DVec3::new(2.0, 30.0, 2.0), 0).translated(DVec3::X * 8.0);
    let found = |unit: f64| {
        let field = build(&bone.clone().mapped(|p| unit * p), &in_unit(unit, &params));
        let detector = FieldDetector::new(field.expect("a small field"), unit * 0.2).unwrap();
        let pose =
            Pose::new(DQuat::from_axis_angle(DVec3::Y, 0.4), unit * DVec3::new(3.0, -2.0, 8.0));
        let body = muscle.clone().mapped(|p| pose.transform_point(unit * p));
        let body = SurfaceTree::new(body.surface(), body.positions.clone()).expect("a body");
        let mut contacts = FieldContacts::default();
        let state = RigidState::at_rest(pose);
        contacts.compute(&detector, &state, &body, ParticleNumbers::from(0));
        (contacts.contacts().to_vec(), detector, pose)
    };
    let (expected, detector, _) = found(1.0);
    let is_edge = |found: &&FieldContact| found.contact.stencil.terms().len() == 2;
    assert!(expected.iter().filter(is_edge).count() > 1, "{expected:?}");
    for unit in units() {
        let (contacts, scaled, scaled_pose) = found(unit);
        assert_eq!(contacts.len(), expected.len(), "in {unit}");
        for (one, other) in contacts.iter().zip(&expected) {
            assert_eq!(one.feature, other.feature);
            assert_eq!(one.contact.gap, unit * other.contact.gap);
            assert_eq!(one.contact.normal, other.contact.normal);
            assert_eq!(one.contact.stencil, other.contact.stencil);
        }
        for n in 0..100 {
            let p = (spread(n) - 0.5) * 60.0;
            let distance = detector.distance(&pose, pose.transform_point(p));
            let expected = match distance {
                FieldDistance::Value { distance, normal } => {
                    FieldDistance::Value { distance: unit * distance, normal }
                }
                FieldDistance::AtLeast(bound) => FieldDistance::AtLeast(unit * bound),
            };
            let p = scaled_pose.transform_point(unit * p);
            assert_eq!(scaled.distance(&scaled_pose, p), expected, "in {unit}");
        }
    }
}
