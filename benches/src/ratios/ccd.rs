//! Continuous collision queries beside other methods: times, missed contacts, late answers.
//!
//! The queries are the published ones in the folder `ccd` of the folder that the environment
//! variable `MUSCULO_DATA` names. Without it, random queries are timed.

use std::error::Error;
use std::io;
use std::path::Path;

use ::ccd::{CcdParams, MovingPoints};

use crate::ccd::answers::{Answers, Method, max_time, mean_times};
use crate::ccd::methods::{certified, del_geo, interval_subdivision, plain_cubic};
use crate::ccd::queries::{QueryKind, QuerySet, mean_extent, random, read};
use crate::measure::{Figure, Report, as_f64, nanoseconds};

/// No bound.
const ANY: f64 = f64::INFINITY;

/// Bounds for a set of queries.
#[derive(Clone, Copy)]
struct Limits {
    /// Time over that of the uncertified cubic of `del-geo-core`.
    time: f64,
    /// Time of separations over that without \[ratio\], and of the filter of a batch \[ns\].
    separation: f64,
    filter: f64,
    /// False alarms without and with exact arithmetic.
    false_alarms: [f64; 2],
    /// Earliness of reported times, median and 99th percentile \[share of the step\].
    earliness: [f64; 2],
}

/// Broad-phase candidates of simulations, nearly all without contact.
const CANDIDATES: Limits = Limits {
    time: 1.0,
    separation: 3.0,
    filter: 25.0,
    false_alarms: [0.0, 0.0],
    earliness: [1e-12, 1e-8],
};
/// Contacts of simulations.
const CONTACTS: Limits = Limits { time: 1.6, ..CANDIDATES };
/// Degenerate cases: only safety and exactness are promised.
const DEGENERATE: Limits = Limits {
    time: ANY,
    separation: ANY,
    filter: ANY,
    false_alarms: [ANY, 0.0],
    earliness: [ANY, ANY],
};

/// Rounds at full effort, of which the minimum time of each block counts.
const ROUNDS: usize = 15;

/// Compares all sets of queries.
pub(super) fn run(report: &mut Report) -> Result<(), Box<dyn Error>> {
    for (queries, limits) in sets()? {
        Comparison { set: &queries, limits, report }.run();
    }
    Ok(())
}

fn sets() -> io::Result<Vec<(QuerySet, Limits)>> {
    let Some(data) = std::env::var_os("MUSCULO_DATA") else {
        let kinds = [QueryKind::VertexFace, QueryKind::EdgeEdge];
        return Ok(kinds.map(|kind| (random(kind, 20_000), DEGENERATE)).into());
    };
    let files = [
        ("full/simbp", CANDIDATES),
        ("full/simhard", CONTACTS),
        ("handcrafted", DEGENERATE),
        ("adversarial", DEGENERATE),
        ("vertextouch", DEGENERATE),
    ];

    let folder = Path::new(&data).join("ccd");
    let mut sets = Vec::new();
    for (name, limits) in files {
        for kind in ["vf", "ee"] {
            sets.push((read(&folder, &format!("{name}_{kind}"))?, limits));
        }
    }
    Ok(sets)
}

/// One set of queries, answered by every method.
struct Comparison<'a> {
    set: &'a QuerySet,
    limits: Limits,
    report: &'a mut Report,
}

impl Comparison<'_> {
    fn run(mut self) {
        self.times();
        self.batches();
        self.slowest();
        if self.set.is_labelled() {
            self.answers();
        }
    }

    fn add(&mut self, what: &str, ours: f64, other: Option<f64>, unit: &'static str, allowed: f64) {
        let name = format!("{}: {what}", self.set.name.trim_start_matches("full/"));
        self.report.add(&Figure { name, ours, other, unit, allowed });
    }

    fn times(&mut self) {
        let (kind, queries) = (self.set.kind, &self.set.queries);
        let apart = CcdParams { min_separation: 1e-3 * mean_extent(queries), ..CcdParams::DEFAULT };
        let methods: [Method<'_>; 5] = [
            &|query| certified(kind, query, &CcdParams::DEFAULT),
            &|query| certified(kind, query, &CcdParams::EXACT),
            &|query| certified(kind, query, &apart),
            &|query| del_geo(kind, query),
            &|query| plain_cubic(kind, query),
        ];
        let times = mean_times(queries, self.report.rounds(ROUNDS), &methods);
        let [ours, exact, apart, peer, cubic] = times[..] else { return };
        self.add("certified / del-geo-core", ours, Some(peer), "ns", self.limits.time);
        self.add("certified / plain cubic", ours, Some(cubic), "ns", ANY);
        self.add("exact / certified", exact, Some(ours), "ns", ANY);
        self.add("separation / certified", apart, Some(ours), "ns", self.limits.separation);

        // Subdivision takes a thousand times as long: it answers few queries.
        let few = self.set.thinned(queries.len().div_ceil(60));
        let times = mean_times(&few, 1, &[methods[0], &|query| interval_subdivision(kind, query)]);
        self.add("certified / interval subdivision", times[0], Some(times[1]), "ns", ANY);
    }

    fn batches(&mut self) {
        let ([x0, x1], candidates) = self.set.as_motion();
        let Ok(motion) = MovingPoints::new(&x0, &x1) else { return };
        let (filter, find): (Batch<'_>, Batch<'_>) = match self.set.kind {
            QueryKind::VertexFace => (
                &|params| motion.filter_vertex_faces(&candidates, params).map_or(0, |c| c.len()),
                &|params| motion.vertex_face_contacts(&candidates, params).map_or(0, |c| c.len()),
            ),
            QueryKind::EdgeEdge => (
                &|params| motion.filter_edge_edges(&candidates, params).map_or(0, |c| c.len()),
                &|params| motion.edge_edge_contacts(&candidates, params).map_or(0, |c| c.len()),
            ),
        };
        let least = |batch: Batch<'_>| {
            let time = |_| nanoseconds(|| batch(&CcdParams::DEFAULT));
            let least = (0..self.report.rounds(ROUNDS)).map(time).fold(f64::INFINITY, f64::min);
            least / as_f64(candidates.len())
        };
        let [filter, find] = [filter, find].map(least);
        self.add("batch, filter only", filter, None, "ns", self.limits.filter);
        self.add("batch, all", find, None, "ns", ANY);
    }

    fn slowest(&mut self) {
        let kind = self.set.kind;
        for (label, params) in
            [("slowest", CcdParams::DEFAULT), ("slowest, exact", CcdParams::EXACT)]
        {
            let time = max_time(&self.set.queries, &|query| certified(kind, query, &params));
            self.add(label, time * 1e-3, None, "us", 100.0);
        }
    }

    fn answers(&mut self) {
        let kind = self.set.kind;
        let [inexact, exact] = self.limits.false_alarms;
        let promised = |false_alarms| AnswerLimits {
            wrong: 0.0,
            false_alarms,
            earliness: self.limits.earliness,
        };
        let none = AnswerLimits { wrong: ANY, false_alarms: ANY, earliness: [ANY; 2] };

        let methods: [(&str, Method<'_>, AnswerLimits); 4] = [
            ("certified", &|q| certified(kind, q, &CcdParams::DEFAULT), promised(inexact)),
            ("exact", &|q| certified(kind, q, &CcdParams::EXACT), promised(exact)),
            ("del-geo-core", &|q| del_geo(kind, q), none),
            ("plain cubic", &|q| plain_cubic(kind, q), none),
        ];
        for (method, answer, limits) in methods {
            let answers = Answers::new(&self.set.queries, answer);
            for (what, value, allowed) in [
                ("missed", as_f64(answers.missed), limits.wrong),
                ("late", as_f64(answers.late), limits.wrong),
                ("false alarms", as_f64(answers.false_alarms), limits.false_alarms),
                ("median earliness", answers.earliness(50), limits.earliness[0]),
                ("99 % earliness", answers.earliness(99), limits.earliness[1]),
            ] {
                self.add(&format!("{method}, {what}"), value, None, "", allowed);
            }
        }
    }
}

/// Bounds on the answers of one method.
#[derive(Clone, Copy)]
struct AnswerLimits {
    /// Missed contacts, and late ones.
    wrong: f64,
    false_alarms: f64,
    /// Median and 99th percentile \[share of the step\].
    earliness: [f64; 2],
}

/// A query of all candidates of a motion: returns how many it finds.
type Batch<'a> = &'a dyn Fn(&CcdParams) -> usize;
