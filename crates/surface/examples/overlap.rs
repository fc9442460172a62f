//! Two balls overlap: inspects them, counts the faces that cross and the vertices
//! inside, and finds the deepest one.
//!
//! `cargo run --release -p surface --example overlap`
//!
//! Every face is compared with every other: enough for small surfaces, and the
//! answer that search trees must reproduce.

#![expect(clippy::print_stdout, reason = "an example shows what it found")]

use surface::glam::DVec3;
use surface::{
    Contact, Meeting, Positions, Pseudonormals, Stencil, SurfaceError, TriangleSurface,
    closest_on_triangle, inspect, ray_crosses_triangle, triangles_meet,
};

fn main() -> Result<(), SurfaceError> {
    let (ball, x) = ball(24, 12, 20.0)?;
    let moved: Vec<DVec3> = x.iter().map(|x| *x + DVec3::new(35.0, 3.0, -4.0)).collect();
    let (a, b) = (ball.positions(&x)?, ball.positions(&moved)?);

    let report = inspect(&ball, a);
    println!("{} faces, {:.1} mm³, defects: {:?}", report.faces, report.volume, report.findings);
    ball.require_closed()?;
    println!("{} pairs of faces cross", count_crossings(&ball, a, b));

    let inside = |p: &DVec3| {
        let passages = ball.faces().iter().filter_map(|f| ray_crosses_triangle(*p, b.corners(*f)));
        passages.count() % 2 == 1
    };
    let normals = Pseudonormals::new(&ball, b);
    let contacts: Vec<Contact> = (0..)
        .zip(&x)
        .filter(|(_, p)| inside(p))
        .filter_map(|(vertex, p)| contact(&ball, b, &normals, vertex, *p))
        .collect();
    println!("{} vertices are inside", contacts.len());
    if let Some(deepest) = contacts.iter().min_by(|p, q| p.gap.total_cmp(&q.gap)) {
        let particles = [x, moved].concat();
        let error = deepest.identity_error(|k| particles[k as usize]);
        println!("the deepest by {:.4} mm, right to {error:.0e} mm", -deepest.gap);
    }
    Ok(())
}

/// The contact of a vertex of one ball with the closest point of the other, whose
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
    let pairs = ball.faces().iter().flat_map(|f| ball.faces().iter().map(move |g| (f, g)));
    let cross = |(f, g): &(&[u32; 3], &[u32; 3])| {
        triangles_meet(a.corners(**f), b.corners(**g)) == Meeting::Crossing
    };
    pairs.filter(cross).count()
}

/// A ball about the origin, of `around` × `up` patches.
fn ball(around: u32, up: u32, radius: f64) -> Result<(TriangleSurface, Vec<DVec3>), SurfaceError> {
    use std::f64::consts::{PI, TAU};
    let mut x = vec![DVec3::NEG_Z * radius, DVec3::Z * radius];
    for i in 1..up {
        let (rho, z) = (PI * f64::from(i) / f64::from(up)).sin_cos();
        for j in 0..around {
            let (sin, cos) = (TAU * f64::from(j) / f64::from(around)).sin_cos();
            x.push(radius * DVec3::new(rho * cos, rho * sin, -z));
        }
    }
    let at = |i: u32, j: u32| match i {
        0 => 0,
        i if i == up => 1,
        i => 2 + (i - 1) * around + j % around,
    };
    let mut faces = Vec::new();
    for (i, j) in (0..up).flat_map(|i| (0..around).map(move |j| (i, j))) {
        let [a, b, c, d] = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        faces.extend(
            [[a, b, c], [a, c, d]].into_iter().filter(|[a, b, c]| a != b && b != c && c != a),
        );
    }
    Ok((TriangleSurface::new(x.len(), faces)?, x))
}
