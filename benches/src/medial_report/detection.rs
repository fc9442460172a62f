//! Detection by medial surfaces beside that by surfaces, on neighboring muscles in contact: tests,
//! times and depths.

use std::collections::BTreeMap;

use medial::{FootRule, MedialParams, generate_each};
use proximity::SurfaceTree;
use surface::Contact;
use surface::progress::Progress;

use super::Muscles;
use crate::bodies::{mean, moved, points_inside};
use crate::measure::{Report, as_f64};
use crate::medial_contact::{Balls, ContactScene, MethodWork, WorkLimits};

/// Distances by which the first muscle is pushed into the other \[mm\]: at rest they touch.
const PUSHES: [f64; 2] = [1.0, 3.0];

/// Numbers of balls.
const SIZES: [usize; 5] = [25, 50, 100, 200, 400];

/// Number of balls whose work is bounded.
const BOUNDED_SIZE: usize = 100;

/// Two neighboring muscles.
struct Neighbors {
    first: &'static str,
    other: &'static str,
    sizes: &'static [usize],
}

const PAIRS: [Neighbors; 4] = [
    Neighbors { first: "gluteus_medius", other: "gluteus_maximus", sizes: &SIZES },
    Neighbors { first: "iliacus", other: "psoas_major", sizes: &SIZES },
    Neighbors { first: "gluteus_minimus", other: "gluteus_medius", sizes: &[BOUNDED_SIZE] },
    Neighbors { first: "semitendinosus", other: "semimembranosus", sizes: &[BOUNDED_SIZE] },
];

const LIMITS: WorkLimits = WorkLimits { bounds: 0.25, leaves: 1.0 / 13.0, time: 1.0 };

/// Budget of each comparison \[ms\].
const BUDGET: u64 = 150;

/// Formats counts, times, depths and misses for pairs of neighbors.
pub(super) fn table(muscles: &Muscles, report: &mut Report) -> String {
    let mut text = String::from(
        "| pair | push | method | balls | bounds | directions | leaves | µs | depth error rms | missed | deepest missed |\n\
         |---|--:|---|--:|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for Neighbors { first, other, sizes } in PAIRS {
        let (rest, other_body) = (muscles.read(first), muscles.read(other));
        let (first_balls, other_balls) = (balls(&rest, sizes), balls(&other_body, sizes));
        let centers = [&rest, &other_body].map(|body| mean(body.positions().as_slice()));
        let toward = (centers[1] - centers[0]).normalize();

        // Both the surface and its balls are pushed.
        for push in PUSHES {
            let pushed = moved(&rest, push * toward);
            let title = format!("{first} in {other}").replace('_', " ");
            let scene = PushedScene::new(title, push, &pushed, &other_body, report);
            text += &scene.projection_row();
            for (size, balls) in sizes.iter().zip(first_balls.iter().zip(&other_balls)) {
                let balls = [&balls.0.moved(push * toward), balls.1];
                text += &scene.ball_rows(*size, balls, report);
            }
        }
    }
    text
}

fn balls(body: &SurfaceTree, sizes: &[usize]) -> Vec<Balls> {
    let (surface, x) = (body.surface(), body.positions());
    let all = generate_each(surface, x, sizes, &MedialParams::balls(1), Progress::none());
    all.expect("a closed muscle").into_iter().map(|made| Balls::new(made.medial)).collect()
}

/// A body pushed into another one.
struct PushedScene<'a> {
    title: String,
    push: f64,
    scene: ContactScene<'a>,
    /// Counts and time \[ns\] of the projection on faces.
    projection: MethodWork,
    /// Vertices inside, with their depths.
    truth: BTreeMap<u32, f64>,
}

impl<'a> PushedScene<'a> {
    fn new(
        title: String,
        push: f64,
        points: &'a SurfaceTree,
        other: &'a SurfaceTree,
        report: &mut Report,
    ) -> Self {
        let scene = ContactScene::new(points, other);
        let projection = scene.projection(BUDGET, report);
        let truth = points_inside(points.positions().as_slice(), other);
        Self { title, push, scene, projection, truth }
    }

    fn projection_row(&self) -> String {
        self.row("surfaces", "", "", &self.projection, &format!(" | 0 of {} |", self.truth.len()))
    }

    /// Formats the rows of one number of balls, and reports those that are bounded.
    fn ball_rows(&self, size: usize, [a, b]: [&Balls; 2], report: &mut Report) -> String {
        let mut text = String::new();
        let balls = size.to_string();
        for (rule, name) in [(FootRule::Exact, "exact"), (FootRule::BareFace, "bare face")] {
            let work = self.scene.vertices_in_balls(b, rule, BUDGET, report);
            let directions = work.counts.direction_tests.to_string();
            let method = format!("vertices × balls, {name}");
            text += &self.row(&method, &balls, &directions, &work, &self.errors(&work.contacts));
            if rule == FootRule::Exact {
                self.report(size, "vertices × balls", &work, report);
            }
        }

        let work = self.scene.balls_in_balls([a, b], BUDGET, report);
        let directions = work.counts.direction_tests.to_string();
        text += &self.row("balls × balls", &balls, &directions, &work, " | |");
        self.report(size, "balls × balls", &work, report);
        text
    }

    fn row(
        &self,
        method: &str,
        balls: &str,
        directions: &str,
        work: &MethodWork,
        errors: &str,
    ) -> String {
        let Self { title, push, .. } = self;
        let MethodWork { counts, times, .. } = work;
        let (bounds, leaves, time) = (counts.bound_tests, counts.leaf_tests, times[0] * 1e-3);
        format!(
            "| {title} | {push} | {method} | {balls} | {bounds} | {directions} | {leaves} | {time:.0} | {errors} |\n"
        )
    }

    /// Formats the error of the depths found, the vertices missed, and their maximum depth.
    fn errors(&self, contacts: &[Contact]) -> String {
        let found: BTreeMap<u32, f64> =
            contacts.iter().map(|c| (c.stencil.terms()[0].particle, -c.gap)).collect();

        // Depths of vertices that are found, and how deep those are that are not.
        let (mut squares, mut count, mut missed, mut deepest) = (0.0, 0, 0, 0.0_f64);
        for (vertex, depth) in &self.truth {
            if let Some(found) = found.get(vertex) {
                squares += (found - depth).powi(2);
                count += 1;
            } else {
                missed += 1;
                deepest = deepest.max(*depth);
            }
        }
        let rms = (squares / as_f64(count)).sqrt();
        format!("{rms:.3} | {missed} of {} | {deepest:.3}", self.truth.len())
    }

    fn report(&self, size: usize, method: &str, work: &MethodWork, report: &mut Report) {
        if size == BOUNDED_SIZE {
            let name = format!("{} by {} mm, {size} balls, {method}", self.title, self.push);
            work.report(&name, &self.projection.counts, LIMITS, report);
        }
    }
}
