//! Generates medial surfaces of a muscle with ever more balls, draws the last one from the side as
//! SVG, and writes it as `.ma` text.
//!
//! ```text
//! cargo run --release -p medial --example balls_of_a_muscle [FOLDER]
//! ```
//!
//! Writes `muscle.svg` and `muscle.ma` into the folder, or the temporary one.
#![expect(clippy::print_stdout, reason = "an example prints its results")]

use std::error::Error;
use std::fmt::Write as _;
use std::path::PathBuf;

use fixtures::shapes::ellipsoid;
use glam::DVec3;
use medial::{MedialParams, MedialSurface, Topology, generate};
use surface::progress::Progress;

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args().nth(1).map_or_else(std::env::temp_dir, PathBuf::from);
    let belly = ellipsoid(DVec3::new(80.0, 25.0, 10.0), 4);
    let muscle = belly.mapped(|p| p + DVec3::Z * 0.004 * p.x * p.x);
    let surface = muscle.surface();
    let x = surface.positions(&muscle.positions)?;
    println!("balls  slabs    rms  surface to medial  medial to surface  topology");
    let mut last = None;
    for balls in [10, 25, 50, 100] {
        let made = generate(&surface, x, &MedialParams::balls(balls), Progress::none())?;
        let deviation = made.deviation;
        println!(
            "{balls:5}  {:5}  {:.3}  {:17.3}  {:17.3}  {:?}",
            made.medial.slabs().len(),
            deviation.rms,
            deviation.surface_to_medial.upper,
            deviation.medial_to_surface.upper,
            Topology::of_union(&made.medial, 1.0, Progress::none())?,
        );
        last = Some(made.medial);
    }
    if let Some(medial) = last {
        std::fs::write(folder.join("muscle.svg"), drawn(&muscle, &medial))?;
        std::fs::write(folder.join("muscle.ma"), medial.to_ma())?;
        println!("wrote muscle.svg and muscle.ma to {}", folder.display());
    }
    Ok(())
}

/// Surface edges in gray, balls as circles, the sheet between them in blue; seen
/// along y.
fn drawn(muscle: &fixtures::Mesh, medial: &MedialSurface) -> String {
    let bounds = medial.bounds();
    let size = bounds.sides();
    let place = |p: DVec3| (p.x, -p.z);
    let mut svg = format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="{} {} {} {}" stroke-width="0.15" fill="none">"#,
        bounds.min.x, -bounds.max.z, size.x, size.z
    );
    let mut line = |from: DVec3, to: DVec3, color: &str| {
        let ((x1, y1), (x2, y2)) = (place(from), place(to));
        // Writing into a string cannot fail.
        let _ = write!(svg, r#"<path d="M{x1} {y1} L{x2} {y2}" stroke="{color}"/>"#);
    };
    for &[a, b] in muscle.surface().edges() {
        line(muscle.positions[a as usize], muscle.positions[b as usize], "#ddd");
    }
    for balls in medial.primitives() {
        let [a, b, c] = balls.map(|ball| medial.balls()[ball as usize].center);
        for (from, to) in [(a, b), (b, c), (c, a)] {
            line(from, to, "#36c");
        }
    }
    for ball in medial.balls() {
        let (x, y) = place(ball.center);
        let _ = write!(svg, r##"<circle cx="{x}" cy="{y}" r="{}" stroke="#c63"/>"##, ball.radius);
    }
    svg + "</svg>\n"
}
