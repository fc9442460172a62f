//! How near a medial surface comes, by number of balls.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use benches::bodies::{Body, Depth};
use benches::clock::running;
use benches::ratio::{Ratio, Report, amount};
use medial::{Generated, MedialParams, Progress, Step, Topology, generate, generate_each};
use rayon::ThreadPoolBuilder;

use crate::data::muscle;
use crate::sampling::fresh;

/// Numbers of balls, with the error \[mm rms\] that is aimed at.
const SIZES: [(usize, Option<f64>); 5] =
    [(25, None), (50, None), (100, Some(0.4)), (200, Some(0.2)), (400, Some(0.12))];

/// Spacing \[mm\] of the grid on which parts and holes are counted.
const GRID: f64 = 1.0;

/// A muscle by a number of balls; lengths in mm.
pub(crate) struct Row {
    name: String,
    faces: usize,
    /// Diagonal of the box around the muscle.
    extent: f64,
    balls: usize,
    slabs: usize,
    rms: f64,
    p95: f64,
    /// Bounds of both directions, surface to balls first.
    bounds: [f64; 2],
    /// What samples showed.
    fresh: [f64; 2],
    /// That of the union, where it is not that of the muscle.
    topology: Option<Topology>,
    /// Time of the processor \[s\] that it took, with what sizes have in common.
    seconds: f64,
    /// The same, if this size alone is made.
    alone: Option<f64>,
}

/// Measures every muscle, two at a time, and reports what is beyond its bound or
/// its aim.
pub(crate) fn run(
    folder: &Path,
    names: &[String],
    sizes: &[usize],
    report: &mut Report,
) -> Vec<Row> {
    let of_muscle = |name: &String| {
        let rows = rows(name, &muscle(folder, name), sizes);
        println!("{}", rows.iter().map(Row::line).collect::<String>());
        rows
    };
    let next = AtomicUsize::new(0);
    // A pool of one thread each, so that its clock sees all of the work.
    let worker = || {
        let one = ThreadPoolBuilder::new().num_threads(1).build().expect("one thread");
        let mut done = Vec::new();
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            let Some(name) = names.get(k) else { return done };
            done.push((k, one.install(|| of_muscle(name))));
        }
    };
    let mut of_muscles = std::thread::scope(|scope| {
        let workers: Vec<_> =
            (0..rayon::current_num_threads()).map(|_| scope.spawn(worker)).collect();
        workers.into_iter().flat_map(|w| w.join().expect("no panic")).collect::<Vec<_>>()
    });
    of_muscles.sort_by_key(|&(k, _)| k);
    let rows: Vec<Row> = of_muscles.into_iter().flat_map(|(_, rows)| rows).collect();
    for row in &rows {
        row.report(report);
    }
    rows
}

/// Numbers of balls of the tables.
pub(crate) fn sizes() -> Vec<usize> {
    SIZES.iter().map(|&(balls, _)| balls).collect()
}

fn rows(name: &str, body: &Body, sizes: &[usize]) -> Vec<Row> {
    let x = body.surface.positions(&body.x).expect("finite positions");
    let mut clock = Clock::default();
    let made = generate_each(&body.surface, x, sizes, &MedialParams::balls(1), |at| clock.tick(at));
    let made = made.expect("a closed muscle");
    let seconds = clock.seconds(sizes);
    let inside = Topology::of_inside(&body.surface, x).expect("closed");
    let depth = Depth::new(body);
    let row = |(made, seconds): (Generated, f64)| {
        let topology = Topology::of_union(&made.medial, GRID).expect("a fitting grid");
        let (balls, deviation) = (made.medial.balls().len(), &made.deviation);
        Row {
            name: name.to_owned(),
            faces: body.surface.faces().len(),
            extent: body.extent(),
            balls,
            slabs: made.medial.slabs().len(),
            rms: deviation.rms,
            p95: deviation.p95,
            bounds: [deviation.surface_to_medial.upper, deviation.medial_to_surface.upper],
            fresh: fresh(body, &depth, &made.medial),
            topology: (topology != inside).then_some(topology),
            seconds,
            alone: (balls == 100).then(|| alone(body, balls)),
        }
    };
    made.into_iter().zip(seconds).map(row).collect()
}

/// Time of the processor to make a medial surface \[s\].
pub(crate) fn alone(body: &Body, balls: usize) -> f64 {
    let x = body.surface.positions(&body.x).expect("finite positions");
    let start = running().as_secs_f64();
    generate(&body.surface, x, &MedialParams::balls(balls), |_| {}).expect("a closed muscle");
    running().as_secs_f64() - start
}

/// Where the time of a run for several sizes goes.
#[derive(Default)]
struct Clock {
    at: Option<(Option<usize>, f64)>,
    /// Of what is common to all sizes.
    common: f64,
    /// Of merging down to a size, which also smaller ones need.
    collapse: BTreeMap<usize, f64>,
    /// Of fitting and measuring a size.
    own: BTreeMap<usize, f64>,
}

impl Clock {
    fn tick(&mut self, progress: Progress) {
        let now = running().as_secs_f64();
        self.stop(now);
        let is_common = matches!(progress.step, Step::Inspect | Step::Shrink);
        let merging = progress.step == Step::Collapse;
        self.at = Some(((!is_common).then_some(progress.balls << 1 | usize::from(merging)), now));
    }

    fn stop(&mut self, now: f64) {
        match self.at {
            None => {}
            Some((None, since)) => self.common += now - since,
            Some((Some(key), since)) => {
                let map = if key & 1 == 1 { &mut self.collapse } else { &mut self.own };
                *map.entry(key >> 1).or_default() += now - since;
            }
        }
    }

    fn seconds(mut self, sizes: &[usize]) -> Vec<f64> {
        self.stop(running().as_secs_f64());
        let seconds = |&size: &usize| {
            self.common + self.own[&size] + self.collapse.range(size..).map(|(_, s)| s).sum::<f64>()
        };
        sizes.iter().map(seconds).collect()
    }
}

impl Row {
    /// The error aimed at \[mm rms\].
    fn aim(&self) -> Option<f64> {
        SIZES.iter().find(|(balls, _)| *balls == self.balls)?.1
    }

    fn misses(&self) -> bool {
        self.aim().is_some_and(|aim| self.rms > aim)
    }

    /// A line of a table.
    fn line(&self) -> String {
        let rms = format!("{:.3}", self.rms);
        let rms = if self.misses() { format!("**{rms}**") } else { rms };
        let topology = self.topology.map_or_else(
            || "as the muscle".to_owned(),
            |t| format!("{} parts, {} tunnels, {} cavities", t.components, t.tunnels, t.cavities),
        );
        format!(
            "| {} | {} | {:.0} | {} | {} | {rms} | {:.3} | {:.2} | {:.2} | {:.2} | {:.2} | {topology} | {:.1} |\n",
            self.name.replace('_', " "),
            self.faces,
            self.extent,
            self.balls,
            self.slabs,
            self.p95,
            self.bounds[0],
            self.fresh[0],
            self.bounds[1],
            self.fresh[1],
            self.seconds,
        )
    }

    fn report(&self, report: &mut Report) {
        let title = |what: &str| format!("{} {} balls, {what}", self.name, self.balls);
        if let Some(aim) = self.aim() {
            report.add(&Ratio::new(&title("rms / um"), self.rms * 1e3, aim * 1e3, "um", 1.0));
        }
        if let Some(seconds) = self.alone {
            report.add(&Ratio::new(&title("time"), seconds, 6.0, "s", 1.0));
        }
        for (way, [sampled, bound]) in ["out", "over"]
            .into_iter()
            .zip([[self.fresh[0], self.bounds[0]], [self.fresh[1], self.bounds[1]]])
        {
            if sampled > bound {
                let title = title(&format!("{way} beyond its bound"));
                report.add(&Ratio::new(&title, sampled, bound, "mm", 1.0));
            }
        }
    }
}

/// The rows as a table, and what they show.
pub(crate) fn document(rows: &[Row]) -> String {
    let mut text = String::from(
        "| muscle | faces | extent | balls | slabs | rms | 95 % | surface to balls | sampled | balls to surface | sampled | parts and holes | s |\n\
         |---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|--:|\n",
    );
    text.extend(rows.iter().map(Row::line));
    text + &summary(rows)
}

fn summary(rows: &[Row]) -> String {
    let mut text = String::new();
    let mut by_size = String::from(
        "\n| balls | rms of the median muscle | of the worst | aimed at | muscles within |\n|--:|--:|--:|--:|--:|\n",
    );
    for (balls, aim) in SIZES {
        let mut all: Vec<f64> = rows.iter().filter(|r| r.balls == balls).map(|r| r.rms).collect();
        all.sort_by(f64::total_cmp);
        let Some(worst) = all.last() else { continue };
        let within = aim.map_or_else(String::new, |aim| {
            format!("{} of {}", all.iter().filter(|rms| **rms <= aim).count(), all.len())
        });
        let aim = aim.map_or_else(String::new, |aim| aim.to_string());
        let _ = writeln!(
            by_size,
            "| {balls} | {:.3} | {worst:.3} | {aim} | {within} |",
            all[all.len() / 2]
        );
    }
    text.push_str(&by_size);
    let slope = |points: Vec<(f64, f64)>| slope(&points);
    let balls = slope(rows.iter().map(|r| (amount(r.balls), r.rms)).collect());
    let relative = slope(rows.iter().map(|r| (amount(r.balls), r.rms / r.extent)).collect());
    let alone = rows.iter().filter_map(|r| Some((amount(r.faces), r.alone?)));
    let faces = slope(alone.clone().collect());
    let longest = alone.map(|(_, s)| s).fold(0.0, f64::max);
    let _ = writeln!(
        text,
        "\nThe error falls with the number of balls to the power of {balls:.2} ({relative:.2} relative to the muscles' extent).\n\
         The time for 100 balls alone grows with the number of faces to the power of {faces:.2}; the longest is {longest:.1} s."
    );
    let missed: Vec<&Row> = rows.iter().filter(|row| row.misses()).collect();
    if !missed.is_empty() {
        let _ = writeln!(text, "\nBeyond what is aimed at (bold):");
        for row in missed {
            let name = row.name.replace('_', " ");
            let _ = writeln!(
                text,
                "- {name}, {} balls: {:.3} mm, of an extent of {:.0} mm.",
                row.balls, row.rms, row.extent
            );
        }
    }
    text
}

/// Slope of the logarithms of pairs, by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |f: fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / amount(logs.len());
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let over = logs.iter().map(|p| (p.0 - x) * (p.1 - y)).sum::<f64>();
    over / logs.iter().map(|p| (p.0 - x).powi(2)).sum::<f64>()
}
