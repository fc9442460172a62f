//! Pictures of what methods can and cannot do, with the numbers behind them.
//!
//! A picture, or a table of numbers alone, is a module with a function `run` that is given the folder to
//! write to and returns the files it wrote; [`PICTURES`] names them all.

pub mod ccd;
pub mod curves;
pub mod detection;
pub mod medial;
pub mod sheet;
pub mod stability;

use std::error::Error;
use std::path::{Path, PathBuf};

/// Draws a picture into a folder; returns the files it wrote.
pub type Draw = fn(&Path) -> Result<Vec<PathBuf>, Box<dyn Error>>;

/// Every picture, by its name.
pub const PICTURES: [(&str, Draw); 5] = [
    ("detection", detection::run),
    ("costs", detection::costs::run),
    ("stability", stability::run),
    ("ccd", ccd::run),
    ("medial", medial::run),
];
