//! Reduced surfaces of a muscle with fewer and fewer faces, and their proved deviation at rest
//! and after a deformation.
//!
//! ```text
//! cargo run --release -p decimate --example levels_of_a_muscle
//! ```
#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use decimate::{CoarseSurface, Decimation};
use glam::DVec3;
use proximity::SurfaceTree;
use surface::progress::Progress;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let muscle = fixtures::thigh::thigh().body("vastus_lateralis").mesh.clone();
    let full = SurfaceTree::new(muscle.surface(), muscle.positions.clone())?;
    println!("full: {} faces", muscle.faces.len());

    // Shorten it by a tenth, at constant volume.
    let shortened = muscle.scaled(DVec3::new(1.05, 1.05, 0.9)).positions;

    let decimation = Decimation::new(full, Progress::none())?;
    println!("requested [mm]   faces      proved [mm]   after shortening [mm]");
    for max_deviation in [0.1, 0.25, 0.5, 1.0, 2.0] {
        let reduced = decimation.within(max_deviation, Progress::none())?;
        let mut coarse = CoarseSurface::new(reduced, decimation.full())?;
        coarse.follow(&shortened)?;
        println!(
            "{max_deviation:>14}{:>8}{:>17.3}{:>24.3}",
            coarse.tree().surface().faces().len(),
            coarse.reduced().deviation,
            coarse.deviation(),
        );
    }
    Ok(())
}
