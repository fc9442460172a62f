//! Medial surfaces of real muscles: accuracy, bounds against fresh samples,
//! topology and time by number of balls; deformation; detection beside surfaces.
//!
//! Reads the meshes below the folder in `MUSCULO_DATA`. With arguments, the accuracy
//! of the named muscles or of `all`, or `detection` alone; else four of the hip. Times are of the processor, one thread.
#![expect(clippy::print_stdout, reason = "what a report is for")]

mod accuracy;
mod data;
mod deformation;
mod detection;

use std::process::ExitCode;

use benches::ratio::Report;

const HIP: [&str; 4] = ["gluteus_medius", "gluteus_maximus", "iliacus", "psoas_major"];

fn main() -> ExitCode {
    let Some(folder) = data::folder() else {
        println!("skipped: MUSCULO_DATA does not name a folder with anatomy/");
        return ExitCode::SUCCESS;
    };
    let named: Vec<String> = std::env::args().skip(1).collect();
    let detection_alone = named == ["detection"];
    let names = match named.as_slice() {
        [] => HIP.map(str::to_owned).to_vec(),
        [all] if all == "all" => data::muscles(&folder),
        _ if detection_alone => Vec::new(),
        _ => named,
    };
    let mut report = Report::default();
    accuracy::run(&folder, &names, &HIP, &mut report);
    if names == HIP {
        deformation::run(&folder);
    }
    if names == HIP || detection_alone {
        detection::run(&folder, &mut report);
    }
    report.finish()
}
