//! Two balls overlap: inspects them, counts the faces that cross and the vertices
//! inside, and finds the deepest one.
//!
//! ```text
//! cargo run --release -p surface --example overlap
//! ```
//!
//! Every face is compared with every other: enough for small surfaces, and the
//! result that search trees must reproduce.

#![expect(clippy::print_stdout, reason = "an example prints its results")]

use fixtures::shapes;
use surface::glam::DVec3;
use surface::{
    Contact, Meeting, Positions, Pseudonormals, Stencil, SurfaceError, TriangleSurface,
    closest_on_triangle, inspect, ray_crosses_triangle, triangles_meet,
};

fn main() -> Result<(), SurfaceError> {
    let mesh = shapes::icosphere(20.0, 2);
    let moved = mesh.clone().translated(DVec3::new(35.0, 3.0, -4.0));
    let ball = mesh.surface();
    let (a, b) = (ball.positions(&mesh.positions)?, ball.positions(&moved.positions)?);

    let report = inspect(&ball, a);
    println!("{} faces, {:.1} mm³, defects: {:?}", report.faces, report.volume, report.findings);
    ball.require_closed()?;
    println!("{} pairs of faces cross", count_crossings(&ball, a, b));

    // A contact for each vertex of the first ball inside the second.
    let normals = Pseudonormals::new(&ball, b);
    let mut contacts = Vec::new();
    for (vertex, &p) in (0..).zip(&mesh.positions) {
        if is_inside(&ball, b, p) {
            contacts.extend(contact(&ball, b, &normals, vertex, p));
        }
    }
    println!("{} vertices are inside", contacts.len());

    if let Some(deepest) = contacts.iter().min_by(|p, q| p.gap.total_cmp(&q.gap)) {
        let particles = [mesh.positions, moved.positions].concat();
        let error = deepest.identity_error(|k| particles[k as usize]);
        println!("the deepest by {:.4} mm, right to {error:.0e} mm", -deepest.gap);
    }
    Ok(())
}

/// Returns true if `p` is inside, by ray parity.
fn is_inside(ball: &TriangleSurface, x: Positions<'_>, p: DVec3) -> bool {
    let crossings = ball.faces().iter().filter_map(|f| ray_crosses_triangle(p, x.corners(*f)));
    crossings.count() % 2 == 1
}

/// Computes the contact of a vertex of one ball with the closest point of the other, whose
/// particles are numbered after the first ball's; `None` on its surface.
fn contact(
    ball: &TriangleSurface,
    b: Positions<'_>,
    normals: &Pseudonormals,
    vertex: u32,
    p: DVec3,
) -> Option<Contact> {
    let feet = (0..).zip(ball.faces()).map(|(f, c)| (f, *c, closest_on_triangle(p, b.corners(*c))));
    let (number, face, foot) = feet
        .min_by(|(_, _, p1), (_, _, p2)| p.distance(p1.point).total_cmp(&p.distance(p2.point)))?;

    let gap = normals.signed_distance(ball, p, number, &foot);
    let normal = ((p - foot.point) * gap.signum()).try_normalize()?;
    let first_of_b = u32::try_from(ball.vertex_count()).ok()?;
    let stencil = Stencil::vertex_face(vertex, face.map(|k| first_of_b + k), foot.barycentric);
    Some(Contact { stencil, anchor: None, normal, offset: 0.0, gap, time: None })
}

fn count_crossings(ball: &TriangleSurface, a: Positions<'_>, b: Positions<'_>) -> usize {
    let mut count = 0;
    for &f in ball.faces() {
        for &g in ball.faces() {
            let meeting = triangles_meet(a.corners(f), b.corners(g));
            count += usize::from(meeting == Meeting::Crossing);
        }
    }
    count
}
