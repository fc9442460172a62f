//! Real muscles, where the folder of `MUSCULO_DATA` holds them: how few faces do, and
//! that the deviation is what was asked for.
#![expect(clippy::print_stdout, reason = "prints a table")]

use std::time::{Duration, Instant};

use decimate::Decimation;
use fixtures::data;

const DEVIATIONS: [f64; 5] = [1.0, 0.5, 0.25, 0.1, 0.05];

/// Thick and thin, smooth and noisy.
const SOME: [&str; 3] = ["muscle_pectineus", "muscle_psoas_major", "muscle_quadratus_femoris"];

#[test]
fn muscles_within_five_deviations() {
    let Some(folder) = data::anatomy("muscles_within_five_deviations") else {
        return;
    };
    let mut totals = [0; 6];
    let (mut collapsing, mut searching) = (Duration::ZERO, Duration::ZERO);
    let mut slack = 1.0_f64;
    println!("{:28} {:>6} {DEVIATIONS:?} mm", "body", "faces");
    for name in SOME {
        let mesh = data::mesh(&folder.join("vhf_left_thigh").join(name).with_extension("ply"));
        let surface = mesh.surface();
        let x = surface.positions(&mesh.positions).expect("finite positions");
        let start = Instant::now();
        let decimation = Decimation::new(&surface, x).expect("a muscle can be decimated");
        collapsing += start.elapsed();
        let mut faces = vec![surface.faces().len()];
        let start = Instant::now();
        for deviation in DEVIATIONS {
            let reduced = decimation.within(deviation).expect("a deviation in range");
            let bound = reduced.deviation.largest();
            assert!(bound <= deviation, "{name}: {bound} within {deviation}");
            for side in [reduced.deviation.full_to_reduced, reduced.deviation.reduced_to_full] {
                slack = slack.max(side.upper / side.lower.max(1e-9));
            }
            faces.push(reduced.surface.faces().len());
        }
        searching += start.elapsed();
        assert!(faces[1..].is_sorted(), "{name}: {faces:?}");
        println!("{name:28} {faces:6?}");
        totals.iter_mut().zip(&faces).for_each(|(total, faces)| *total += faces);
    }
    println!("{:28} {totals:6?} {collapsing:.1?} to collapse, {searching:.1?} to search", "all");
    println!("bounds exceed what was seen by a factor of {slack:.3} at most");
    assert!(slack < 1.2 && totals[2] < totals[0] / 4, "{slack} {totals:?}");
}
