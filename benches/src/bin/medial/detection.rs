//! Tests and time of medial detection beside that of surfaces, on neighbouring
//! muscles in contact.

use std::path::Path;
use std::time::Duration;

use benches::ratio::{Ratio, Report, amount, interleave};
use glam::DVec3;
use kdop::{Leaves, Tree, Workspace};
use medial::{
    FootRule, MedialSurface, Params, Particles, PrimitiveTree, Probes, Reach, contacts, generate,
};
use surface::{closest_on_triangle, winding_number};

use crate::data::{Body, muscle};

/// How far a vertex may be from the face it is projected on \[mm\]. Deeper ones
/// need more, on top of telling which vertices are inside.
const REACH: f64 = 1.0;

/// How far the first body is pushed into the other \[mm\]: at rest they touch.
const PUSH: f64 = 3.0;

/// Prints counts, misses and times for pairs of neighbours.
pub(crate) fn run(folder: &Path, report: &mut Report) {
    println!(
        "pair\tballs\trule\tbound tests\tleaf tests\tsurface's\tsurface's\tmissed\tdeepest missed"
    );
    for (a, b) in [("gluteus_medius", "gluteus_maximus"), ("iliacus", "psoas_major")] {
        let [mut points, other] = [a, b].map(|name| muscle(folder, name));
        let towards = (other.middle() - points.middle()).normalize();
        points.x.iter_mut().for_each(|p| *p += PUSH * towards);
        let truth = inside(&points, &other);
        for balls in [100, 200, 400] {
            pair(&format!("{a} in {b}"), [&points, &other], balls, &truth, report);
        }
    }
}

fn pair(
    title: &str,
    [points, other]: [&Body; 2],
    balls: usize,
    truth: &[(u32, f64)],
    report: &mut Report,
) {
    let x = other.surface.positions(&other.x).expect("finite positions");
    let params = Params::balls(balls);
    let medial = generate(&other.surface, x, &params, |_| {}).expect("closed").medial;
    let leaves = |body: &Body| {
        Tree::build(Leaves::Triangles(body.surface.faces()), &body.x).expect("finite positions")
    };
    let [faces, other_faces] = [points, other].map(leaves);
    let tree = Tree::build(Leaves::Points, &points.x).expect("finite positions");
    let probes = Probes { tree: &tree, points: &points.x, radii: None };
    let on = PrimitiveTree::new(&medial).expect("finite balls");
    let workspace = &mut Workspace::default();
    let candidates = candidates(&faces, &other_faces, points, workspace);
    let surfaces = workspace.counters();
    for rule in [FootRule::Exact, FootRule::BareFace] {
        let reach = Reach { rule, ..Reach::new(0.0) };
        let (found, counts) = detect(&probes, &medial, &on, &reach, workspace);
        let missed = truth.iter().filter(|(p, _)| !found.contains(p));
        let deepest = missed.clone().map(|(_, depth)| *depth).fold(0.0, f64::max);
        println!(
            "{title}\t{balls}\t{rule:?}\t{}\t{}\t{}\t{}\t{} of {}\t{deepest:.3}",
            counts.bound_tests,
            counts.leaf_tests,
            surfaces.quad_tests,
            candidates.len(),
            missed.count(),
            truth.len(),
        );
        if rule == FootRule::Exact && balls == 100 {
            let name = |what: &str| format!("{title}, {what} tests at 100 balls");
            let [bound, leaf] = [counts.bound_tests, counts.leaf_tests].map(as_f64);
            let theirs = as_f64(surfaces.quad_tests);
            report.add(&Ratio::new(&name("bound"), bound, theirs, "", 0.25));
            let theirs = amount(candidates.len());
            report.add(&Ratio::new(&name("leaf"), leaf, theirs, "", 1.0 / 13.0));
        }
    }
    let mut other_workspace = Workspace::default();
    let [ours, theirs] = interleave(
        Duration::from_secs(1),
        [&mut || detect(&probes, &medial, &on, &Reach::new(0.0), workspace).0.len(), &mut || {
            let pairs = self::candidates(&faces, &other_faces, points, &mut other_workspace);
            let near = |&(vertex, face): &(u32, u32)| {
                let (p, corners) = (points.x[vertex as usize], other.corners(face));
                closest_on_triangle(p, corners).point.distance(p) < REACH
            };
            pairs.iter().filter(|pair| near(pair)).count()
        }],
    );
    report.add(&Ratio::of_times(&format!("{title}, {balls} balls, time"), ours, theirs, 1.0));
}

/// Vertices of one body's faces with faces of the other whose bounds come within
/// [`REACH`], each pair once: what is projected without medial surfaces.
fn candidates(
    faces: &Tree,
    other: &Tree,
    points: &Body,
    workspace: &mut Workspace,
) -> Vec<(u32, u32)> {
    let mut pairs = Vec::new();
    faces.pairs(other, REACH, workspace, |a, b| {
        pairs.extend(points.surface.faces()[a as usize].map(|vertex| (vertex, b)));
    });
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// Numbers of the points found, and how much work it was.
fn detect(
    probes: &Probes<'_>,
    medial: &MedialSurface,
    tree: &PrimitiveTree,
    reach: &Reach,
    workspace: &mut Workspace,
) -> (Vec<u32>, medial::Counts) {
    let (found, counts) =
        contacts(probes, medial, tree, reach, Particles::default(), None, workspace);
    (found.iter().map(|contact| contact.stencil.terms()[0].particle).collect(), counts)
}

/// Vertices of one body inside the other, with their depths.
fn inside(points: &Body, other: &Body) -> Vec<(u32, f64)> {
    let x = other.surface.positions(&other.x).expect("finite positions");
    let low = other.x.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
    let high = other.x.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
    let tree = Tree::build(Leaves::Triangles(other.surface.faces()), &other.x);
    let tree = tree.expect("finite positions");
    let workspace = &mut Workspace::default();
    let mut inside = Vec::new();
    for (vertex, &p) in (0_u32..).zip(&points.x) {
        let boxed = p.cmpge(low).all() && p.cmple(high).all();
        if boxed && winding_number(&other.surface, x, p) > 0.5 {
            let mut depth = f64::INFINITY;
            tree.nearest(p, depth, workspace, |face, _| {
                let corners = x.corners(other.surface.faces()[face as usize]);
                depth = depth.min(closest_on_triangle(p, corners).point.distance(p));
                depth
            });
            inside.push((vertex, depth));
        }
    }
    inside
}

#[expect(clippy::cast_precision_loss, reason = "counts stay far below 2^52")]
fn as_f64(count: u64) -> f64 {
    count as f64
}
