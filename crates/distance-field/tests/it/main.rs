//! Tests of the public interface against closed forms, brute force and real bones.

#![allow(
    clippy::cast_precision_loss,
    clippy::float_cmp,
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "tests count little, compare exact figures, print what they measure and may panic"
)]

mod accuracy;
mod any_triangles;
mod beyond_band;
mod cavities;
mod contacts;
mod failures;
mod progress;
mod queries;
mod segments;
mod signs;
mod support;
#[cfg(feature = "rayon")]
mod threads;
mod truncation;
mod units;
mod voxels;
