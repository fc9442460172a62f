//! Real muscles, where the folder of `MUSCULO_DATA` holds them: the number of faces for each of
//! several deviations, none of which is exceeded.
#![expect(clippy::print_stdout, reason = "prints a table")]

use std::time::{Duration, Instant};

use fixtures::data;
use surface::progress::Progress;

const DEVIATIONS: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.05];

/// Thick and thin, smooth and noisy.
const MUSCLES: [&str; 3] = ["muscle_pectineus", "muscle_psoas_major", "muscle_quadratus_femoris"];

#[test]
fn muscles_within_five_deviations() {
    let Some(folder) = data::anatomy("muscles_within_five_deviations") else {
        return;
    };
    let mut totals = [0; 6];
    let (mut collapsing, mut searching) = (Duration::ZERO, Duration::ZERO);
    println!("{:28} {:>6} {DEVIATIONS:?} mm", "body", "faces");
    for name in MUSCLES {
        let mesh = data::mesh(&folder.join("vhf_left_thigh").join(name).with_extension("ply"));
        let start = Instant::now();
        let decimation = crate::decimation(&mesh).expect("a muscle can be decimated");
        collapsing += start.elapsed();
        let mut faces = vec![mesh.faces.len()];
        let start = Instant::now();
        for deviation in DEVIATIONS {
            let reduced =
                decimation.within(deviation, Progress::none()).expect("a deviation in range");
            let bound = reduced.deviation;
            assert!(bound <= deviation, "{name}: {bound} within {deviation}");
            faces.push(reduced.surface.faces().len());
        }
        searching += start.elapsed();
        assert!(faces[1..].is_sorted(), "{name}: {faces:?}");
        println!("{name:28} {faces:6?}");
        totals.iter_mut().zip(&faces).for_each(|(total, faces)| *total += faces);
    }
    println!("{:28} {totals:6?} {collapsing:.1?} to collapse, {searching:.1?} to search", "all");
    assert!(totals[2] < totals[0] / 4, "{totals:?}");
}
