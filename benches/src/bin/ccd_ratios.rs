//! Continuous collision queries beside other methods: time, misses, late answers.
//!
//! Reads the query files in the folder `ccd` of the folder that the environment
//! variable `MUSCULO_DATA` names; without it, times queries made at random.
//! One line a figure: name, ours, the other's, ratio, allowed, verdict.

#![expect(clippy::print_stdout, reason = "a program that prints a table")]

use std::io;
use std::path::PathBuf;
use std::process::ExitCode;

use benches::ccd::measure::{Answers, as_f64, mean_times, nanoseconds, worst_time};
use benches::ccd::methods::{certified, del_geo, interval_subdivision, plain_cubic};
use benches::ccd::queries::{Kind, Query, QuerySet, made, read};
use ccd::{CcdParams, MovingPoints};

fn main() -> io::Result<ExitCode> {
    let mut table = Table::default();
    for (set, limits) in sets()? {
        compare(&set, &limits, &mut table);
    }
    Ok(if table.short == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// What is allowed of a set of queries; infinite where nothing is promised.
#[derive(Clone, Copy)]
struct Limits {
    /// Time, in times of the uncertified cubic's of `del-geo-core`.
    time: f64,
    /// False alarms without and with exact arithmetic.
    false_alarms: [f64; 2],
    /// Median and 99th percentile of how early times are \[share of the step\].
    earliness: [f64; 2],
}

const ANY: f64 = f64::INFINITY;

/// Broad-phase candidates of simulations, nearly all without contact.
const CANDIDATES: Limits = Limits { time: 1.0, false_alarms: [0.0, 0.0], earliness: [1e-12, 1e-8] };
/// Contacts of simulations.
const CONTACTS: Limits = Limits { time: 1.6, ..CANDIDATES };
/// Cases built to be degenerate: only safety and exactness are promised.
const DEGENERATE: Limits = Limits { time: ANY, false_alarms: [ANY, 0.0], earliness: [ANY, ANY] };

fn sets() -> io::Result<Vec<(QuerySet, Limits)>> {
    let Some(data) = std::env::var_os("MUSCULO_DATA") else {
        println!("MUSCULO_DATA is not set: queries made at random instead of published ones");
        let kinds = [Kind::VertexFace, Kind::EdgeEdge];
        return Ok(kinds.map(|kind| (made(kind, 20_000), DEGENERATE)).into());
    };
    let folder = PathBuf::from(data).join("ccd");
    let files = [
        ("full/simbp", CANDIDATES),
        ("full/simhard", CONTACTS),
        ("handcrafted", DEGENERATE),
        ("adversarial", DEGENERATE),
        ("vertextouch", DEGENERATE),
    ];
    let named = |(name, limits)| ["vf", "ee"].map(|kind| (format!("{name}_{kind}"), limits));
    let all = files.into_iter().flat_map(named);
    all.map(|(name, limits)| Ok((read(&folder, &name)?, limits))).collect()
}

/// The lines of the table, printed as they come.
#[derive(Default)]
struct Table {
    short: usize,
}

impl Table {
    fn row(&mut self, name: &str, ours: f64, other: Option<f64>, allowed: f64) {
        let measured = other.map_or(ours, |other| ours / other);
        let verdict = if measured <= allowed { "ok" } else { "SHORT" };
        self.short += usize::from(measured > allowed);
        let other = other.map_or("-".to_owned(), number);
        let (ours, measured, allowed) = (number(ours), number(measured), number(allowed));
        println!("{name:<46}{ours:>10}{other:>10}{measured:>10}{allowed:>10}  {verdict}");
    }
}

/// Four digits, as short as they can be written.
fn number(value: f64) -> String {
    match value {
        v if v == ANY => "-".to_owned(),
        v if v.fract() == 0.0 && v.abs() < 1e6 => format!("{v:.0}"),
        v if (1e-2..1e6).contains(&v.abs()) => format!("{v:.2}"),
        v => format!("{v:.1e}"),
    }
}

fn compare(set: &QuerySet, limits: &Limits, table: &mut Table) {
    let name = set.name.trim_start_matches("full/");
    let ours = |query: &Query| certified(set.kind, query, &CcdParams::DEFAULT);
    let exact = |query: &Query| certified(set.kind, query, &CcdParams::EXACT);
    compare_times(set, limits, table, name);
    compare_batches(set, limits, table, name);
    for (method, label) in [(&ours as &dyn Fn(&Query) -> _, "worst"), (&exact, "worst, exact")] {
        let worst = worst_time(&set.queries, method) / 1e3;
        table.row(&format!("{name}: {label} [us]"), worst, None, 100.0);
    }
    if set.is_labelled() {
        compare_answers(set, limits, table, name);
    }
}

/// Rounds of which the least time of each block counts.
const ROUNDS: usize = 15;

fn compare_times(set: &QuerySet, limits: &Limits, table: &mut Table, name: &str) {
    let kind = set.kind;
    let ours = |query: &Query| certified(kind, query, &CcdParams::DEFAULT);
    let exact = |query: &Query| certified(kind, query, &CcdParams::EXACT);
    let apart = CcdParams { min_separation: separation(&set.queries), ..CcdParams::DEFAULT };
    let apart = |query: &Query| certified(kind, query, &apart);
    let peer = |query: &Query| del_geo(kind, query);
    let plain = |query: &Query| plain_cubic(kind, query);
    let times = mean_times(&set.queries, ROUNDS, &[&ours, &exact, &apart, &peer, &plain]);
    let mut row = |what: &str, ours: f64, other: f64, allowed: f64| {
        table.row(&format!("{name}: {what} [ns]"), ours, Some(other), allowed);
    };
    row("certified / del-geo-core", times[0], times[3], limits.time);
    row("certified / plain cubic", times[0], times[4], ANY);
    row("exact / certified", times[1], times[0], ANY);
    row("separation / certified", times[2], times[0], if limits.time < ANY { 3.0 } else { ANY });

    let few = set.thinned(set.queries.len().div_ceil(60));
    let slow = |query: &Query| interval_subdivision(kind, query);
    let times = mean_times(&few, 1, &[&ours, &slow]);
    row("certified / interval subdivision", times[0], times[1], ANY);
}

/// A thousandth of the mean extent of the queries.
fn separation(queries: &[Query]) -> f64 {
    let extent =
        |query: &Query| query.x0.iter().map(|x| x.distance(query.x0[0])).fold(0.0, f64::max);
    1e-3 * queries.iter().map(extent).sum::<f64>() / as_f64(queries.len())
}

fn compare_batches(set: &QuerySet, limits: &Limits, table: &mut Table, name: &str) {
    let ([x0, x1], candidates) = set.as_motion();
    let Ok(motion) = MovingPoints::new(&x0, &x1) else { return };
    let least = |work: &dyn Fn()| {
        let best = (0..ROUNDS).map(|_| nanoseconds(work)).fold(f64::INFINITY, f64::min);
        best / as_f64(candidates.len())
    };
    let params = CcdParams::DEFAULT;
    let filter = match set.kind {
        Kind::VertexFace => MovingPoints::filter_vertex_faces,
        Kind::EdgeEdge => MovingPoints::filter_edge_edges,
    };
    let find = match set.kind {
        Kind::VertexFace => MovingPoints::vertex_face_contacts,
        Kind::EdgeEdge => MovingPoints::edge_edge_contacts,
    };
    let filtered = least(&|| drop(filter(&motion, &candidates, &params)));
    let found = least(&|| drop(find(&motion, &candidates, &params)));
    let allowed = if limits.time < ANY { 25.0 } else { ANY };
    table.row(&format!("{name}: batch, filter only [ns]"), filtered, None, allowed);
    table.row(&format!("{name}: batch, all [ns]"), found, None, ANY);
}

/// A query's time of contact, as some method answers it.
type Method<'a> = &'a dyn Fn(&Query) -> Option<f64>;

fn compare_answers(set: &QuerySet, limits: &Limits, table: &mut Table, name: &str) {
    let kind = set.kind;
    let ours = |query: &Query| certified(kind, query, &CcdParams::DEFAULT);
    let exact = |query: &Query| certified(kind, query, &CcdParams::EXACT);
    let peer = |query: &Query| del_geo(kind, query);
    let plain = |query: &Query| plain_cubic(kind, query);
    let methods: [(&str, Method<'_>); 4] =
        [("certified", &ours), ("exact", &exact), ("del-geo-core", &peer), ("plain cubic", &plain)];
    for (i, (method, answer)) in methods.into_iter().enumerate() {
        let answers = Answers::of(&set.queries, answer);
        let promised = i < 2;
        let mut row = |what: &str, value: f64, allowed: f64| {
            let allowed = if promised { allowed } else { ANY };
            table.row(&format!("{name}: {method}, {what}"), value, None, allowed);
        };
        row("missed", as_f64(answers.missed), 0.0);
        row("late", as_f64(answers.late), 0.0);
        row("false alarms", as_f64(answers.false_alarms), limits.false_alarms[i % 2]);
        row("median earliness", answers.earliness(50), limits.earliness[0]);
        row("99 % earliness", answers.earliness(99), limits.earliness[1]);
    }
}
