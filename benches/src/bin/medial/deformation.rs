//! What deformation does to a medial surface, with constant and refitted radii.

use std::fmt::Write as _;
use std::path::Path;

use benches::bodies::Body;
use glam::{DMat3, DVec3};
use medial::{Deviation, Links, MedialParams, MedialSurface, REFIT_PASSES, generate};

use crate::data::muscle;

/// A table of the error for each way to deform two muscles along their longest axis.
pub(crate) fn run(folder: &Path) -> String {
    let mut text = String::from(
        "| muscle | balls | deformation | rest | bound | constant radii | bound | refitted | bound |\n|---|--:|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for (name, balls) in [("gluteus_medius", 100), ("psoas_major", 200)] {
        let body = muscle(folder, name);
        let x = body.surface.positions(&body.x).expect("finite positions");
        let made = generate(&body.surface, x, &MedialParams::balls(balls), |_| {}).expect("closed");
        let links = Links::new(&made.medial, &body.surface, x).expect("finite balls");
        for (what, moved) in deformed(&body) {
            let x = body.surface.positions(&moved).expect("finite positions");
            let measured = |medial: &MedialSurface| {
                Deviation::measure(medial, &body.surface, x).expect("closed")
            };
            let mut medial = made.medial.clone();
            links.move_centers(&mut medial, x).expect("its own links");
            let constant = measured(&medial);
            links.refit(&mut medial, x, REFIT_PASSES).expect("its own links");
            let refitted = measured(&medial);
            // Writing into a string cannot fail.
            let _ = write!(text, "| {} | {balls} | {what} |", name.replace('_', " "));
            for deviation in [&made.deviation, &constant, &refitted] {
                let _ = write!(text, " {:.3} | {:.1} |", deviation.rms, deviation.largest());
            }
            text.push('\n');
        }
    }
    text
}

/// The body stretched, shortened (volume kept), bent and twisted along z, which
/// is the longest axis of either muscle.
fn deformed(body: &Body) -> [(&'static str, Vec<DVec3>); 4] {
    let [lowest, highest] = body.bounds();
    let (middle, length) = (lowest.midpoint(highest), highest.z - lowest.z);
    let map = |f: &dyn Fn(DVec3) -> DVec3| -> Vec<DVec3> {
        body.x.iter().map(|p| middle + f(*p - middle)).collect()
    };
    let along = |s: f64| move |p: DVec3| p * DVec3::new(s.powf(-0.5), s.powf(-0.5), s);
    let bend = |p: DVec3| {
        // z becomes the angle on a circle of which the length is a quarter.
        let radius = length / std::f64::consts::FRAC_PI_2;
        let (sin, cos) = (p.z / radius).sin_cos();
        DVec3::new((radius + p.x) * cos - radius, p.y, (radius + p.x) * sin)
    };
    let twist = |p: DVec3| DMat3::from_rotation_z(p.z / length * 60.0_f64.to_radians()) * p;
    [
        ("stretch 1.3", map(&along(1.3))),
        ("shorten 0.75", map(&along(0.75))),
        ("bend 90°", map(&bend)),
        ("twist 60°", map(&twist)),
    ]
}
