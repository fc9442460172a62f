//! Runs a small moving scene for many frames and tells whether memory grows.
//!
//! usage: soak \[FRAMES\]; 10,000, if none is given. Fails when more than 4096 bytes stay.

#![expect(clippy::print_stdout, reason = "a program that prints a figure")]

use std::error::Error;
use std::process::ExitCode;
use std::time::Instant;

use benches::soak::{Soaked, soak};

/// Bytes that may stay: lists that happened to grow once more.
const ALLOWED: i64 = 4096;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let frames = std::env::args().nth(1).map_or(Ok(10_000), |frames| frames.parse())?;
    let start = Instant::now();
    let soaked = soak(frames)?;
    let Soaked { contacts, grown, peak, detections_that_took, .. } = soaked;
    println!("{frames} frames in {:.1} s, {contacts} contacts", start.elapsed().as_secs_f64());
    println!("memory grown [bytes]: {grown}; taken at once within frames, at most: {peak}");
    println!("frames in which detection took memory: {detections_that_took}");
    Ok(if grown <= ALLOWED { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
