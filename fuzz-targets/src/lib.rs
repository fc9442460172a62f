//! What is done with arbitrary bytes: each target takes some, and panics where a
//! promise is broken.
//!
//! The workspace in `fuzz` hands them to libFuzzer, which needs a nightly
//! compiler; the tests of this crate replay its corpus, and mutations of it, with
//! any compiler.

mod bytes;
mod files;
mod geometry;

pub use self::files::{mesh, scene, volume};
pub use self::geometry::{ccd, field, kdop};

/// A target.
pub type Target = fn(&[u8]);

/// All targets, by the names of their folders in `fuzz/corpus`.
pub const TARGETS: [(&str, Target); 6] = [
    ("mesh", mesh),
    ("volume", volume),
    ("scene", scene),
    ("ccd", ccd),
    ("kdop", kdop),
    ("field", field),
];
