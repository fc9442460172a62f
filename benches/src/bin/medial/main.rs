//! Medial surfaces of real muscles: accuracy, bounds against fresh samples,
//! topology and time by number of balls; deformation; detection beside surfaces.
//!
//! usage: medial \[FILE.md | detection | MUSCLE…\] \[--sizes BALLS,…\]
//!
//! Reads the meshes below the folder in `MUSCULO_DATA`. With a file, all muscles, and
//! the tables are written into it; without arguments, four of the hip. Times are of
//! the processor, one thread.
#![expect(clippy::print_stdout, reason = "what a report is for")]

mod accuracy;
mod data;
mod deformation;
mod detection;
mod document;
mod sampling;

use std::process::ExitCode;

use benches::ratio::Report;

const HIP: [&str; 4] = ["gluteus_medius", "gluteus_maximus", "iliacus", "psoas_major"];

fn main() -> ExitCode {
    let Some(folder) = data::folder() else { return ExitCode::SUCCESS };
    let mut named: Vec<String> = std::env::args().skip(1).collect();
    let sizes = sizes(&mut named);
    if named == ["deformation"] {
        println!("{}", deformation::run(&folder));
        return ExitCode::SUCCESS;
    }
    let file = named.iter().find(|name| name.ends_with(".md"));
    let detection_alone = named == ["detection"];
    let names = match named.as_slice() {
        [] => HIP.map(str::to_owned).to_vec(),
        _ if file.is_some() => data::muscles(&folder),
        _ if detection_alone => Vec::new(),
        _ => named.clone(),
    };
    let whole = file.is_some() || named.is_empty();
    let mut report = Report::default();
    let accuracy = accuracy::document(&accuracy::run(&folder, &names, &sizes, &mut report));
    let deformed = if whole { deformation::run(&folder) } else { String::new() };
    let detected =
        if whole || detection_alone { detection::run(&folder, &mut report) } else { String::new() };
    let text = document::text(&accuracy, &deformed, &detected);
    match file {
        Some(path) => std::fs::write(path, text).expect("the file can be written"),
        None => println!("{text}"),
    }
    report.finish()
}

/// Takes the numbers of balls out of the arguments: those of the tables, if none are named.
fn sizes(named: &mut Vec<String>) -> Vec<usize> {
    let Some(at) = named.iter().position(|name| name == "--sizes") else {
        return accuracy::sizes();
    };
    let numbers: String = named.drain(at..).skip(1).take(1).collect();
    numbers.split(',').map(|number| number.parse().expect("a number of balls")).collect()
}
