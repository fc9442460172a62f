//! The crate's tests, one binary.

mod anatomy;
mod joint;
mod planted;
mod ties;
