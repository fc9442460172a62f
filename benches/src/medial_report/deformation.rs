//! Error of medial surfaces after deformation, with constant and with refitted radii.

use std::fmt::Write as _;

use glam::{DMat3, DVec3};
use medial::{Deviation, Links, MedialParams, REFIT_PASSES, generate};
use proximity::SurfaceTree;
use surface::progress::Progress;

use super::Muscles;
use crate::bodies::bounds;

/// Formats the error for each deformation of two muscles along their longest axis.
pub(super) fn table(muscles: &Muscles) -> String {
    let mut text = String::from(
        "| muscle | balls | deformation | rest | bound | constant radii | bound | refitted | bound |\n|---|--:|---|--:|--:|--:|--:|--:|--:|\n",
    );
    for (name, balls) in [("gluteus_medius", 100), ("psoas_major", 200)] {
        let body = muscles.read(name);
        let (surface, x) = (body.surface(), body.positions());
        let rest =
            generate(surface, x, &MedialParams::balls(balls), Progress::none()).expect("closed");
        let links = Links::new(&rest.medial, surface, x).expect("finite balls");

        for (deformation, moved) in deformed(&body) {
            // The same balls, with moved centers, then refitted.
            let x = surface.positions(&moved).expect("finite positions");
            let mut medial = rest.medial.clone();
            links.move_centers(&mut medial, x).expect("its own links");
            let constant = Deviation::measure(&medial, surface, x).expect("closed");
            links.refit(&mut medial, x, REFIT_PASSES).expect("its own links");
            let refitted = Deviation::measure(&medial, surface, x).expect("closed");

            // Writing into a string cannot fail.
            let _ = write!(text, "| {} | {balls} | {deformation} |", name.replace('_', " "));
            for deviation in [&rest.deviation, &constant, &refitted] {
                let _ = write!(text, " {:.3} | {:.1} |", deviation.rms, deviation.largest());
            }
            text.push('\n');
        }
    }
    text
}

/// Returns the vertices stretched, shortened (volume kept), bent and twisted along z, the longest
/// axis of either muscle.
fn deformed(body: &SurfaceTree) -> [(&'static str, Vec<DVec3>); 4] {
    let bounds = bounds(body);
    let (center, length) = (bounds.center(), bounds.sides().z);
    let map = |f: &dyn Fn(DVec3) -> DVec3| -> Vec<DVec3> {
        body.positions().as_slice().iter().map(|p| center + f(*p - center)).collect()
    };

    // The z axis becomes a quarter of a circle.
    let radius = length / std::f64::consts::FRAC_PI_2;
    let bend = |p: DVec3| {
        let (sin, cos) = (p.z / radius).sin_cos();
        DVec3::new((radius + p.x) * cos - radius, p.y, (radius + p.x) * sin)
    };
    let along = |s: f64| move |p: DVec3| p * DVec3::new(s.powf(-0.5), s.powf(-0.5), s);
    let twist = |p: DVec3| DMat3::from_rotation_z(p.z / length * 60.0_f64.to_radians()) * p;
    [
        ("stretch 1.3", map(&along(1.3))),
        ("shorten 0.75", map(&along(0.75))),
        ("bend 90°", map(&bend)),
        ("twist 60°", map(&twist)),
    ]
}
