//! Runs figures, tables, charts and endurance tests.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program that prints")]

use std::error::Error;
use std::path::Path;
use std::process::ExitCode;

use benches::measure::Report;
#[cfg(feature = "figures")]
use benches::ratios;
use benches::{medial_report, volumes};

const USAGE: &str = "\
usage: benches TASK

  ratios [--quick] [--only TEXT] [CRATE…]
                               figures beside what they are compared with, one line of JSON each;
                               with a text, those whose names begin with it (feature `figures`;
                               beside other libraries also `peers`)
  ratios --list                names of the crates that have figures
  volumes                      table of bounding volumes of 6, 14, 18 and 26 planes
  trees                        table of trees that are refit, built where loose, or always
  floors                       tables of times beside those of memory alone, and of what two
                               threads gain (feature `charts`)
  source                       tables of the times that the method's source gives, beside ours
                               (features `charts` and `peers`)
  medial FILE                  document on the accuracy of medial surfaces
  chart FOLDER [PICTURE…]      charts with their numbers (feature `charts`; with other libraries
                               also `peers`)
  regret [SCENE…]              times of chosen plans over those of forced ones (feature `charts`)
  stability [SCENE…]           table of detectors and responses over planted scenes (feature `charts`)
  soak [FRAMES]                many frames of a small scene, and memory left behind (feature `charts`)";

/// Share of the budgets of `ratios --quick`.
#[cfg(feature = "figures")]
const QUICK: f64 = 0.25;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(shortfalls) if shortfalls.is_empty() => ExitCode::SUCCESS,
        Ok(shortfalls) => {
            eprintln!("beyond their bounds: {}", shortfalls.join(", "));
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

/// Reads the options of `ratios`; returns the report that they make, and what follows them.
#[cfg(feature = "figures")]
fn ratio_options(arguments: &[String]) -> (Report, &[String]) {
    let (mut report, mut rest) = (Report::new(1.0), arguments);
    if let [flag, after @ ..] = rest
        && flag == "--quick"
    {
        (report, rest) = (Report::new(QUICK), after);
    }
    if let [flag, text, after @ ..] = rest
        && flag == "--only"
    {
        (report, rest) = (report.only(text), after);
    }
    (report, rest)
}

/// Runs a task; returns the names of figures beyond their bounds.
fn run(arguments: &[String]) -> Result<Vec<String>, Box<dyn Error>> {
    let (task, rest) = arguments.split_first().ok_or(USAGE)?;
    // Figures print themselves; the report counts those beyond their bounds.
    let mut report = Report::new(1.0);
    match (task.as_str(), rest) {
        #[cfg(feature = "figures")]
        ("ratios", [flag]) if flag == "--list" => {
            for (group, _) in ratios::GROUPS {
                println!("{group}");
            }
        }
        #[cfg(feature = "figures")]
        ("ratios", options) => {
            let (of_options, names) = ratio_options(options);
            report = of_options;
            ratios::run(names, &mut report)?;
        }
        ("trees", []) => print!("{}", benches::trees::table()),
        ("volumes", []) => print!("{}", volumes::table()),
        ("medial", [file]) => medial_report::write(Path::new(file), &mut report)?,
        #[cfg(feature = "charts")]
        ("chart", [folder, names @ ..]) => {
            for path in benches::chart::draw(Path::new(folder), names)? {
                println!("wrote {}", path.display());
            }
        }
        #[cfg(feature = "charts")]
        ("floors", []) => print!("{}", benches::floors::tables()?),
        #[cfg(all(feature = "charts", feature = "peers"))]
        ("source", []) => print!("{}", benches::source_figures::tables()?),
        #[cfg(feature = "charts")]
        ("regret", names) => print!("{}", benches::regret::table(names)?),
        #[cfg(feature = "charts")]
        ("stability", names) => print!("{}", benches::stability::table(names)?),
        #[cfg(feature = "charts")]
        ("soak", [] | [_]) => {
            let frames = rest.first().map_or(Ok(10_000), |frames| frames.parse())?;
            report.begin("soak");
            benches::soak::run(frames, &mut report)?;
        }
        _ => return Err(USAGE.into()),
    }
    Ok(report.shortfalls().to_vec())
}
