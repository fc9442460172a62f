//! What medial surfaces cost, beside surfaces, on generated muscles: time to make
//! one, and tests and time to detect with it.

use std::process::ExitCode;
use std::time::{Duration, Instant};

use benches::ratio::{Ratio, Report, amount, interleave};
use fixtures::Mesh;
use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use medial::{
    FootRule, MedialContactParams, MedialParams, MedialSurface, ParticleOffsets, PrimitiveTree,
    QueryPoints, generate, point_contacts, primitive_contacts,
};
use surface::closest_on_triangle;

/// How far a vertex may be from the face it is projected on \[mm\].
const REACH: f64 = 1.0;

fn main() -> ExitCode {
    let mut report = Report::default();
    let [small, large] = [4, 5].map(belly);
    making(&small, 1.0, &mut report);
    let medial = making(&large, 6.0, &mut report);
    // Their middles overlap by 2 mm.
    let by = DVec3::new(11.0, 6.0, 23.0);
    let mut of_other = medial.clone();
    let centers: Vec<DVec3> = medial.balls().iter().map(|ball| ball.center + by).collect();
    of_other.set_centers(&centers).expect("as many balls");
    detecting([&large.clone().translated(by), &large], [&of_other, &medial], &mut report);
    report.finish()
}

/// A flat, bent belly, 240 mm long.
fn belly(subdivisions: u32) -> Mesh {
    fixtures::shapes::ellipsoid(DVec3::new(120.0, 40.0, 12.0), subdivisions)
        .mapped(|p| p + DVec3::Z * (0.002 * p.x * p.x + 3.0 * (p.y / 20.0).sin()))
}

/// Makes a hundred balls of it, within so many seconds.
fn making(mesh: &Mesh, seconds: f64, report: &mut Report) -> MedialSurface {
    let surface = mesh.surface();
    let x = surface.positions(&mesh.positions).expect("finite");
    let start = Instant::now();
    let made = generate(&surface, x, &MedialParams::balls(100), |_| {}).expect("closed");
    let took = start.elapsed().as_secs_f64();
    let faces = mesh.faces.len();
    report.add(&Ratio::new(&format!("100 balls of {faces} faces [s]"), took, seconds, "s", 1.0));
    let [out, over] = [made.deviation.surface_to_medial, made.deviation.medial_to_surface];
    for (way, bound) in [("surface to balls", out), ("balls to surface", over)] {
        let title = format!("{faces} faces, {way}, bound over seen");
        report.add(&Ratio::new(&title, bound.upper, bound.lower, "mm", 1.06));
    }
    made.medial
}

/// Compares both ways to detect by balls with projecting vertices on faces.
fn detecting(meshes: [&Mesh; 2], medials: [&MedialSurface; 2], report: &mut Report) {
    let [a, b] = meshes;
    let leaves = |mesh: &Mesh| {
        Tree::build(Leaves::Triangles(&mesh.faces), &mesh.positions).expect("finite positions")
    };
    let (of_a, of_b) = (leaves(a), leaves(b));
    let projected = |workspace: &mut Workspace| {
        let mut pairs = Vec::new();
        of_a.pairs(&of_b, REACH, workspace, |i, j| {
            pairs.extend(a.faces[i as usize].map(|vertex| (vertex, j)));
        });
        pairs.sort_unstable();
        pairs.dedup();
        let near = |&(vertex, face): &(u32, u32)| {
            let p = a.positions[vertex as usize];
            closest_on_triangle(p, b.corners(face as usize)).point.distance(p) < REACH
        };
        (pairs.len(), pairs.iter().filter(|pair| near(pair)).count())
    };
    let mut workspace = Workspace::default();
    let (leaf_tests, _) = projected(&mut workspace);
    let bound_tests = workspace.counters().bound_tests;

    let points = Tree::build(Leaves::Points, &a.positions).expect("finite positions");
    let probes = QueryPoints { tree: &points, points: &a.positions, radii: None };
    let [on_a, on_b] = medials.map(|medial| PrimitiveTree::new(medial).expect("finite balls"));
    let reach = MedialContactParams {
        rule: FootRule::Exact,
        max_contacts: 1,
        ..MedialContactParams::new(0.0)
    };
    let mut memory = [Workspace::default(), Workspace::default(), Workspace::default()];
    let [m0, m1, m2] = &mut memory;
    let mut vertices =
        || point_contacts(&probes, medials[1], &on_b, &reach, ParticleOffsets::default(), None, m0);
    let mut balls = || primitive_contacts((medials[0], &on_a), (medials[1], &on_b), 0.0, m1);
    let counts = [("vertices × balls", vertices().1), ("balls × balls", balls().1)];
    for ((method, counts), of_bounds) in counts.into_iter().zip([0.4, 0.25]) {
        let mut add = |what: &str, ours: u64, theirs: f64, allowed: f64| {
            let ours = amount(usize::try_from(ours).unwrap_or(usize::MAX));
            report.add(&Ratio::new(&format!("{method}, {what}"), ours, theirs, "", allowed));
        };
        let bounds = amount(usize::try_from(bound_tests).unwrap_or(usize::MAX));
        add("tests of bounds", counts.bound_tests, bounds, of_bounds);
        add("tests of leaves", counts.leaf_tests, amount(leaf_tests), 1.0 / 13.0);
    }
    let [by_vertices, by_balls, theirs] = interleave(
        Duration::from_millis(600),
        [&mut || vertices().0.len(), &mut || balls().0.len(), &mut || projected(m2).1],
    );
    report.add(&Ratio::of_times("vertices × balls, time", by_vertices, theirs, 0.5));
    report.add(&Ratio::of_times("balls × balls, time", by_balls, theirs, 0.5));
}
