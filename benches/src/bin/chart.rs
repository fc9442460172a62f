//! Draws pictures of what methods can and cannot do into a folder: SVG, with
//! the numbers as JSON and CSV.
//!
//! usage: chart FOLDER \[PICTURE…\]; all pictures, if none is named.

#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a program that prints")]

use std::path::PathBuf;
use std::process::ExitCode;

use benches::chart::PICTURES;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().filter(|argument| !argument.starts_with('-'));
    let Some(folder) = folder.map(PathBuf::from) else {
        eprintln!("usage: chart FOLDER [PICTURE…], where a picture is one of {}", known());
        return ExitCode::from(2);
    };
    let wanted: Vec<String> = arguments.collect();
    if let Some(name) = wanted.iter().find(|name| PICTURES.iter().all(|(known, _)| known != name)) {
        eprintln!("there is no picture {name}: known are {}", known());
        return ExitCode::from(2);
    }
    for (name, draw) in PICTURES {
        if wanted.is_empty() || wanted.iter().any(|wanted| wanted == name) {
            match draw(&folder) {
                Ok(paths) => paths.iter().for_each(|path| println!("wrote {}", path.display())),
                Err(error) => {
                    eprintln!("{name}: {error}");
                    return ExitCode::FAILURE;
                }
            }
        }
    }
    ExitCode::SUCCESS
}

fn known() -> String {
    PICTURES.map(|(name, _)| name).join(", ")
}
