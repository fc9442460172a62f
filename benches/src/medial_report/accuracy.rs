//! Accuracy of medial surfaces by number of balls.

use std::fmt::Write as _;
use std::thread;

use glam::DVec2;
use medial::{Generated, MedialParams, Topology, generate, generate_each};
use proximity::SurfaceTree;
use rayon::ThreadPoolBuilder;
use surface::progress::Progress;

use super::Muscles;
use super::sampling::{SampledDistances, sampled_distances};
use crate::bodies::bounds;
use crate::measure::{Report, as_f64, thread_time};

/// A number of balls, with the target of the error \[mm rms\].
#[derive(Clone, Copy)]
struct Size {
    balls: usize,
    target: Option<f64>,
}

const SIZES: [Size; 5] = [
    Size { balls: 25, target: None },
    Size { balls: 50, target: None },
    Size { balls: 100, target: Some(0.4) },
    Size { balls: 200, target: Some(0.2) },
    Size { balls: 400, target: Some(0.12) },
];

/// Number of balls whose time is bounded, and the bound \[s\].
const TIMED_BALLS: usize = 100;
const MAX_SECONDS: f64 = 6.0;

/// Spacing of the grid on which parts and holes are counted \[mm\].
const GRID: f64 = 1.0;

/// A muscle by a number of balls; lengths in mm.
pub(super) struct Row {
    name: String,
    faces: usize,
    /// Diagonal of the bounding box.
    extent: f64,
    balls: usize,
    slabs: usize,
    rms: f64,
    p95: f64,
    /// Bounds on the deviation in both directions.
    bounds: SampledDistances,
    sampled: SampledDistances,
    /// Topology of the union, where it is not that of the muscle.
    other_topology: Option<Topology>,
    /// Processor time to generate this number of balls alone \[s\].
    seconds: f64,
}

/// Measures muscles, as many at a time as there are threads, and reports bounds and targets.
pub(super) fn rows(muscles: &Muscles, report: &mut Report) -> Vec<Row> {
    // One thread per muscle; rows stay in the order of the names.
    let mut rows = Vec::new();
    for names in muscles.names().chunks(rayon::current_num_threads()) {
        thread::scope(|scope| {
            let mut running = Vec::new();
            for name in names {
                running.push(scope.spawn(|| muscle_rows(name, &muscles.read(name))));
            }
            for muscle in running {
                rows.extend(muscle.join().expect("no panic"));
            }
        });
    }
    for row in &rows {
        row.report(report);
    }
    rows
}

/// Measures one muscle on one thread, whose clock includes all of the work.
fn muscle_rows(name: &str, body: &SurfaceTree) -> Vec<Row> {
    let one_thread = ThreadPoolBuilder::new().num_threads(1).build().expect("a thread starts");
    one_thread.install(|| {
        // All sizes at once, with the same start.
        let (surface, x) = (body.surface(), body.positions());
        let sizes = SIZES.map(|size| size.balls);
        let all = generate_each(surface, x, &sizes, &MedialParams::balls(1), Progress::none());
        let topology = Topology::of_inside(surface, x).expect("a closed muscle");
        let mut rows = Vec::new();
        for generated in &all.expect("a closed muscle") {
            rows.push(Row::new(name, body, generated, topology));
        }
        rows
    })
}

/// Returns the processor time to generate a medial surface \[s\].
fn generation_seconds(body: &SurfaceTree, balls: usize) -> f64 {
    let start = thread_time();
    let params = MedialParams::balls(balls);
    generate(body.surface(), body.positions(), &params, Progress::none()).expect("a closed muscle");
    (thread_time() - start).as_secs_f64()
}

impl Row {
    fn new(name: &str, body: &SurfaceTree, generated: &Generated, topology: Topology) -> Self {
        let Generated { medial, deviation } = generated;
        let union = Topology::of_union(medial, GRID, Progress::none()).expect("the grid fits");
        let balls = medial.balls().len();
        Self {
            name: name.replace('_', " "),
            faces: body.surface().faces().len(),
            extent: bounds(body).diagonal(),
            balls,
            slabs: medial.slabs().len(),
            rms: deviation.rms,
            p95: deviation.p95,
            bounds: SampledDistances {
                surface_to_balls: deviation.surface_to_medial.upper,
                balls_to_surface: deviation.medial_to_surface.upper,
            },
            sampled: sampled_distances(body, medial),
            other_topology: (union != topology).then_some(union),
            seconds: generation_seconds(body, balls),
        }
    }

    fn target(&self) -> Option<f64> {
        SIZES.iter().find(|size| size.balls == self.balls)?.target
    }

    fn report(&self, report: &mut Report) {
        let name = |what: &str| format!("{} {} balls, {what}", self.name, self.balls);
        if let Some(target) = self.target() {
            report.ratio(name("rms"), [self.rms * 1e3, target * 1e3], "um", 1.0);
        }
        if self.balls == TIMED_BALLS {
            report.ratio(name("time"), [self.seconds, MAX_SECONDS], "s", 1.0);
        }

        // No sample may be farther than the bound.
        let Self { sampled, bounds, .. } = self;
        let outward = [sampled.surface_to_balls, bounds.surface_to_balls];
        report.ratio(name("surface to balls, sampled / bound"), outward, "mm", 1.0);
        let inward = [sampled.balls_to_surface, bounds.balls_to_surface];
        report.ratio(name("balls to surface, sampled / bound"), inward, "mm", 1.0);
    }

    fn line(&self) -> String {
        let topology = match self.other_topology {
            Some(Topology { components, tunnels, cavities, .. }) => {
                format!("{components} parts, {tunnels} tunnels, {cavities} cavities")
            }
            None => "as the muscle".to_owned(),
        };
        let Self { name, faces, extent, balls, slabs, rms, p95, bounds, sampled, seconds, .. } =
            self;
        let [outward, sampled_outward] = [bounds.surface_to_balls, sampled.surface_to_balls];
        let [inward, sampled_inward] = [bounds.balls_to_surface, sampled.balls_to_surface];
        format!(
            "| {name} | {faces} | {extent:.0} | {balls} | {slabs} | {rms:.3} | {p95:.3} \
             | {outward:.2} | {sampled_outward:.2} | {inward:.2} | {sampled_inward:.2} \
             | {topology} | {seconds:.1} |\n"
        )
    }
}

/// Formats the rows as a table, with a summary.
pub(super) fn table(rows: &[Row]) -> String {
    let mut text = String::from(
        "| muscle | faces | extent | balls | slabs | rms | 95 % | surface to balls | sampled | balls to surface | sampled | parts and holes | s |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|--:|\n",
    );
    text.extend(rows.iter().map(Row::line));
    text += &size_table(rows);
    text += &trends(rows);
    text
}

/// Formats the median and the maximum error per number of balls.
fn size_table(rows: &[Row]) -> String {
    let mut text = String::from(
        "\n| balls | rms, median muscle | rms, max | target | muscles within |\n|--:|--:|--:|--:|--:|\n",
    );
    for Size { balls, target } in SIZES {
        let mut errors = Vec::new();
        let mut within = 0;
        for row in rows.iter().filter(|row| row.balls == balls) {
            errors.push(row.rms);
            within += usize::from(target.is_some_and(|target| row.rms <= target));
        }

        // Sorted, so that the median is in the middle and the maximum at the end.
        errors.sort_by(f64::total_cmp);
        let Some(max) = errors.last() else { continue };
        let median = errors[errors.len() / 2];
        let (target, within) = match target {
            Some(target) => (target.to_string(), format!("{within} of {}", errors.len())),
            None => Default::default(),
        };
        // Writing into a string cannot fail.
        let _ = writeln!(text, "| {balls} | {median:.3} | {max:.3} | {target} | {within} |");
    }
    text
}

/// Formats the powers by which error and time grow.
fn trends(rows: &[Row]) -> String {
    // Times of one number of balls; errors of all.
    let (mut errors, mut relative, mut times) = (Vec::new(), Vec::new(), Vec::new());
    let mut max_seconds = 0.0_f64;
    for row in rows {
        errors.push([as_f64(row.balls), row.rms]);
        relative.push([as_f64(row.balls), row.rms / row.extent]);
        if row.balls == TIMED_BALLS {
            times.push([as_f64(row.faces), row.seconds]);
            max_seconds = max_seconds.max(row.seconds);
        }
    }
    let [error, relative, time] = [errors, relative, times].map(power);
    format!(
        "\nThe error falls with the number of balls to the power of {error:.2} ({relative:.2} relative to the muscles' extent).\n\
         The time for {TIMED_BALLS} balls alone grows with the number of faces to the power of {time:.2}; the maximum is {max_seconds:.1} s.\n"
    )
}

/// Fits `y ∝ x^p` to pairs, by least squares of their logarithms; returns `p`.
fn power(pairs: Vec<[f64; 2]>) -> f64 {
    // The slope of the line through the logarithms.
    let count = as_f64(pairs.len());
    let (mut sum, mut squares, mut products) = (DVec2::ZERO, 0.0, 0.0);
    for [x, y] in pairs {
        let p = DVec2::new(x.ln(), y.ln());
        sum += p;
        squares += p.x * p.x;
        products += p.x * p.y;
    }
    (count * products - sum.x * sum.y) / (count * squares - sum.x * sum.x)
}
