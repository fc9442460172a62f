//! A muscle on fewer and fewer of its own vertices, and how far that is from it, also when it moves.
//!
//! ```text
//! cargo run --release -p decimate --example levels_of_a_muscle
//! ```
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use decimate::{Decimation, deviation};
use glam::DVec3;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let muscle = fixtures::thigh::thigh().body("vastus_lateralis").mesh.clone();
    let surface = muscle.surface();
    let x = surface.positions(&muscle.positions)?;
    // Shortened by a tenth, at constant volume.
    let shorter = muscle.clone().scaled(DVec3::new(1.05, 1.05, 0.9));
    let moved = surface.positions(&shorter.positions)?;

    let decimation = Decimation::new(&surface, x)?;
    println!("all: {} faces", surface.faces().len());
    println!("asked [mm]   faces   certified [mm]   after shortening [mm]");
    for within in [0.1, 0.25, 0.5, 1.0, 2.0] {
        let level = decimation.within(within)?;
        // The level follows by its vertices: no search, no memory.
        let mut followed = Vec::new();
        level.gather(moved.as_slice(), &mut followed);
        let at = level.surface.positions(&followed)?;
        let strained = deviation(&surface, moved, &level.surface, at)?;
        println!(
            "{within:>10}{:>8}{:>17.3}{:>24.3}",
            level.surface.faces().len(),
            level.deviation.largest(),
            strained.largest(),
        );
    }
    Ok(())
}
