//! A sheet of triangles that falls onto a sharp ridge: the first contact, all contacts, and how many
//! candidates the filters keep.
#![expect(clippy::print_stdout, reason = "an example that prints its results")]

use ccd::{CcdError, CcdParams, FirstContact, MovingPoints};
use glam::DVec3;

/// Vertices along a side of the sheet.
const SIDE: u32 = 40;

fn main() -> Result<(), CcdError> {
    // A sheet 40 wide at height 3, and a ridge along y below it.
    let mut x0: Vec<DVec3> = (0..SIDE * SIDE)
        .map(|i| DVec3::new(f64::from(i % SIDE) + 0.3, f64::from(i / SIDE), 3.0))
        .collect();
    let mut x1: Vec<DVec3> = x0.iter().map(|x| x - DVec3::Z * (4.0 + 0.01 * x.x)).collect();
    let ridge = [DVec3::new(20.0, -1.0, 0.0), DVec3::new(20.0, 50.0, 0.5)];
    x0.extend(ridge);
    x1.extend(ridge);

    // Candidates: every edge of the sheet across the ridge.
    let [from, to] = [SIDE * SIDE, SIDE * SIDE + 1];
    let across = (0..SIDE).flat_map(|y| (0..SIDE - 1).map(move |x| y * SIDE + x));
    let edges: Vec<[u32; 4]> = across.map(|i| [i, i + 1, from, to]).collect();

    let motion = MovingPoints::new(&x0, &x1)?;
    let params = CcdParams::DEFAULT;
    println!("{} candidates", edges.len());
    println!("{} kept by the filters", motion.filter_edge_edges(&edges, &params)?.len());

    let contacts = motion.edge_edge_contacts(&edges, &params)?;
    let certain = contacts.iter().filter(|c| c.contact.is_certain()).count();
    println!("{} contacts, {certain} of them certain", contacts.len());

    if let Some(FirstContact::EdgeEdge(first)) = motion.first_contact(&[], &edges, &params)? {
        let contact = first.contact;
        println!("first: edge {:?} at {:.6} of the step", edges[first.candidate], contact.lo);
        println!("       normal {:.3}, weights {:.3?}", contact.normal, contact.weights);
    }
    Ok(())
}
