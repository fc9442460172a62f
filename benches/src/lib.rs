//! Benchmarks beside peers.

pub mod ccd;
