//! The crate's tests, one binary.

mod anatomy;
mod planted;
mod ties;
