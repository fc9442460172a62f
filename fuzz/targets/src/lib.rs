//! Fuzz targets: functions of arbitrary bytes that panic where a promise is broken.
//!
//! The workspace in `fuzz` hands them to libFuzzer, which needs a nightly compiler.
//! The tests of this crate replay its corpus, and mutations of it, with any compiler.

mod bytes;
mod files;
mod geometry;

pub use self::files::{mesh, scene, volume};
pub use self::geometry::{ccd, field, kdop};

/// Fuzz target; returns true if the bytes are valid input of what it tests.
pub type Target = fn(&[u8]) -> bool;

/// All targets, by the names of their folders in `fuzz/corpus`.
pub const TARGETS: [(&str, Target); 6] = [
    ("mesh", mesh),
    ("volume", volume),
    ("scene", scene),
    ("ccd", ccd),
    ("kdop", kdop),
    ("field", field),
];
