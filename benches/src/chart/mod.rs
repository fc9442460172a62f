//! Charts of the accuracy and the cost of methods, with the numbers behind them.
//!
//! A picture, or a table of numbers alone, is a module with a function `run` that writes its files
//! into a folder and returns their paths; [`PICTURES`] lists them.

pub mod axes;
#[cfg(feature = "peers")]
pub mod ccd;
pub mod convergence;
pub mod curves;
pub mod detection;
mod labels;
pub mod medial;
pub mod palette;
#[cfg(feature = "peers")]
pub mod peers;
pub mod poster;
pub mod response;
pub mod sheet;
pub mod size;
pub mod stability;

use std::error::Error;
use std::path::{Path, PathBuf};

use crate::selected;

/// Function that draws a picture into a folder and returns the files it wrote.
pub type Draw = fn(&Path) -> Result<Vec<PathBuf>, Box<dyn Error>>;

/// All pictures, by name.
pub const PICTURES: &[(&str, Draw)] = &[
    ("detection", detection::run),
    ("costs", detection::costs::run),
    ("stability", stability::run),
    #[cfg(feature = "peers")]
    ("ccd", ccd::run),
    ("convergence", convergence::run),
    ("medial", medial::run),
    #[cfg(feature = "peers")]
    ("peers", peers::run),
    ("response", response::run),
    ("size", size::run),
];

/// Draws the named pictures, or all without a name; returns the files it wrote.
///
/// # Errors
///
/// When there is no such picture, or one cannot be drawn.
pub fn draw(folder: &Path, names: &[String]) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut written = Vec::new();
    for (name, draw) in selected(PICTURES, names)? {
        written.extend(draw(folder).map_err(|error| format!("{name}: {error}"))?);
    }
    Ok(written)
}
