//! Tests, time and depths of medial detection beside that of surfaces, on
//! neighbouring muscles in contact.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::time::Duration;

use benches::bodies::Body;
use benches::ratio::{Ratio, Report, Timing, amount, interleave};
use kdop::{Leaves, Tree, Workspace};
use medial::{
    FootRule, MedialContactParams, MedialParams, MedialSurface, ParticleOffsets, PrimitiveTree,
    QueryPoints, TestCounts, generate_each, point_contacts, primitive_contacts,
};
use surface::closest_on_triangle;

use crate::data::muscle;
use crate::sampling::inside;

/// How far a vertex may be from the face it is projected on \[mm\]. Deeper ones
/// need more, on top of telling which vertices are inside.
const REACH: f64 = 1.0;

/// How far the first body is pushed into the other \[mm\]: at rest they touch.
const PUSHES: [f64; 2] = [1.0, 3.0];

/// Numbers of balls; on pairs that are looked at for the claims alone, 100.
const SIZES: [usize; 5] = [25, 50, 100, 200, 400];

/// Pairs of neighbours, and whether all sizes are looked at.
const PAIRS: [(&str, &str, bool); 4] = [
    ("gluteus_medius", "gluteus_maximus", true),
    ("iliacus", "psoas_major", true),
    ("gluteus_minimus", "gluteus_medius", false),
    ("semitendinosus", "semimembranosus", false),
];

/// Time that two sides share for one comparison.
const BUDGET: Duration = Duration::from_millis(150);

/// A table of counts, times, depths and misses for pairs of neighbours.
pub(crate) fn run(folder: &Path, report: &mut Report) -> String {
    let mut text = String::from(
        "| pair | push | method | balls | bounds | directions | leaves | µs | depth error rms | missed | deepest missed |\n\
         |---|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    let mut made = BTreeMap::new();
    for (a, b, all_sizes) in PAIRS {
        let [rest, other] = [a, b].map(|name| muscle(folder, name));
        for (name, body) in [(a, &rest), (b, &other)] {
            made.entry(name).or_insert_with(|| sizes(body, all_sizes));
        }
        let towards = (other.middle() - rest.middle()).normalize();
        for push in PUSHES {
            let moved = rest.moved(push * towards);
            let title = format!("{a} in {b} by {push} mm").replace('_', " ");
            let scene = Scene::new(title, [&moved, &other]);
            let row = format!("{} in {} | {push}", a.replace('_', " "), b.replace('_', " "));
            let surfaces = scene.by_surfaces(&row, &mut text);
            for (balls, medial) in &made[b] {
                if !all_sizes && *balls != 100 {
                    continue;
                }
                let of_a = made[a][balls].clone();
                let of_a = shifted(of_a, push * towards);
                scene.by_vertices(&row, *balls, medial, &surfaces, report, &mut text);
                scene.by_balls(&row, *balls, [&of_a, medial], &surfaces, report, &mut text);
            }
        }
    }
    text
}

fn sizes(body: &Body, all: bool) -> BTreeMap<usize, MedialSurface> {
    let x = body.surface.positions(&body.x).expect("finite positions");
    let sizes = if all { SIZES.to_vec() } else { vec![100] };
    let made = generate_each(&body.surface, x, &sizes, &MedialParams::balls(1), |_| {});
    let made = made.expect("a closed muscle").into_iter().map(|made| made.medial);
    sizes.into_iter().zip(made).collect()
}

fn shifted(mut medial: MedialSurface, by: glam::DVec3) -> MedialSurface {
    let centers: Vec<_> = medial.balls().iter().map(|ball| ball.center + by).collect();
    medial.set_centers(&centers).expect("as many balls");
    medial
}

/// A body pushed into another one.
struct Scene<'a> {
    title: String,
    points: &'a Body,
    other: &'a Body,
    faces: [Tree; 2],
    tree: Tree,
    /// Vertices that are inside, with their depths.
    truth: BTreeMap<u32, f64>,
}

/// What surface detection takes.
struct Surfaces {
    bound_tests: f64,
    leaf_tests: f64,
}

impl<'a> Scene<'a> {
    fn new(title: String, [points, other]: [&'a Body; 2]) -> Self {
        let leaves = |body: &Body| {
            Tree::build(Leaves::Triangles(body.surface.faces()), &body.x).expect("finite positions")
        };
        let tree = Tree::build(Leaves::Points, &points.x).expect("finite positions");
        let faces = [points, other].map(leaves);
        Self { title, points, other, faces, tree, truth: inside(points, other) }
    }

    /// Faces of one against faces of the other, and their vertices against these.
    fn by_surfaces(&self, row: &str, text: &mut String) -> Surfaces {
        let workspace = &mut Workspace::default();
        let pairs = self.candidates(workspace).len();
        let bound_tests = workspace.counters().bound_tests;
        let [time] = interleave(BUDGET, [&mut || self.projected(workspace)]);
        let _ = writeln!(
            text,
            "| {row} | surfaces | | {bound_tests} | | {pairs} | {:.0} | | 0 of {} | |",
            time.least * 1e-3,
            self.truth.len()
        );
        Surfaces { bound_tests: as_f64(bound_tests), leaf_tests: amount(pairs) }
    }

    /// Vertices of one body's faces with faces of the other whose bounds come within
    /// [`REACH`], each pair once: what is projected without medial surfaces.
    fn candidates(&self, workspace: &mut Workspace) -> Vec<(u32, u32)> {
        let mut pairs = Vec::new();
        let [faces, other] = &self.faces;
        faces.pairs(other, REACH, workspace, |a, b| {
            pairs.extend(self.points.surface.faces()[a as usize].map(|vertex| (vertex, b)));
        });
        pairs.sort_unstable();
        pairs.dedup();
        pairs
    }

    fn projected(&self, workspace: &mut Workspace) -> usize {
        let near = |&(vertex, face): &(u32, u32)| {
            let (p, corners) = (self.points.x[vertex as usize], self.other.corners(face));
            closest_on_triangle(p, corners).point.distance(p) < REACH
        };
        self.candidates(workspace).iter().filter(|pair| near(pair)).count()
    }

    /// Vertices of one against the balls of the other, by both rules.
    fn by_vertices(
        &self,
        row: &str,
        balls: usize,
        medial: &MedialSurface,
        surfaces: &Surfaces,
        report: &mut Report,
        text: &mut String,
    ) {
        let probes = QueryPoints { tree: &self.tree, points: &self.points.x, radii: None };
        let on = PrimitiveTree::new(medial).expect("finite balls");
        let workspace = &mut Workspace::default();
        let mut other_workspace = Workspace::default();
        for (rule, name) in [(FootRule::Exact, "exact"), (FootRule::BareFace, "bare face")] {
            let reach =
                MedialContactParams { rule, max_contacts: 1, ..MedialContactParams::new(0.0) };
            let particles = ParticleOffsets::default();
            let mut detect =
                || point_contacts(&probes, medial, &on, &reach, particles, None, workspace);
            let (found, counts) = detect();
            let [ours, theirs] = interleave(
                BUDGET,
                [&mut || detect().0.len(), &mut || self.projected(&mut other_workspace)],
            );
            let depths: BTreeMap<u32, f64> =
                found.iter().map(|c| (c.stencil.terms()[0].particle, -c.gap)).collect();
            let _ = writeln!(
                text,
                "| {row} | vertices × balls, {name} | {balls} | {} | {} | {} | {:.0} | {} |",
                counts.bound_tests,
                counts.direction_tests,
                counts.leaf_tests,
                ours.least * 1e-3,
                self.errors(&depths),
            );
            if rule == FootRule::Exact && balls == 100 {
                self.report("vertices × balls", &counts, surfaces, [ours, theirs], report);
            }
        }
    }

    /// Error of the depths that were found, what was missed, and how deep.
    fn errors(&self, found: &BTreeMap<u32, f64>) -> String {
        let (mut squares, mut count, mut missed, mut deepest) = (0.0, 0, 0, 0.0_f64);
        for (vertex, depth) in &self.truth {
            match found.get(vertex) {
                Some(found) => {
                    squares += (found - depth).powi(2);
                    count += 1;
                }
                None => {
                    missed += 1;
                    deepest = deepest.max(*depth);
                }
            }
        }
        let rms = (squares / amount(count)).sqrt();
        format!("{rms:.3} | {missed} of {} | {deepest:.3}", self.truth.len())
    }

    /// Balls of one against the balls of the other.
    fn by_balls(
        &self,
        row: &str,
        balls: usize,
        [a, b]: [&MedialSurface; 2],
        surfaces: &Surfaces,
        report: &mut Report,
        text: &mut String,
    ) {
        let [on_a, on_b] = [a, b].map(|m| PrimitiveTree::new(m).expect("finite balls"));
        let workspace = &mut Workspace::default();
        let mut other_workspace = Workspace::default();
        let mut detect = || primitive_contacts((a, &on_a), (b, &on_b), 0.0, workspace);
        let (_, counts) = detect();
        let [ours, theirs] = interleave(
            BUDGET,
            [&mut || detect().0.len(), &mut || self.projected(&mut other_workspace)],
        );
        let _ = writeln!(
            text,
            "| {row} | balls × balls | {balls} | {} | {} | {} | {:.0} | | | |",
            counts.bound_tests,
            counts.direction_tests,
            counts.leaf_tests,
            ours.least * 1e-3
        );
        if balls == 100 {
            self.report("balls × balls", &counts, surfaces, [ours, theirs], report);
        }
    }

    fn report(
        &self,
        method: &str,
        counts: &TestCounts,
        surfaces: &Surfaces,
        [ours, theirs]: [Timing; 2],
        report: &mut Report,
    ) {
        let name = |what: &str| format!("{}, 100 balls, {method}, {what}", self.title);
        let bounds = as_f64(counts.bound_tests);
        report.add(&Ratio::new(&name("bounds"), bounds, surfaces.bound_tests, "", 0.25));
        let leaves = as_f64(counts.leaf_tests);
        report.add(&Ratio::new(&name("leaves"), leaves, surfaces.leaf_tests, "", 1.0 / 13.0));
        report.add(&Ratio::of_times(&name("time"), ours, theirs, 1.0));
    }
}

#[expect(clippy::cast_precision_loss, reason = "counts stay far below 2^52")]
fn as_f64(count: u64) -> f64 {
    count as f64
}
