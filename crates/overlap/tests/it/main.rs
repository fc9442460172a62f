//! The crate's tests, one binary.

mod anatomy;
mod cavities;
mod clipped;
mod coincident;
mod covered;
mod deepest_point;
mod interruption;
mod joint;
mod patches;
mod planted;
mod slivers;
mod ties;
