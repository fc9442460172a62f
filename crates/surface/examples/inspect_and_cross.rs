//! Looks two surfaces over, one of them damaged, and tells where they cross and what is inside.
//!
//! ```text
//! cargo run --release -p surface --example inspect_and_cross
//! ```
#![expect(clippy::print_stdout, reason = "a program that prints")]

use glam::DVec3;
use surface::{Defect, Meeting, TriangleSurface, inspect, triangles_meet, winding_number};

fn main() -> Result<(), surface::SurfaceError> {
    // An octahedron, whole and with a face missing, the second one moved into the first.
    let corners = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
    let faces = vec![
        [0, 1, 2],
        [1, 3, 2],
        [3, 4, 2],
        [4, 0, 2],
        [1, 0, 5],
        [3, 1, 5],
        [4, 3, 5],
        [0, 4, 5],
    ];
    let open = TriangleSurface::new(6, faces[1..].to_vec())?;
    let whole = TriangleSurface::new(6, faces)?;
    let moved = corners.map(|x| x + DVec3::new(1.1, 0.2, 0.1));

    for (name, surface, x) in [("whole", &whole, &corners), ("with a hole", &open, &moved)] {
        let found = inspect(surface, surface.positions(x)?);
        let open_edges = found.count(Defect::BoundaryEdge);
        println!("{name}: closed {}, {open_edges} open edges", found.closed());
    }

    let of = |surface: &TriangleSurface, x: &[DVec3; 6], face: usize| {
        surface.faces()[face].map(|corner| x[corner as usize])
    };
    for f in 0..whole.faces().len() {
        for g in 0..open.faces().len() {
            if triangles_meet(of(&whole, &corners, f), of(&open, &moved, g)) == Meeting::Crossing {
                println!("face {f} of the first crosses face {g} of the second");
            }
        }
    }
    let x = whole.positions(&corners)?;
    for (vertex, p) in moved.iter().enumerate() {
        let turns = winding_number(&whole, x, *p);
        println!("vertex {vertex} of the second is wound {turns:.2} times by the first");
    }
    Ok(())
}
