//! Report on medial surfaces of real muscles: accuracy, bounds beside fresh samples, topology and
//! time by number of balls; deformation; detection beside surfaces.

mod accuracy;
mod deformation;
mod detection;
mod sampling;

use std::error::Error;
use std::path::{Path, PathBuf};

use proximity::SurfaceTree;

use crate::bodies;
use crate::measure::Report;

/// Folder of the muscles of the left thigh.
struct Muscles {
    folder: PathBuf,
}

impl Muscles {
    fn read(&self, name: &str) -> SurfaceTree {
        bodies::read(&self.folder.join(format!("muscle_{name}.ply")))
    }

    /// Returns the names of all muscles, in order.
    fn names(&self) -> Vec<String> {
        let mut names = Vec::new();
        for path in fixtures::data::bodies(&self.folder) {
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            names.extend(stem.strip_prefix("muscle_").map(str::to_owned));
        }
        names
    }
}

/// Writes the document of all muscles into a file, and reports figures beyond their bounds.
///
/// Does nothing where `MUSCULO_DATA` is not set.
///
/// # Errors
///
/// When the file cannot be written.
pub fn write(file: &Path, report: &mut Report) -> Result<(), Box<dyn Error>> {
    let Some(anatomy) = fixtures::data::anatomy("medial surfaces of muscles") else {
        return Ok(());
    };
    let muscles = Muscles { folder: anatomy.join("vhf_left_thigh") };
    let rows = accuracy::rows(&muscles, report);
    // The template ends in a line break, as do the tables.
    let text = include_str!("document.md")
        .trim_end()
        .replace("{accuracy}", &accuracy::table(&rows))
        .replace("{deformation}", &deformation::table(&muscles))
        .replace("{detection}", &detection::table(&muscles, report));
    Ok(std::fs::write(file, text)?)
}
