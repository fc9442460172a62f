//! Benchmarks: figures beside peers, tables, charts of accuracy over time, and endurance.
//!
//! The program `benches` runs them all; `cargo xtask ratios`, `chart` and `soak` call it.
//!
//! # Features
//!
//! - `charts` (default): what needs the facade or draws: charts and endurance. Figures build in
//!   half the time without it.

pub mod bodies;
pub mod ccd;
#[cfg(feature = "charts")]
pub mod chart;
pub mod measure;
pub mod medial_contact;
pub mod medial_report;
pub mod ratios;
pub mod sheets;
#[cfg(feature = "charts")]
pub mod soak;
pub mod volumes;
