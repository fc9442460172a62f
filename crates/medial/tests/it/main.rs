//! Tests of medial surfaces.

mod anatomy;
mod contacts;
mod detection;
mod distances;
mod following;
mod generation;
mod interruption;
mod pitfalls;
mod rigid_contacts;
mod sheets;
mod support;
#[cfg(feature = "rayon")]
mod threads;
mod units;
mod validation;
