//! The field of a bone: built, reported, and asked along a way towards it.
//!
//! ```text
//! cargo run --release -p distance-field --example bone
//! ```

#![expect(clippy::print_stdout, reason = "an example shows what it does")]

use std::error::Error;

use distance_field::{DistanceField, FieldParams, Interpolation, MeasuredError, Pose, QueryParams};
use surface::glam::{DQuat, DVec3};
use surface::progress::Progress;

fn main() -> Result<(), Box<dyn Error>> {
    let bone = fixtures::femur::femur(4.0);
    let surface = bone.surface();
    let field = DistanceField::build(
        &surface,
        surface.positions(&bone.positions)?,
        &FieldParams::new(1.0),
        Progress::none(),
    )?;

    let report = field.report();
    println!(
        "{} faces, {:?} nodes, {} bytes",
        bone.faces.len(),
        field.grid().dims(),
        field.bytes()
    );
    if let Some(MeasuredError { rms, max, .. }) = report.measured_error {
        println!("error: rms {rms:.4} mm, max {max:.3} mm");
    }
    for warning in &report.warnings {
        println!("warning: {warning:?}");
    }

    // The bone has moved; the way is in the world, from outside to the marrow.
    let pose = Pose::new(DQuat::from_rotation_z(0.4), DVec3::new(100.0, 0.0, 900.0));
    let query = QueryParams { interpolation: Interpolation::Cubic, offset: 0.5, pose };
    for millimetres in [30.0, 20.0, 15.0, 10.0, 5.0, 0.0] {
        let p = DVec3::new(100.0 + millimetres, 5.0, 900.0);
        match field.query(p, &query) {
            None => println!("{p}: outside the grid"),
            Some(sample) => match sample.direction(0.5) {
                Some(n) => println!("{p}: {:+.3} mm, away along {n:.3}", sample.distance),
                None => println!("{p}: {:+.3} mm, no one direction", sample.distance),
            },
        }
    }
    Ok(())
}
